"""How many poured piles are what was asked for, what one costs, and whether they rest: the table of docs/piles.md.

For each family and class of target it makes one scene for each seed, and prints the share of tries that gave a scene,
where the others ended, CPU time for each scene, and how far items move when nobody does anything: over the two seconds
that every scene was checked for, and over ten, which it was not.

    python -m benchmarks.pile_acceptance --seeds 1000:1010 --families poured_1p10 covered_1p10
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


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="1000:1010", help="first:last+1; results are reported on seeds from 1000 on")
    parser.add_argument("--families", nargs="*", default=list(FAMILIES))
    parser.add_argument("--classes", nargs="*", default=list(TARGET_CLASSES))
    asked = parser.parse_args(argv)
    first, last = (int(end) for end in asked.seeds.split(":"))
    print(HEAD)
    for name in asked.families:
        for target_class in asked.classes:
            print(row(name, target_class, range(first, last)), flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
