"""How many poured piles are what was asked for, what one costs, and whether they rest: the table of docs/piles.md.

For each family and class of target it makes one scene for each seed, and prints the share of tries that gave a scene,
where the others ended, CPU time for each scene, and how far items move when nobody does anything: over the two seconds
that every scene was checked for, and over ten, which it was not.

    python -m benchmarks.pile_acceptance --seeds 1000:1010 --families poured_1p10 covered_1p10

With `--take N` it takes the N topmost items besides the target from each scene instead, one after the other, and prints
how the rest settles each time.
"""

import argparse
import time
from collections.abc import Sequence

import numpy as np

from rfcompass.errors import NoPile
from rfcompass.simulation.piles import FAMILIES, TARGET_CLASSES, PileTally, make_pile

LONG_S = 10.0
HEAD = (
    "| family | target | scenes / tries | ended: unsettled, target, composed, creeping | CPU s a scene "
    "| moves in 2 s, median item, worst item [mm] | in 10 s, median, worst [mm] |\n|---|---|---|---|---|---|---|"
)

HEAD_TAKEN = (
    "| family | target | at rest / taken | s until then, median, longest | CPU s | then moves in 2 s, median, "
    "95 %, worst item [mm] |\n|---|---|---|---|---|---|"
)


def row(family: str, target_class: str, seeds: Sequence[int]) -> str:
    """One line of the table."""
    tally, short_mm, long_mm, spent_s, missing = PileTally(), [], [], 0.0, 0
    for seed in seeds:
        start = time.process_time()
        try:
            scene = make_pile(family, seed, target_class, tally=tally)
        except NoPile:
            missing += 1
            continue
        finally:
            spent_s += time.process_time() - start
        short_mm += [1e3 * moved for moved in scene.world().creep_m().values()]
        long_mm += [1e3 * moved for moved in scene.world().creep_m(LONG_S).values()]
    if not tally.made:
        return f"| {family} | {target_class} | 0 / {tally.tries} | {tally.failed} | - | - | - |"
    ended = ", ".join(str(count) for count in tally.failed.values())
    creep = [f"{np.median(moves):.2f}, {np.max(moves):.1f}" for moves in (short_mm, long_mm)]
    gone = f" ({missing} seeds gave none)" if missing else ""
    cost = f"{spent_s / tally.made:.1f}"
    return (
        f"| {family} | {target_class} | {tally.made} / {tally.tries}{gone} | {ended} | {cost} | {' | '.join(creep)} |"
    )


def taken(family: str, target_class: str, seeds: Sequence[int], count: int) -> str:
    """One line of the table of how piles settle when items are taken."""
    rests, spent_s, moves_mm = [], [], []
    for seed in seeds:
        scene = make_pile(family, seed, target_class)
        world = scene.world()
        for _ in range(count):
            others = [item.number for item in world.items if item.number != scene.target]
            world.remove(max(others, key=lambda number, world=world: world.pose(number)[2, 3]))
            start = time.process_time()
            rests.append(world.settle())
            spent_s.append(time.process_time() - start)
            moves_mm += [1e3 * moved for moved in world.creep_m().values()]
    still, passed_s = sum(rest.at_rest for rest in rests), [rest.passed_s for rest in rests]
    times = f"{np.median(passed_s):.2f}, {np.max(passed_s):.2f}"
    creep = f"{np.median(moves_mm):.2f}, {np.percentile(moves_mm, 95):.2f}, {np.max(moves_mm):.1f}"
    return f"| {family} | {target_class} | {still} / {len(rests)} | {times} | {np.median(spent_s):.2f} | {creep} |"


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="1000:1010", help="first:last+1; results are reported on seeds from 1000 on")
    parser.add_argument("--families", nargs="*", default=list(FAMILIES))
    parser.add_argument("--classes", nargs="*", default=list(TARGET_CLASSES))
    parser.add_argument("--take", type=int, default=0, help="take so many items from each scene instead")
    asked = parser.parse_args(argv)
    first, last = (int(end) for end in asked.seeds.split(":"))
    print(HEAD_TAKEN if asked.take else HEAD)
    for name in asked.families:
        for target_class in asked.classes:
            made = (name, target_class, range(first, last))
            print(taken(*made, asked.take) if asked.take else row(*made), flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
