"""Paths in time: as fast as the slowest joint allows.

Between two waypoints every joint moves evenly, and takes max_k |Δq_k| / v_k. Nothing is said about accelerations: a
URDF has no limit of them, so a controller rounds off the corners. A share of the limits is kept back for that.
"""

from collections.abc import Sequence

import numpy as np

from planners.hand_stops import BASE_M_PER_S, BASE_RAD_PER_S
from rfcompass.arrays import FloatArray
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.motions import TimedPath

# Ours.
SHARE_OF_LIMITS = 0.8


def in_time(
    robot: Robot, stage: str, path: Sequence[Configuration] | FloatArray, share: float = SHARE_OF_LIMITS
) -> TimedPath:
    """Put a path into time, inside the limits of velocity.

    Args:
        robot: Whose limits. A joint without a limit, or with one of 0, takes no time; a base drives at the speeds of
            the youBot.
        stage: What the path is for.
        path: Configurations, or joint values with the base at the origin, shape (T, Q).
        share: Of the limits, how much to use.

    Raises:
        ValueError: If the share is not above 0 and at most 1, or there is no waypoint.
    """
    if not (0 < share <= 1 and len(path)):
        raise ValueError(f"a path of {len(path)} waypoints at {share} of the limits: cannot be")
    rows = [row if isinstance(row, Configuration) else Configuration(row) for row in path]
    joints = np.array([row.joints for row in rows])
    bases = np.array([[row.base.x_m, row.base.y_m, row.base.theta_rad] for row in rows])
    bases[:, 2] = np.unwrap(bases[:, 2])
    speed = np.where(robot.limits.velocity > 0, robot.limits.velocity, np.inf)
    by_joint = (np.abs(np.diff(joints, axis=0)) / speed).max(axis=1, initial=0.0)
    moved = np.diff(bases, axis=0)
    driving = np.hypot(moved[:, 0], moved[:, 1]) / BASE_M_PER_S
    turning = np.abs(moved[:, 2]) / BASE_RAD_PER_S
    seconds = np.max([by_joint, driving, turning], axis=0) / share
    return TimedPath(stage, robot.joint_names, np.concatenate([[0.0], np.cumsum(seconds)]), joints, bases)
