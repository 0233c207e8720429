"""Study: how well do maps tell where a hidden target is, and do tags on other items help? In bits and ranks."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.evaluation.map_quality import map_quality
from rfcompass.evaluation.records import MetricValue
from rfcompass.mapping import (
    RfKernels,
    TargetKernel,
    VisualMap,
    box_target,
    fuse_maps,
    gaussian_target,
    map_views,
    occupancy_map,
    posterior_map,
    rf_certainty_map,
)
from rfcompass.mapping.item_lookup import SIGMA_M
from rfcompass.simulation.piles import PileScan, PileScene, PileWorld, TaggedItems, scan_pile, tag_items
from rfcompass.studies.metric import Metric
from rfcompass.studies.pile_scan import located, workspace, wrist_way
from rfcompass.studies.pile_scenes import FAMILIES, pile_scene
from rfcompass.studies.study import Cell, Study
from rfcompass.types import ItemSize, LocatedItem, TagFix, TaggedItem, VoxelGrid

TAGS, FEW, SPACING_M = 8, 4, 0.01
READINGS = ("consistent", "literal_cm", "literal_m")
FIXES = ("exact", "noisy")


@dataclass(frozen=True, slots=True)
class LocatedTag:
    """One tag, how far its place is off, and what the database says of its item.

    Attributes:
        size: The item.
        point_m: Where the tag is thought to be [m], shape (3,).
        sigma_m: Standard deviation that estimators are told [m].
    """

    size: ItemSize
    point_m: FloatArray
    sigma_m: float

    def for_paper(self, *, rigid: bool = False) -> LocatedItem:
        """As the paper's map takes it; `rigid` takes soft items for rigid ones."""
        size = self.size
        fix = TagFix(str(size.epc), self.point_m, np.full(3, 4 * self.sigma_m), confident=True)
        return LocatedItem(fix, size.name, size.shortest_m, size.longest_m, size.deformable and not rigid)

    def for_posterior(self) -> TaggedItem:
        """As the posterior takes it."""
        return TaggedItem(self.size, self.point_m, np.eye(3) * self.sigma_m**2)


@dataclass(frozen=True, slots=True)
class Seen:
    """What cameras told, and what all maps share."""

    visual: VisualMap
    c: VoxelGrid
    heights_m: FloatArray
    target: ItemSize
    gaussian: TargetKernel

    def paper(self, tags: Sequence[LocatedTag], reading: str, *, rigid: bool = False) -> tuple[VoxelGrid, VoxelGrid]:
        """C + R, and the same convolved with the target's kernel."""
        items = [tag.for_paper(rigid=rigid) for tag in tags]
        kernels = RfKernels(reading=reading)
        radio = rf_certainty_map(items, self.visual.workspace, heights_m=self.heights_m, kernels=kernels)
        fused = fuse_maps(self.c, radio.grid)
        return fused, occupancy_map(fused, self.gaussian)

    def posterior(self, tags: Sequence[LocatedTag] = ()) -> VoxelGrid:
        """Our posterior."""
        return posterior_map(self.visual, self.target, [tag.for_posterior() for tag in tags])


def seen_by(scan: PileScan, target: ItemSize) -> Seen:
    """Map the views of a scan."""
    visual = map_views(workspace(SPACING_M), scan.views)
    gaussian = gaussian_target(target.shortest_m, target.longest_m, SPACING_M)
    return Seen(visual, visual.uncertainty(), visual.heights_m(), target, gaussian)


def maps(seen: Seen, by_fix: Mapping[str, Sequence[LocatedTag]]) -> Iterator[tuple[str, VoxelGrid]]:
    """Every map that is judged, by its name."""
    table = seen.visual.workspace
    yield "uniform", table.grid(np.ones(table.shape))
    yield "c", seen.c
    yield "map_0", occupancy_map(seen.c, seen.gaussian)
    yield "box_0", occupancy_map(seen.c, box_target(seen.target.size_m, SPACING_M))
    yield "posterior_0", seen.posterior()
    for fix in FIXES:
        for count in (FEW, TAGS):
            tags = by_fix[fix][:count]
            for reading in READINGS:
                fused, convolved = seen.paper(tags, reading)
                yield f"cr_{reading}_{count}_{fix}", fused
                yield f"map_{reading}_{count}_{fix}", convolved
            yield f"posterior_{count}_{fix}", seen.posterior(tags)
    yield "map_as_rigid_8_exact", seen.paper(by_fix["exact"], "consistent", rigid=True)[1]
    yield "map_consistent_8_radio", seen.paper(by_fix["radio"], "consistent")[1]
    yield "posterior_8_radio", seen.posterior(by_fix["radio"])


def kinds_of_items(seen: Seen, tags: Sequence[LocatedTag]) -> Iterator[tuple[str, VoxelGrid | None]]:
    """The same with four tags on rigid items, or on covers, alone; None where there are not so many."""
    for kind, deformable in (("rigid", False), ("covers", True)):
        chosen = [tag for tag in tags if tag.size.deformable == deformable][:FEW]
        whole = len(chosen) == FEW
        yield f"map_4_{kind}", seen.paper(chosen, "consistent")[1] if whole else None
        yield f"posterior_4_{kind}", seen.posterior(chosen) if whole else None


