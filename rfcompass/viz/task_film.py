"""A task as a film: the robot on its way from part to part, what is known at each stop, and the parts as they move.

The page's controls have a slider for the time.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.parts import Part
from rfcompass.types.record import Record
from rfcompass.viz import colours
from rfcompass.viz.grasp_view import View
from rfcompass.viz.overlay import Layer, Overlay, StageMark
from rfcompass.viz.robot_scene import RobotScene
from rfcompass.viz.triangles import needles

# Ours: draws of the posterior that are drawn at a stop; their length and height; where the camera stands, seen from the
# middle of the way, for a way that is so wide [m].
_DRAWS, _NEEDLE_M, _CLOUD_HEIGHT_M = 150, 0.05, 0.004
_CAMERA_M, _WIDE_M = np.array([-1.6, -2.6, 2.6]), 4.0


@dataclass(frozen=True, slots=True)
class FilmedStop(Record):
    """What was known at one stop.

    Attributes:
        time_s: When it was made [s].
        until_s: When the next one was, or the part was grasped [s].
        base: Believed pose of the base, in the odometry frame.
        estimate: What was found, in that base frame.
    """

    time_s: float
    until_s: float
    base: Pose2
    estimate: PartEstimate


@dataclass(frozen=True, slots=True)
class FilmedPart(Record):
    """A part, and where it was believed to be.

    Attributes:
        part: What it is.
        tags_m: Its tags in use, in the part frame [m], shape (K, 3).
        times_s: When it was at each pose [s], rising (P).
        poses: Poses in the odometry frame, homogeneous, shape (4, 4) each (P).
    """

    part: Part
    tags_m: FloatArray
    times_s: tuple[float, ...]
    poses: tuple[FloatArray, ...]


@dataclass(frozen=True, slots=True)
class Film(Record):
    """All that happened in a task, in the odometry frame, as the robot believes it.

    Attributes:
        times_s: When each picture is taken [s], rising (T).
        configurations: Robot in each (T).
        stops: What was known, stop by stop.
        parts: Parts that were found.
        marks: When the robot was sent for each part.
    """

    times_s: tuple[float, ...]
    configurations: tuple[Configuration, ...]
    stops: tuple[FilmedStop, ...]
    parts: tuple[FilmedPart, ...]
    marks: tuple[StageMark, ...]


def draw_film(robot: Robot, film: Film, facts: Sequence[tuple[str, str]] = ()) -> View:
    """Draw a film.

    Args:
        robot: Who did the task.
        film: What happened; at least one picture.
        facts: What to say beside it: rows of name and value.
    """
    scene = RobotScene()
    scene.draw_robot([robot.visual_shapes(at) for at in film.configurations], times_s=film.times_s)
    way_m = np.array([at.base.translation_m for at in film.configurations])
    scene.draw_path("base", way_m)
    layers = [Layer("robot", "robot", None), Layer("way of the base", "path", colours.PATH)]
    for filmed in film.parts:
        node = f"parts/{filmed.part.part_id}"
        scene.draw_part(filmed.part, Pose2(), filmed.tags_m, node)
        scene.move_part(filmed.poses, filmed.times_s, node)
        scene.show_between(node, filmed.times_s[0])
    if film.parts:
        layers.append(Layer("parts, as believed", "parts", colours.PART, len(film.parts)))
    layers += _draw_stops(scene, film.stops)
    scene.play()
    low_m, high_m = way_m.min(axis=0), way_m.max(axis=0)
    wide_m = float((high_m - low_m).max())
    scene.look_at(np.array([*(low_m + high_m) / 2, 0.0]), _CAMERA_M * max(0.5, wide_m / _WIDE_M))
    overlay = Overlay(f"{robot.name}: {len(film.marks)} parts", tuple(facts), tuple(layers), film.marks)
    return View(scene.window, overlay)


def _draw_stops(scene: RobotScene, stops: Sequence[FilmedStop]) -> list[Layer]:
    """Draw region and draws of each stop, each shown until the next."""
    regions, clouds = 0, 0
    for index, stop in enumerate(stops):
        placed = stop.estimate.in_frame(stop.base)
        if len(placed.region_m) >= 3:
            scene.draw_region(f"stop_{index}", placed.region_m)
            scene.show_between(f"region/stop_{index}", stop.time_s, stop.until_s)
            regions += 1
        if len(samples := placed.samples):
            drawn = samples[:: max(1, len(samples) // _DRAWS)]
            node = f"belief/stop_{index}"
            scene.draw_markers(node, needles(drawn, _NEEDLE_M, _CLOUD_HEIGHT_M), colours.CLOUD, opacity=0.6)
            scene.show_between(node, stop.time_s, stop.until_s)
            clouds += 1
    layers = [Layer("region of the part's centre", "region", colours.REGION, regions)] if regions else []
    return [*layers, Layer("poses the part may have", "belief", colours.CLOUD, clouds)] if clouds else layers
