"""Arm configurations that hold the hand over a point, tool straight down.

A plain bounded least-squares solve over the robot's own kinematics, from several starts: enough to visit the
measurement stops of RF-Compass on any arm. Grasp planning, with collisions and reasons, is another matter.
"""

import numpy as np
from scipy.optimize import least_squares

from rfcompass.arrays import FloatArray
from rfcompass.errors import OutOfReach
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration

# Ours: 1 mm and 1 degree are far below what the tags resolve.
POSITION_TOLERANCE_M = 1e-3
DIRECTION_TOLERANCE = float(np.deg2rad(1.0))
# Ours: a turn of 1 rad weighs as much as 0.2 m, about half the reach of a small arm.
DIRECTION_WEIGHT_M = 0.2
RANDOM_STARTS = 8


def hand_over(robot: Robot, start: Configuration, point_m: FloatArray, yaw_rad: float) -> Configuration:
    """Find joint values that put the tool at a point, pointing down, with its jaws closing along a heading.

    Minimises |p(q) - p|² + w² (|a(q) + z|² + |c(q) - c|²) over the joints inside their soft limits, where a is the
    tool's approach and c its closing axis.

    Args:
        robot: Robot with a tool.
        start: Where to begin; joints that do not move the tool keep their value.
        point_m: Tool position in the base frame [m], shape (3,).
        yaw_rad: Heading of the closing axis in the base frame [rad]; half a turn more is the same grasp.

    Raises:
        OutOfReach: If no start leads there; carries the smallest `miss_m` found.
    """
    names = robot.arm_joints
    moving = np.array([robot.joint_names.index(name) for name in names])
    lower, upper = robot.limits.soft_lower[moving], robot.limits.soft_upper[moving]
    best = np.inf
    for first in _starts(start.joints[moving], lower, upper):
        for heading in (yaw_rad, yaw_rad + np.pi):
            target = np.array([np.cos(heading), np.sin(heading), 0.0])

            def residual(q: FloatArray, target: FloatArray = target) -> FloatArray:
                return _residual(robot, _with(start, moving, q), point_m, target)

            found = least_squares(residual, first, bounds=(lower, upper), xtol=1e-10, ftol=1e-10)
            miss = found.fun
            position_m, direction = np.linalg.norm(miss[:3]), np.linalg.norm(miss[3:]) / DIRECTION_WEIGHT_M
            if position_m <= POSITION_TOLERANCE_M and direction <= DIRECTION_TOLERANCE:
                return _with(start, moving, found.x)
            best = min(best, float(position_m))
    x, y, z = point_m
    message = f"the hand cannot point down at ({x:.3f}, {y:.3f}, {z:.3f}) m with its jaws at {yaw_rad:.2f} rad"
    raise OutOfReach(message, point_m=list(map(float, point_m)), yaw_rad=float(yaw_rad), miss_m=best)


def _starts(first: FloatArray, lower: FloatArray, upper: FloatArray) -> list[FloatArray]:
    """The present joints, then fixed draws inside the limits: the same for every call."""
    rng = np.random.default_rng(0)
    low, high = np.maximum(lower, -np.pi), np.minimum(upper, np.pi)
    draws = [rng.uniform(np.minimum(low, high), np.maximum(low, high)) for _ in range(RANDOM_STARTS)]
    return [np.clip(q, lower, upper) for q in (first, *draws)]


def _with(configuration: Configuration, moving: FloatArray, q: FloatArray) -> Configuration:
    joints = configuration.joints.copy()
    joints[moving] = q
    return Configuration(joints, configuration.base)


def _residual(robot: Robot, configuration: Configuration, point_m: FloatArray, closing: FloatArray) -> FloatArray:
    pose = robot.tool_pose(configuration)
    down = pose.rotation @ robot.tool.approach_axis + np.array([0.0, 0.0, 1.0])
    turn = pose.rotation @ robot.tool.closing_axis - closing
    return np.concatenate([pose.translation - point_m, DIRECTION_WEIGHT_M * down, DIRECTION_WEIGHT_M * turn])
