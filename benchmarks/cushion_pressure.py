"""How far cushions give way in piles: the figures of docs/piles.md.

    python -m benchmarks.cushion_pressure --seeds 0:10 --family soft_1p10

A cushion lies at the bottom if it touches the table, and carries something if its spring has given by 1 % or more.
"""

import argparse
from collections.abc import Sequence

import numpy as np

from rfcompass.errors import NoPile
from rfcompass.simulation.piles import PileTally, PileWorld, make_pile

CARRIES, ON_TABLE_M = 0.01, 0.002


def shares(world: PileWorld) -> list[tuple[float, bool]]:
    """Share of its thickness by which each cushion has given way, and whether it lies at the bottom."""
    cushions = [item for item in world.items if item.kind == "cushion"]
    return [
        (
            float(-world.states[item.number][-1] / item.size_m[2]),
            bool(world.corners_m(item.number)[:, 2].min() < ON_TABLE_M),
        )
        for item in cushions
    ]


def main(argv: Sequence[str] | None = None) -> int:
    """Print one line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="0:10", help="first:last")
    parser.add_argument("--family", default="soft_1p10")
    asked = parser.parse_args(argv)
    first, last = (int(part) for part in asked.seeds.split(":"))
    found, tally = [], PileTally()
    for seed in range(first, last):
        try:
            found += shares(make_pile(asked.family, seed, "hidden", tally=tally).world())
        except NoPile:
            continue
    bottom = [share for share, low in found if low]
    carry = [share for share in bottom if share >= CARRIES]
    quantiles = ", ".join(f"{100 * q:.0f}" for q in np.quantile(carry, [0.1, 0.25, 0.5, 0.75, 0.9])) if carry else "-"
    print(
        f"{asked.family}: {tally.made} scenes of {tally.tries} tries, {tally.failed}; {len(found)} cushions, "
        f"{len(bottom)} at the bottom, {len(carry)} of them carry something: "
        f"given way by {quantiles} % (10, 25, 50, 75, 90 % quantiles)"
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
