"""Partition the plane: comparisons alone tell where a tag is (Fig. 1 of RF-Compass).

A part with one tag lies in front of the robot. For every pair of robot tags we ask which one the part's tag is
nearer to; each answer is half a plane, and what is left of the plane after 36 answers is a small cell.

You will see how the cell shrinks with the number of robot tags, and get `partition.png`. Takes 3 s.
"""

import sys
from pathlib import Path

import numpy as np

from rfcompass import PartDatabase, Pose2, YouBot
from rfcompass.geometry import polygon_area_m2
from rfcompass.localization import ComparedStop, PartitionLocalizer, compare_proximities, comparison_rows
from rfcompass.types import PartEstimate, TagPositions
from rfcompass.viz.partition_figures import draw_partition

BOUNDS_M = np.array([[-0.5, 1.0], [-0.75, 0.75]])


def compare(anchors: TagPositions, tag_m: np.ndarray) -> ComparedStop:
    """Ask all questions about one tag, with distances as proximities: no comparison is wrong."""
    distances_m = np.linalg.norm(anchors.points_m - tag_m, axis=1)
    centre_tag_m = np.array([[0.0, 0.0, tag_m[2]]])
    return ComparedStop(anchors.points_m, centre_tag_m, compare_proximities(distances_m[None, :]))


def main(fast: bool = False, out: Path = Path("runs/02_partition")) -> dict[int, float]:
    """Localise with three, six and nine robot tags; return the area of the cell for each [m²]."""
    robot, leg = YouBot(), PartDatabase(":memory:").part("table_leg_3")
    anchors = robot.tag_positions(robot.posture("scan"))
    T_base_part = Pose2(0.40, 0.03, 0.4)
    tag_m = np.array([T_base_part.x_m, T_base_part.y_m, leg.resting_height_m])

    areas_m2 = {}
    for count in (3, 6, 9):
        some = TagPositions("base", anchors.epcs[:count], anchors.points_m[:count])
        stop = compare(some, tag_m)
        fit = PartitionLocalizer(bounds_m=BOUNDS_M).fit([stop])
        areas_m2[count] = polygon_area_m2(fit.region_m)
        error_cm = 100 * np.linalg.norm(fit.z[:2] - tag_m[:2])
        print(f"{count} robot tags, {len(stop.comparisons):2d} comparisons: "
              f"cell of {1e4 * areas_m2[count]:7.1f} cm², centre {error_cm:4.1f} cm off")  # fmt: skip

    estimate = PartEstimate(leg.part_id, fit.z[:2], None, "partition", 1, region_m=fit.region_m)
    out.mkdir(parents=True, exist_ok=True)
    picture = draw_partition(comparison_rows([stop], as_object=True), [anchors], estimate, leg.layout(1), 0.4, BOUNDS_M)
    picture.savefig(out / "partition.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'partition.png'}")
    return areas_m2


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
