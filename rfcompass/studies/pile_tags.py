"""Study: Table 5 of [Boroushaki2023] through the whole chain: piles, an arm with two antennas, clutter, many tags."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.evaluation.records import MetricValue
from rfcompass.simulation.piles import PileScan, PileWorld, TaggedItems, scan_pile, tag_cover, tag_items
from rfcompass.studies.metric import SHARE, Metric
from rfcompass.studies.pile_scan import located, wrist_way
from rfcompass.studies.pile_scenes import FAMILIES, pile_scene
from rfcompass.studies.study import Cell, PaperValue, Study
from rfcompass.types.fixes import TagFix

TAGS = 10
TAG_LENGTH_M = 0.094  # Alien Squiggle; errors are to the nearest point of the tag
# A tag is in sight if nothing lies on the straight line from at least half of the antenna positions; ours.
HIDDEN_SHARE = 0.5
LAYERS = ("0", "1", "2", "3")  # things on the line, in the mean over the way; the last one and more
MATERIALS = ("cloth", "foam", "plastic", "card", "liquid", "metal")
TABLE_5 = "[Boroushaki2023] Table 5, LOS and NLOS together"


class OneTag(NamedTuple):
    """What came of one tag, and what lay over it.

    Attributes:
        nearest_m: From the fix to the nearest point of the tag [m]; None if it was not located.
        height_off_m: Height of the fix less the true one [m].
        confident: Whether its box is small enough.
        read_share: Share of the antenna positions at which it was read.
        in_sight: Whether at least half of the lines are free.
        layers: One of `LAYERS`.
        material: What most things on the lines are made of; `""` if there are none.
    """

    nearest_m: float | None
    height_off_m: float | None
    confident: bool
    read_share: float
    in_sight: bool
    layers: str
    material: str


def tags_of_scan(world: PileWorld, tags: TaggedItems, scan: PileScan, positions_m: FloatArray) -> list[OneTag]:
    """Locate every tag and compare with where it is.

    Args:
        world: The pile as it was scanned.
        tags: Its tags.
        scan: What was handed out.
        positions_m: Where the arm believed the receiving antenna [m], shape (M, 3).
    """
    epcs, points_m, dipoles = tags.placed(world)
    found, cover = located(scan.scan(epcs), epcs), tag_cover(world, tags, positions_m)
    rows = []
    for t, epc in enumerate(epcs):
        fix = found.fixes.get(epc)
        off_m = None if fix is None else fix.point_m - points_m[t]
        read = np.unique(scan.inventory.poses[scan.inventory.tags == t]).size / len(positions_m)
        rows.append(
            OneTag(
                _nearest_m(fix, points_m[t], dipoles[t]),
                None if off_m is None else float(off_m[2]),
                fix is not None and fix.confident,
                float(read),
                bool(cover.hidden_share[t] < HIDDEN_SHARE),
                LAYERS[min(round(float(cover.things[:, t].mean())), len(LAYERS) - 1)],
                cover.material[t],
            )
        )
    return rows


def _nearest_m(fix: TagFix | None, point_m: FloatArray, dipole: FloatArray) -> float | None:
    if fix is None:
        return None
    off_m = fix.point_m - point_m
    along_m = np.clip(off_m @ dipole, -TAG_LENGTH_M / 2, TAG_LENGTH_M / 2)
    return float(np.linalg.norm(off_m - along_m * dipole))


def pile_tags_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:
    """Scan one pile and locate its tags."""
    scene, way = pile_scene(str(cell["family"]), seed), wrist_way(str(cell["rounds"]))
    world = scene.world()
    taggable = sum(item.taggable and item.number != scene.target for item in scene.items)
    tags = tag_items(scene, "any", min(TAGS, taggable), rng)
    scan = scan_pile(world, tags, way.camera_poses, way.track, rng)
    rows = tags_of_scan(world, tags, scan, way.track.positions_m)
    return {"tags": float(len(rows)), "scene": scene.fingerprint, **_metrics(rows)}


def _metrics(rows: list[OneTag]) -> dict[str, MetricValue]:
    def errors(*chosen: OneTag) -> list[float]:
        return [row.nearest_m for row in chosen if row.nearest_m is not None]

    metrics: dict[str, MetricValue] = {
        "located": [float(row.nearest_m is not None) for row in rows],
        "confident": [float(row.confident) for row in rows],
        "nearest_m": errors(*rows),
        "nearest_los_m": errors(*(row for row in rows if row.in_sight)),
        "nearest_nlos_m": errors(*(row for row in rows if not row.in_sight)),
        "nearest_confident_m": errors(*(row for row in rows if row.confident)),
        "nearest_unsure_m": errors(*(row for row in rows if not row.confident)),
        "height_off_m": [row.height_off_m for row in rows if row.height_off_m is not None],
    }
    for name, of in _groups(rows):
        metrics[f"read_{name}"] = [row.read_share for row in of]
        metrics[f"confident_{name}"] = [float(row.confident) for row in of]
        metrics[f"nearest_{name}_m"] = errors(*of)
    return metrics


def _groups(rows: list[OneTag]) -> list[tuple[str, list[OneTag]]]:
    """Tags by the number of things over them, and by what these are made of."""
    by_layers = [(f"layers_{name}", [row for row in rows if row.layers == name]) for name in LAYERS]
    return by_layers + [(name, [row for row in rows if row.material == name]) for name in MATERIALS]


def _group_metrics() -> tuple[Metric, ...]:
    titles = [(f"layers_{name}", f"{name}{' or more' if name == LAYERS[-1] else ''} things over it") for name in LAYERS]
    titles += [(name, f"mostly {name} over it") for name in MATERIALS]
    return tuple(
        metric
        for name, title in titles
        for metric in (
            Metric(
                f"read_{name}", ("mean",), "samples", f"antenna positions at which it was read, {title}", "%", 100.0
            ),
            Metric(f"confident_{name}", (SHARE,), "samples", f"confident, {title}", "%", 100.0),
            Metric(f"nearest_{name}_m", ("median",), "samples", f"nearest point, {title}", "cm", 100.0),
        )
    )


PILE_TAGS = Study(
    name="pile-tags",
    title="Tags in piles, located from the arm",
    kind="simulated",
    factors={"family": FAMILIES, "rounds": ("one", "two")},
    seeds=range(1000, 1025),
    tuning_seeds=range(12),
    trial=pile_tags_trial,
    metrics=(
        Metric("tags", ("mean",), "float", "tags in a pile"),
        Metric("scene", (), "text"),
        Metric("located", (SHARE,), "samples", "located", "%", 100.0),
        Metric("confident", (SHARE,), "samples", "confident", "%", 100.0),
        Metric("nearest_m", ("median", "p90"), "samples", "error to the nearest point of the tag", "cm", 100.0),
        Metric("nearest_los_m", ("median", "p90"), "samples", "the same, in sight", "cm", 100.0),
        Metric("nearest_nlos_m", ("median", "p90"), "samples", "the same, hidden", "cm", 100.0),
        Metric("nearest_confident_m", ("median", "p90"), "samples", "the same, confident fixes", "cm", 100.0),
        Metric("nearest_unsure_m", ("median", "p90"), "samples", "the same, the others", "cm", 100.0),
        Metric("height_off_m", ("median",), "samples", "height less true height", "cm", 100.0),
        *_group_metrics(),
    ),
    paper=tuple(
        PaperValue(
            "nearest_m", summary, value, TABLE_5, "37 runs on a real robot; its bands, path and piles are not printed"
        )
        for summary, value in (("median", 0.036), ("p90", 0.06))
    ),
    note=(
        "Up to ten tags on the distractors of a pile at rest, on any side of an item, turned anyhow; the target is "
        "hidden and has none. A UR5e carries camera and antennas round a square (one), or round a second, lower and "
        "wider one as well (two). Boxes of 0.20 x 0.20 x 0.30 m count as confident, chosen on seeds below 20. In "
        "sight: nothing on the straight line from at least half of the antenna positions, the tag's own item "
        "included. The arm and the metal in the pile scatter nothing, tags do not detune each other, and height is "
        "searched from the table up."
    ),
)
