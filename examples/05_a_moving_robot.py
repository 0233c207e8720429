"""A moving robot: every stop cuts the plane anew, and old stops count as long as odometry can be trusted.

The whole loop of RF-Compass in an empty room: drive half the way, scan, localise, until the part is in reach;
then move the hand over it. Proximities are true distances times 5 % noise, so some comparisons are wrong.

You will see the estimate of each stop, and get `approach.png`. Takes 5 s.
"""

import sys
from pathlib import Path

import numpy as np

from rfcompass import PartDatabase, PartitionLocalizer, YouBot
from rfcompass.studies.fetch_pictures import draw_approach
from rfcompass.studies.fetching import FetchTask, JudgedStep, SimulatedFetch


def main(fast: bool = False, out: Path = Path("runs/05_moving_robot")) -> list[JudgedStep]:
    """Fetch once; return every step with its error."""
    task = FetchTask(
        robot=YouBot(),
        part=PartDatabase(":memory:").part("table_leg_3"),
        tags=4,
        localizer=PartitionLocalizer(),
        seed=1,
    )
    steps = []
    for judged in SimulatedFetch(task).steps():
        steps.append(judged)
        turned = judged.theta_error_rad
        theta = "not observable" if turned is None else f"{np.degrees(turned):5.1f}° off"
        print(f"{judged.step.phase:<9} D {judged.step.estimate.distance_m:4.2f} m, "
              f"centre {100 * judged.centre_error_m:6.1f} cm off, orientation {theta}")  # fmt: skip
    out.mkdir(parents=True, exist_ok=True)
    draw_approach(task, steps).savefig(out / "approach.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'approach.png'}")
    return steps


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
