"""Why there is no solution, in words and numbers."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from rfcompass.types.grasp_task import GraspTask
from rfcompass.types.grasps import Failure
from rfcompass.types.world import Clearance

UNREACHABLE, JOINT_LIMIT = "unreachable", "joint_limit"
SELF_COLLISION, SCENE_COLLISION = "self_collision", "scene_collision"


def unreachable(task: GraspTask, nearest: "pin.SE3", error: tuple[float, float]) -> Failure:
    """No joint values, inside their limits or not, do the task.

    Args:
        task: What was asked.
        nearest: Tool pose that comes nearest, inside the joint limits.
        error: How far that is off [m] and how much it is turned [rad].
    """
    x, y, z = nearest.translation
    message = (
        f"the arm cannot hold its tool at {_point(task)} as asked; the nearest it gets is ({x:.3f}, {y:.3f}, {z:.3f}) "
        f"m, {error[0] * 1e3:.1f} mm and {np.rad2deg(error[1]):.1f} degrees off"
    )
    numbers: dict[str, float | str] = {
        "nearest_x_m": x, "nearest_y_m": y, "nearest_z_m": z, "residual_m": error[0], "residual_rad": error[1],
    }  # fmt: skip
    for name, row in zip(("roll", "pitch", "yaw"), pin.rpy.matrixToRpy(nearest.rotation), strict=True):
        numbers[f"nearest_{name}_rad"] = float(row)
    return _failure(UNREACHABLE, message, numbers)


def out_of_reach(task: GraspTask) -> Failure:
    """The same, without looking for the nearest pose."""
    return _failure(UNREACHABLE, f"the arm cannot hold its tool at {_point(task)} as asked", {})


def joint_limit(task: GraspTask, beyond: Sequence[tuple[str, float]]) -> Failure:
    """Only joint values outside their limits do the task.

    Args:
        task: What was asked.
        beyond: Joints outside, and how far [rad or m], of the answer that is least outside; furthest first.
    """
    joint, by = beyond[0]
    others = "".join(f", {name} by {out:.3f}" for name, out in beyond[1:])
    message = f"at {_point(task)} joint {joint} would have to go {by:.3f} beyond its limit{others}"
    return _failure(JOINT_LIMIT, message, {"joint": joint, "beyond": by})


def collision(task: GraspTask, nearest: Clearance, needed_m: float, robot_links: Sequence[str]) -> Failure:
    """Everything that does the task touches something.

    Args:
        task: What was asked.
        nearest: The pair that touches, or is too near, where it does so least.
        needed_m: Distance to keep [m].
        robot_links: Names of the robot's links.
    """
    kind = SELF_COLLISION if {nearest.first, nearest.second} <= set(robot_links) else SCENE_COLLISION
    how = f"overlap by {-nearest.distance_m * 1e3:.1f} mm" if nearest.touching else "come too near: "
    if not nearest.touching:
        how += f"{nearest.distance_m * 1e3:.1f} mm where {needed_m * 1e3:.1f} mm are to be kept"
    message = f"at {_point(task)} {nearest.first} and {nearest.second} {how}"
    numbers: dict[str, float | str] = {
        "first": nearest.first, "second": nearest.second, "depth_m": -nearest.distance_m, "needed_m": needed_m,
    }  # fmt: skip
    return _failure(kind, message, numbers)


def _failure(kind: str, message: str, numbers: dict[str, float | str]) -> Failure:
    plain = {name: value if isinstance(value, str) else float(value) for name, value in numbers.items()}
    return Failure(kind, message, tuple(plain.items()))


def _point(task: GraspTask) -> str:
    x, y, z = task.point_m
    return f"({x:.3f}, {y:.3f}, {z:.3f}) m"
