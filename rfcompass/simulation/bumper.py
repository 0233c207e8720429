"""How far a robot gets on a straight drive before it touches what stands or lies in the way."""

import numpy as np

from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import CollisionModel, QuickCollisions, Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.world import World

LOOK_M = 0.01  # ours: between two looks; a thing may be entered by as much
_DEEPER_M = 1e-4
_M_PER_RAD = 0.4  # a corner of the youBot's base turns on a circle of about this radius


def until_touching(robot: Robot, world: World, start: Configuration, motion: Pose2) -> Pose2:
    """The beginning of a drive, up to where the robot touches something, or what it touched already deeper.

    Args:
        robot: Who drives; its arm is stopped by things as its base is.
        world: What is solid, in the frame of `start.base`.
        start: True pose of the base, and the joints.
        motion: The drive, in the base frame at the start; straight, turning evenly.

    Returns:
        All of the drive where nothing is touched.
    """
    if not world.bodies:
        return motion
    checker = QuickCollisions(CollisionModel(robot, World(world.bodies, floor_m=None)))
    at_start = _depths_m(checker, start)
    looks = int(np.ceil((np.hypot(motion.x_m, motion.y_m) + _M_PER_RAD * abs(motion.theta_rad)) / LOOK_M))
    free = Pose2()
    for share in (np.arange(1, looks + 1) / max(looks, 1)).tolist():
        there = motion if share == 1.0 else Pose2(share * motion.x_m, share * motion.y_m, share * motion.theta_rad)
        depths_m = _depths_m(checker, Configuration(start.joints, start.base @ there))
        if any(depth_m > at_start.get(name, 0.0) + _DEEPER_M for name, depth_m in depths_m.items()):
            return free
        free = there
    return free if looks else motion


def _depths_m(checker: QuickCollisions, there: Configuration) -> dict[str, float]:
    """How deep the robot is in each thing that it touches [m], by name."""
    depths_m: dict[str, float] = {}
    for row in checker.touching(there):
        for name in (row.first, row.second):
            depths_m[name] = max(-row.distance_m, depths_m.get(name, 0.0))
    return depths_m
