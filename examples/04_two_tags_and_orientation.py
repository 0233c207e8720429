"""Two tags and orientation: when comparisons tell how a part is turned (Fig. 6 of RF-Compass).

A part with a tag at each end is first far away: both tags lie in the same cell, so the comparisons say nothing
about the orientation, and the answer is None rather than a guess. Near the hand the two tags fall into
different cells, and a convex program over (x, y, cos θ, sin θ) finds centre and orientation together.

You will see both answers, and get `orientation.png` for the near one. Takes 3 s.
"""

import sys
from pathlib import Path

import numpy as np

from rfcompass import Observation, PartDatabase, PartEstimate, PartitionLocalizer, Pose2, ProximityMatrix, YouBot
from rfcompass.localization import compared_stops, comparison_rows
from rfcompass.viz.partition_figures import draw_partition

ROBOT, LEG = YouBot(), PartDatabase(":memory:").part("table_leg_3")


def observe(T_base_part: Pose2) -> Observation:
    """Scan from the posture "scan"; distances are the proximities, so no comparison is wrong."""
    anchors, layout = ROBOT.tag_positions(ROBOT.posture("scan")), LEG.layout(2)
    heights_m = layout.points_m[:, 2] + LEG.resting_height_m
    tags_m = np.column_stack([T_base_part.apply(layout.points_m[:, :2]), heights_m])
    distances_m = np.linalg.norm(tags_m[:, None] - anchors.points_m[None], axis=2)
    between_anchors = np.full((len(anchors.epcs), len(anchors.epcs)), np.nan)
    matrix = ProximityMatrix(layout.epcs, anchors.epcs, distances_m, between_anchors, "distance")
    return Observation(0, anchors, layout, heights_m, proximity=matrix)


def show(name: str, estimate: PartEstimate, truth: Pose2) -> None:
    """Print an answer beside the truth."""
    error_cm = 100 * np.linalg.norm(estimate.centre_m - truth.translation_m)
    theta = "not observable" if estimate.theta_rad is None else f"{np.degrees(estimate.theta_rad):.1f}°"
    print(f"{name}: centre {error_cm:5.1f} cm off, orientation {theta} (truth {np.degrees(truth.theta_rad):.1f}°)")


def main(fast: bool = False, out: Path = Path("runs/04_orientation")) -> tuple[PartEstimate, PartEstimate]:
    """Localise the same part far and near; return both estimates."""
    far, near = Pose2(5.0, 1.0, 0.9), Pose2(0.45, 0.06, 0.9)
    localizer = PartitionLocalizer()
    far_estimate = localizer.estimate([observe(far)])
    observation = observe(near)
    near_estimate = localizer.estimate([observation])
    show("far ", far_estimate, far)
    show("near", near_estimate, near)

    out.mkdir(parents=True, exist_ok=True)
    rows = comparison_rows(compared_stops([observation]))
    bounds_m = np.array([[-0.3, 1.1], [-0.7, 0.7]])
    picture = draw_partition(rows, [observation.anchors], near_estimate, observation.part, LEG.longest_m, bounds_m)
    picture.savefig(out / "orientation.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'orientation.png'}")
    return far_estimate, near_estimate


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
