"""Locate tags from the wrist: FuseBot's antennas go round a square above a table and tell where every tag is.

Five tagged items lie on the table. The wrist goes round once; a tag whose confidence box is too large gets advice what
to measure next. Then the wrist goes round once more, 25 cm higher, as one of the options was. The antennas are linear,
along x: the last tag lies across them, and is heard by what reflections turn.

You will see how far off each tag is, its box and the advice, after one round and after two, and get `tags.png`.
Takes 5 s.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rfcompass.localization import LocatedTags, MeasureMore, locate_all
from rfcompass.simulation import (
    RIG_WRIST,
    SQUIGGLE,
    AntennaTrack,
    PlacedTags,
    inventory_scan,
    load_recipe,
    simulate_inventory,
)
from rfcompass.types import SearchVolume

ITEMS = ("mug", "toy", "box", "book", "brush")
TAGS_M = np.array([[1.80, 2.12, 0.03], [2.18, 2.20, 0.06], [2.05, 1.95, 0.12], [2.20, 1.82, 0.09], [1.88, 1.80, 0.02]])
TURNS_RAD = np.radians([0.0, 20.0, 45.0, -30.0, 90.0])  # of each tag's dipole, from x
EPCS = [f"5246434f4d50415353ea000{k}" for k in range(len(ITEMS))]
TABLE = SearchVolume(np.array([1.65, 1.65, 0.0]), np.array([2.35, 2.35, 0.25]))
AXES = ((0, 1), (0, 2))  # from above and from the side


def advice_text(more: MeasureMore | None) -> str:
    """What to measure next, in a line."""
    if more is None:
        return "confident"
    best = more.options[0]
    box_cm = " x ".join(f"{100 * side_m:.0f}" for side_m in best.box_m)
    says = "enough" if best.enough else "not enough"
    return f"wide along {', '.join(more.wide_axes) or 'none, but cut off'}; {best.aid} would give {box_cm} cm, {says}"


def tell(title: str, found: LocatedTags) -> None:
    """Print a line for each tag."""
    print(title)
    for item, epc, tag_m in zip(ITEMS, EPCS, TAGS_M, strict=True):
        if epc in found.refusals:
            print(f"  {item:<6} {found.refusals[epc].message}")
            continue
        fix = found.fixes[epc]
        off_cm, box_cm = 100 * np.linalg.norm(fix.point_m - tag_m), " x ".join(f"{100 * s:.0f}" for s in fix.box_m)
        print(f"  {item:<6} {off_cm:4.1f} cm off, box {box_cm:>12} cm: {advice_text(found.advice.get(epc))}")


def draw(found: LocatedTags, track: AntennaTrack) -> Figure:
    """Draw places, boxes and the wrist's way from above and from the side."""
    figure = Figure(figsize=(11, 5), layout="constrained")
    for (a, b), axes in zip(AXES, figure.subplots(1, 2), strict=True):
        axes.plot(track.positions_m[:, a], track.positions_m[:, b], ".", color="#9aa7b2", label="wrist")
        axes.plot(TAGS_M[:, a], TAGS_M[:, b], "k+", ms=10, label="true place")
        for epc, fix in found.fixes.items():
            colour, half_m = "#3b6ea5" if fix.confident else "#d1495b", fix.box_m / 2
            x, y = fix.point_m[a], fix.point_m[b]
            axes.errorbar(x, y, xerr=half_m[a], yerr=half_m[b], fmt="o", color=colour, capsize=3)
            axes.annotate(ITEMS[EPCS.index(epc)], (x, y), xytext=(6, 6), textcoords="offset points")
        axes.set(xlabel=f"{'xyz'[a]} [m]", ylabel=f"{'xyz'[b]} [m]", aspect="equal")
    figure.axes[0].set_title("Size of each box; blue: confident, red: not", loc="left")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def main(fast: bool = False, out: Path = Path("runs/08_wrist")) -> LocatedTags:
    """Go round once and twice; return what was found in the end."""
    rng = np.random.default_rng(0)
    dipoles = np.column_stack([np.cos(TURNS_RAD), np.sin(TURNS_RAD), np.zeros(len(ITEMS))])
    tags = PlacedTags.draw(EPCS, TAGS_M, dipoles, SQUIGGLE, rng)
    scene = load_recipe("tabletop").draw(rng, part_m=(2.0, 2.0))
    low, high = (AntennaTrack.square((2.0, 2.0), side_m=0.5, height_m=height_m) for height_m in (0.35, 0.60))

    def located_along(track: AntennaTrack) -> LocatedTags:
        went = track.perturbed(rng, jitter_m=0.001)  # the arm knows its antennas to a millimetre
        inventory = simulate_inventory(scene, RIG_WRIST, went, tags, rng, nominal_track=track)
        return locate_all(inventory_scan(inventory, EPCS), TABLE, epcs=EPCS)

    tell("One round, 35 cm above the table", located_along(low))
    both = low.then(high)
    found = located_along(both)
    tell("Two rounds, at 35 and 60 cm", found)
    out.mkdir(parents=True, exist_ok=True)
    draw(found, both).savefig(out / "tags.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'tags.png'}")
    return found


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
