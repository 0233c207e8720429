"""The way of an arm that carries a camera and antennas over a table, once for both [Boroushaki2023], section 3.

A scan is a list of poses that a link has to take, the camera's as a rule. Between two of them the link goes straight;
waypoints are solved one after the other, each from the last, and the whole way is checked for collisions without gaps.
Reads are taken at every waypoint, images at the poses that were asked for.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pinocchio as pin

from planners.ik import InverseKinematics
from planners.motion_check import MotionChecker, MotionReport
from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasp_task import GraspTask
from rfcompass.types.grasps import Failure
from rfcompass.types.record import Record

# Ours: a read each 4 cm, a quarter of a wavelength at most; and the largest change of a joint between two of them.
SPACING_M = 0.04
_JUMP_RAD = 0.5


@dataclass(frozen=True, slots=True)
class ScanMotion(Record):
    """A way of the joints, and where on it the link stands at the poses asked for.

    Attributes:
        path: Joint values in the model's order, shape (A, Q).
        stops: Row of the path for each pose that was asked for, shape (S,).
        report: What the collision check found.
    """

    path: FloatArray
    stops: IntArray
    report: MotionReport

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "path", read_only(self.path, "ScanMotion.path", (None, None)))
        object.__setattr__(self, "stops", read_only(self.stops, "ScanMotion.stops", (None,), np.int64))

    def poses_of(self, robot: Robot, link: str, T_world_base: FloatArray | None = None) -> FloatArray:
        """Where a link is at each waypoint, by forward kinematics.

        Args:
            robot: The robot that was planned for.
            link: One of its links, such as an antenna's.
            T_world_base: Where its base stands in the world, shape (4, 4); the answer is in the base frame if None.

        Returns:
            Homogeneous poses, shape (A, 4, 4).
        """
        T = np.eye(4) if T_world_base is None else read_only(T_world_base, "T_world_base", (4, 4))
        return np.array([T @ robot.link_pose(Configuration(row), link).homogeneous for row in self.path])


def plan_scan(
    ik: InverseKinematics, link: str, poses: FloatArray, start: Configuration, spacing_m: float = SPACING_M
) -> ScanMotion | Failure:
    """Take a link through poses, straight from each to the next.

    Args:
        ik: Solves the waypoints; its world is what may not be touched.
        link: What has to take the poses; it must not move against the tool.
        poses: Where, in the base frame, homogeneous, shape (S, 4, 4), two or more.
        start: Joints from which the first pose is solved; the answer begins there, not here.
        spacing_m: Largest distance between waypoints [m].

    Returns:
        The motion; or a failure: `"unreachable"` or `"joint_limit"` where the arm ends, `"scene_collision"` or
        `"self_collision"` where something is in the way; `at` says after which share of the waypoints.

    Raises:
        ValueError: If there are less than two poses, or the spacing is not above 0.
        ShapeError: If poses are not of that shape.
    """
    wanted = read_only(poses, "poses", (None, 4, 4))
    if len(wanted) < 2 or not spacing_m > 0:
        raise ValueError(f"a scan of {len(wanted)} poses, {spacing_m} m between waypoints: cannot be")
    resting = ik.robot.configuration()
    T_link_tool = (ik.robot.link_pose(resting, link).inverse() * ik.robot.tool_pose(resting)).homogeneous
    way, stops = _way(wanted, spacing_m)
    path: list[Configuration] = []
    for number, T in enumerate(way):
        answer = _next(ik, T @ T_link_tool, path[-1] if path else start, free=not path)
        if isinstance(answer, Failure):
            return replace(answer, numbers=(*answer.numbers, ("at", number / len(way))))
        path.append(answer)
    report = MotionChecker(ik.collisions).check_path(path)
    if not report.free and report.clearance is not None:
        failure = ik.blocked_by(_task(ik.robot, wanted[0] @ T_link_tool), report.clearance)
        return replace(failure, numbers=(*failure.numbers, ("at", report.at)))
    return ScanMotion(np.array([row.joints for row in path]), stops, report)


def _way(poses: FloatArray, spacing_m: float) -> tuple[list[FloatArray], IntArray]:
    """Poses of the link at all waypoints, and which of them were asked for."""
    way, stops = [poses[0]], [0]
    for start, end in pairwise(poses):
        way.extend(leg(start, end, spacing_m))
        stops.append(len(way) - 1)
    return way, np.array(stops, dtype=np.int64)


def leg(start: FloatArray, end: FloatArray, spacing_m: float) -> Iterator[FloatArray]:
    """Poses from a start, without it, to an end: straight, and turned evenly."""
    steps = max(1, int(np.ceil(np.linalg.norm(end[:3, 3] - start[:3, 3]) / spacing_m - 1e-9)))
    turn = pin.log3(start[:3, :3].T @ end[:3, :3])
    for step in range(1, steps + 1):
        T = np.eye(4)
        T[:3, :3] = start[:3, :3] @ pin.exp3(turn * step / steps)
        T[:3, 3] = start[:3, 3] + (end[:3, 3] - start[:3, 3]) * step / steps
        yield T


def _task(robot: Robot, T_base_tool: FloatArray) -> GraspTask:
    tool = robot.tool
    return replace(GraspTask.of_pose(T_base_tool, tool.approach_axis, tool.closing_axis), jaws_alike=False)


def _next(
    ik: InverseKinematics, T_base_tool: FloatArray, last: Configuration, *, free: bool
) -> Configuration | Failure:
    """Joints for the next waypoint, near the last ones unless it is the first."""
    answer = ik.solve(_task(ik.robot, T_base_tool), last)
    if isinstance(answer, Failure):
        return answer
    joints = answer.configuration.joints
    change = np.abs(joints - last.joints)
    if not free and change.max() > _JUMP_RAD:
        joint = ik.robot.joint_names[int(change.argmax())]
        message = f"{joint} would have to jump by {change.max():.2f} between two waypoints"
        return Failure("joint_limit", message, (("joint", joint), ("jump", float(change.max()))))
    return Configuration(joints)
