"""Straight lines of the tool: down to the part, up with the part.

The tool keeps its axes and moves along a straight segment. Waypoints are solved one after the other, each from the
last, until between two of them the tool leaves the line by less than a tolerance; then the whole path is checked for
collisions without gaps (`motion_check`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from planners.ik import InverseKinematics
from planners.motion_check import MotionChecker, MotionReport, between
from rfcompass.arrays import FloatArray, read_only
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasp_task import GraspTask
from rfcompass.types.grasps import Failure
from rfcompass.types.record import Record

# Ours. First distance between waypoints, the most that they may be made, and the largest change of a joint from one to
# the next: more is another branch of the arm.
_STEP_M = 0.02
_MOST = 1024
_JUMP = 0.5


@dataclass(frozen=True, slots=True)
class StraightMotion(Record):
    """A path of the joints along which the tool moves straight.

    Attributes:
        path: Joint values in the model's order, shape (A, Q).
        deviation_m: Largest distance of the tool from the line, half way between waypoints [m].
        report: What the collision check found.
    """

    path: FloatArray
    deviation_m: float
    report: MotionReport

    def __post_init__(self) -> None:
        """Freeze the path."""
        object.__setattr__(self, "path", read_only(self.path, "StraightMotion.path", (None, None)))

    @property
    def reversed_path(self) -> FloatArray:
        """The way back, shape (A, Q)."""
        return self.path[::-1]


def move_straight(
    ik: InverseKinematics,
    task: GraspTask,
    begin: Configuration,
    offset_m: FloatArray,
    tolerance_m: float = 5e-4,
    *,
    checker: MotionChecker | None = None,
) -> StraightMotion | Failure:
    """Move the tool straight away from where it is, keeping its axes.

    For an approach, move away from the grasp and take the path in reverse.

    Args:
        ik: Solves the waypoints; its world is what may not be touched.
        task: What the tool does at the beginning.
        begin: Joints that do it.
        offset_m: Where to, from there [m], shape (3,).
        tolerance_m: How far the tool may leave the line [m].
        checker: Of the same world, from an earlier motion; made if None, which takes longer than to check the path.

    Returns:
        The motion; or a failure: `"unreachable"` or `"joint_limit"` where the arm ends, `"scene_collision"` or
        `"self_collision"` where something is in the way; `at` says after which share of the way.

    Raises:
        ValueError: If the beginning does not do the task, or the tolerance is not above 0.
    """
    if not tolerance_m > 0:
        raise ValueError(f"tolerance_m is {tolerance_m}, not above 0")
    first = Configuration(begin.joints)
    if not ik.does(task, first):
        raise ValueError("the motion does not begin where the tool does the task")
    offset = read_only(offset_m, "offset_m", (3,))
    count = max(1, int(np.ceil(np.linalg.norm(offset) / _STEP_M)))
    while True:
        path = _waypoints(ik, task, first, offset, count)
        if isinstance(path, Failure):
            return path
        deviation_m = _deviation_m(ik, path)
        if deviation_m <= tolerance_m or count >= _MOST:
            break
        count *= 2
    report = (checker or MotionChecker(ik.collisions)).check_path(path)
    if not report.free and report.clearance is not None:
        failure = ik.blocked_by(task, report.clearance)
        return replace(failure, numbers=(*failure.numbers, ("at", report.at)))
    return StraightMotion(np.array([row.joints for row in path]), deviation_m, report)


def _waypoints(
    ik: InverseKinematics, task: GraspTask, first: Configuration, offset: FloatArray, count: int
) -> list[Configuration] | Failure:
    path = [first]
    for k in range(1, count + 1):
        answer = ik.solve(replace(task, point_m=task.point_m + offset * k / count), path[-1])
        if isinstance(answer, Failure):
            return replace(answer, numbers=(*answer.numbers, ("at", k / count)))
        joints = answer.configuration.joints
        change = np.abs(joints - path[-1].joints)
        if change.max() > _JUMP:
            joint = ik.robot.joint_names[int(change.argmax())]
            message = f"after {(k - 1) / count:.0%} of the way {joint} would have to jump by {change.max():.2f}"
            return Failure("joint_limit", message, (("joint", joint), ("jump", float(change.max())), ("at", k / count)))
        path.append(Configuration(joints))
    return path


def _deviation_m(ik: InverseKinematics, path: Sequence[Configuration]) -> float:
    """Largest distance of the tool, half way in the joints, from the middle of the tool's places."""
    worst = 0.0
    for a, b in pairwise(path):
        ends = [ik.robot.tool_pose(row).translation for row in (a, b)]
        middle = ik.robot.tool_pose(between(a, b, 0.5)).translation
        along = ends[1] - ends[0]
        length = np.linalg.norm(along)
        off = middle - ends[0]
        if length > 0:
            off = off - (off @ along / length**2) * along
        worst = max(worst, float(np.linalg.norm(off)))
    return worst