def map_quality_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:
    """Scan one pile and judge every map of it."""
    scene, way = pile_scene(str(cell["family"]), seed), wrist_way("two")
    world = scene.world()
    every = _all_tagged(scene, rng)
    chosen = replace(every, tags=every.tags[:TAGS], sizes=every.sizes[:TAGS])
    scan = scan_pile(world, chosen, way.camera_poses, way.track, rng)
    seen, true_m = seen_by(scan, every.target_size), world.pose(scene.target)[:3, 3]
    exact = _exact(world, every)
    by_fix = {
        "exact": exact[:TAGS],
        "noisy": [_off(tag, SIGMA_M * rng.normal(size=3)) for tag in exact[:TAGS]],
        "radio": _by_radio(scan, chosen),
    }
    judged: dict[str, MetricValue] = {}
    for name, grid in (*maps(seen, by_fix), *kinds_of_items(seen, exact)):
        quality = None if grid is None else map_quality(grid, true_m, seen.visual.unobserved)
        judged[f"bits_{name}"] = None if quality is None else quality.bits
        judged[f"rank_{name}"] = None if quality is None else quality.rank
    return {
        "scene": scene.fingerprint,
        "tags": float(len(by_fix["exact"])),
        "by_radio": float(len(by_fix["radio"])),
        "hidden_m3": seen.visual.unobserved_m3,
        **judged,
        **{f"gain_{name}": _gain(judged, name) for name in GAINS},
    }


def _gain(judged: Mapping[str, MetricValue], name: str) -> float | None:
    """Bits that a map with tags saves against the same without."""
    without, with_tags = judged[f"bits_{GAINS[name]}"], judged[f"bits_{name}"]
    if not (isinstance(without, float) and isinstance(with_tags, float)):
        return None
    return without - with_tags


def _all_tagged(scene: PileScene, rng: np.random.Generator) -> TaggedItems:
    taggable = sum(item.taggable and item.number != scene.target for item in scene.items)
    return tag_items(scene, "any", taggable, rng)


def _exact(world: PileWorld, tags: TaggedItems) -> list[LocatedTag]:
    epcs, points_m, _ = tags.placed(world)
    sizes = {size.epc: size for size in tags.sizes}
    return [LocatedTag(sizes[epc], point_m, 0.0) for epc, point_m in zip(epcs, points_m, strict=True)]


def _off(tag: LocatedTag, off_m: FloatArray) -> LocatedTag:
    return LocatedTag(tag.size, tag.point_m + off_m, SIGMA_M)


def _by_radio(scan: PileScan, tags: TaggedItems) -> list[LocatedTag]:
    """Tags that are located confidently from the reads of the scan."""
    sizes = {str(size.epc): size for size in tags.sizes}
    found = located(scan.scan(sizes), list(sizes))
    return [LocatedTag(sizes[fix.epc], fix.point_m, SIGMA_M) for fix in found.confident]


_PAPER = tuple(
    (f"{what}_{reading}_{count}_{fix}", "c" if what == "cr" else "map_0")
    for what in ("cr", "map")
    for reading in READINGS
    for count in (FEW, TAGS)
    for fix in FIXES
)
_OURS = tuple((f"posterior_{count}_{fix}", "posterior_0") for count in (FEW, TAGS) for fix in FIXES)
# Maps with tags, and the same map without.
GAINS: Mapping[str, str] = dict(
    (
        *_PAPER,
        *_OURS,
        ("map_as_rigid_8_exact", "map_0"),
        ("map_consistent_8_radio", "map_0"),
        ("posterior_8_radio", "posterior_0"),
        ("map_4_rigid", "map_0"),
        ("map_4_covers", "map_0"),
        ("posterior_4_rigid", "posterior_0"),
        ("posterior_4_covers", "posterior_0"),
    )
)
NAMES = ("uniform", "c", "map_0", "box_0", "posterior_0", *GAINS)

MAP_QUALITY = Study(
    name="map-quality",
    title="Maps of where a hidden target is",
    kind="simulated",
    factors={"family": FAMILIES},
    seeds=range(1000, 1067),
    tuning_seeds=range(12),
    trial=map_quality_trial,
    metrics=(
        Metric("scene", (), "text"),
        Metric("tags", ("mean",), "float", "tagged items"),
        Metric("by_radio", ("mean",), "float", "of them located confidently by radio"),
        Metric("hidden_m3", ("median",), "float", "unobserved volume", "l", 1000.0),
        *(Metric(f"bits_{name}", ("mean",), "float", f"log-loss, {name}", "bit", 1.0, 2) for name in NAMES),
        *(Metric(f"rank_{name}", ("mean", "median"), "float", f"rank, {name}", "%", 100.0) for name in NAMES),
        *(Metric(f"gain_{name}", ("mean",), "float", f"saved by tags, {name}", "bit", 1.0, 2) for name in GAINS),
    ),
    note=(
        "Piles at rest whose target no view sees. Log-loss: -log2 of the probability of the voxel of 1 cm that holds "
        "the target's middle, with 1 % of every map spread evenly over all voxels. Rank: share of the unobserved "
        "voxels that are likelier, ties by half. c is the paper's visual map, cr its sum with the RF map, map the sum "
        "convolved with the paper's target kernel, box with the target's own; posterior is ours. 4 or 8 tags on any "
        "distractors; noisy fixes are off by 3.6 cm in the median, radio means the whole chain. Numbers of the "
        "posterior were fitted on seeds below 12."
    ),
)
