"""What a fetch looked like: the partition, the way there, and the scene."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rfcompass.geometry.pose2 import Pose2
from rfcompass.localization import compared_stops, comparison_rows, recent_stops
from rfcompass.studies.fetch_job import ReportedStep, Sought
from rfcompass.types.tags import TagPositions
from rfcompass.viz.meshcat_page import write_scene
from rfcompass.viz.partition_figures import draw_partition
from rfcompass.viz.robot_scene import RobotScene

_AROUND_M = 0.8  # half the width of the partition's picture


def draw_last_partition(task: Sought, steps: Sequence[ReportedStep]) -> Figure:
    """Draw the comparisons of the last window and what they leave, as in Fig. 1 and Fig. 6 of [Wang2013]."""
    observations = recent_stops([told.step.measured for told in steps])
    newest, estimate = observations[-1], steps[-1].step.estimate
    stops = compared_stops(observations)
    anchors = [
        TagPositions("base", seen.anchors.epcs, stop.anchors_newest_m)
        for seen, stop in zip(observations, stops, strict=True)
    ]
    bounds_m = np.column_stack([estimate.centre_m - _AROUND_M, estimate.centre_m + _AROUND_M])
    return draw_partition(comparison_rows(stops), anchors, estimate, newest.part, task.part.longest_m, bounds_m)


def draw_approach(task: Sought, steps: Sequence[ReportedStep]) -> Figure:
    """Draw the base's path and every estimate of the centre, in the odometry frame."""
    figure = Figure(figsize=(7, 6), layout="constrained")
    axes = figure.add_subplot()
    bases = [told.step.configuration.base for told in steps]
    path_m = np.array([base.translation_m for base in bases])
    centres_m = np.array([base.apply(told.step.estimate.centre_m) for base, told in zip(bases, steps, strict=True)])
    axes.plot(*path_m.T, "o-", color="#3b6ea5", label="base, as believed")
    axes.plot(*centres_m.T, "+", color="#d1495b", ms=10, mew=1.5, label="estimated centre, stop by stop")
    for index, centre_m in enumerate(centres_m):
        axes.annotate(str(index), centre_m, textcoords="offset points", xytext=(5, 5), fontsize=8)
    axes.set_aspect("equal")
    axes.set_xlabel("x in odom [m]")
    axes.set_ylabel("y in odom [m]")
    axes.set_title(f"Fetching {task.part.part_id}: {len(steps)} stops", loc="left")
    axes.legend(frameon=False)
    return figure


def draw_scene(task: Sought, steps: Sequence[ReportedStep], path: Path) -> None:
    """Write the meshcat page: the robot on its way, its tags, the region and the part as estimated."""
    scene = RobotScene()
    configurations = [told.step.configuration for told in steps]
    scene.draw_robot([task.robot.visual_shapes(configuration) for configuration in configurations])
    scene.draw_path("base", np.array([configuration.base.translation_m for configuration in configurations]))
    base, estimate = configurations[-1].base, steps[-1].step.estimate
    layout = steps[-1].step.observation.part
    scene.draw_estimate(estimate, base, task.part, layout.points_m)
    target = base.apply(estimate.centre_m)
    look = Pose2(0.0, 0.0, base.theta_rad).apply(np.array([0.5, -0.8]))
    scene.look_at(np.array([*target, 0.1]), np.array([*look, 0.5]))
    write_scene(path, scene.window, f"Fetch of {task.part.part_id}")
