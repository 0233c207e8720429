"""The motions of an arm over a pile: look from above, go down for a thing, carry it to the drop zone. And their time.

World frame: z up, the table top is z = 0. Between the places the joints go straight, over the scan's posture where that
would touch; down and up the tool goes straight. Every motion is checked against table and arm. The things in the pile
are not known as bodies: on the way down it is for the hand to feel them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from planners.ik import InverseKinematics
from planners.motion_check import MotionChecker, MotionReport
from planners.path_timing import in_time
from planners.scan_motion import leg
from planners.straight_motion import move_straight
from rfcompass.arrays import FloatArray, read_only
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasp_task import GraspTask
from rfcompass.types.grasps import Failure
from rfcompass.types.motions import APPROACH, LIFT, REACH, RETREAT, TimedPath
from rfcompass.types.record import Record

# Ours. How far the camera may be from the height that is asked for, and its turns about the vertical: the first that
# the arm can reach; how far above a grasp the descent begins; what one closing takes.
_HIGHER_M = (0.0, -0.05, 0.05, -0.10, -0.15, -0.20)
_TURNS_RAD = (np.pi, np.pi / 2, -np.pi / 2, 0.0)
ABOVE_M = 0.15
CLOSING_S = 0.8
# Ours: steps in which the tool is led from the resting posture to a task, and the largest change of a joint in one.
_STEP_M, _JUMP_RAD = 0.10, 1.0


@dataclass(frozen=True, slots=True)
class ArmMotion(Record):
    """What the arm does, stage by stage.

    Attributes:
        stages: Motions, each beginning where the last ends.
        waiting_s: Time in which the arm stands and the hand closes [s].
        T_world_link: What the motion is for, in the world, shape (4, 4): the pose of the camera where it looks, of the
            tool where it grasps.
    """

    stages: tuple[TimedPath, ...]
    waiting_s: float
    T_world_link: FloatArray

    def __post_init__(self) -> None:
        """Freeze."""
        object.__setattr__(self, "stages", tuple(self.stages))
        object.__setattr__(self, "T_world_link", read_only(self.T_world_link, "ArmMotion.T_world_link", (4, 4)))

    @property
    def duration_s(self) -> float:
        """Time of all stages, and of the closing [s]."""
        return self.waiting_s + sum(stage.duration_s for stage in self.stages)

    @property
    def closed_s(self) -> float:
        """Time until the hand has closed: all that comes before what is held is lifted [s]."""
        before = [stage.duration_s for stage in self.stages if stage.stage not in (LIFT, RETREAT)]
        return self.waiting_s + sum(before)

    @property
    def end(self) -> Configuration:
        """Joints at the end."""
        return Configuration(self.stages[-1].joints[-1])

    @property
    def path(self) -> FloatArray:
        """Joints of all waypoints, shape (A, Q)."""
        return np.concatenate([stage.joints for stage in self.stages])


@dataclass(eq=False)
class PileArm:
    """Plans the motions of a search. Not to be shared among threads.

    Args:
        ik: Solves for the arm, with the table as its floor.
        T_world_base: Where the arm stands, shape (4, 4).
        camera: Link of the camera, z forward.
        drop_m: Where the hand opens, in the world [m], shape (3,).
        resting: Posture over the table from which anything can be reached, such as the scan's.
    """

    ik: InverseKinematics
    T_world_base: FloatArray
    camera: str
    drop_m: FloatArray
    resting: Configuration
    _checker: MotionChecker = field(init=False, repr=False)
    _dropping: Configuration | Failure = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Freeze the poses; ready the collision check; find the joints over the drop zone."""
        self.T_world_base = read_only(self.T_world_base, "PileArm.T_world_base", (4, 4))
        self.drop_m = read_only(self.drop_m, "PileArm.drop_m", (3,))
        self._checker = MotionChecker(self.ik.collisions)
        self._dropping = self._posture(self._task(self._T_world_drop()))

    def look_at(self, point_m: FloatArray, height_m: float, start: Configuration) -> ArmMotion | Failure:
        """Bring the camera above a point, looking down.

        Args:
            point_m: In the world [m], shape (3,).
            height_m: Height of the camera over the table [m]; if the arm cannot, up to 20 cm lower or 5 cm higher.
            start: Joints now.

        Returns:
            The motion; or the failure of the last place that was tried.
        """
        T_camera_tool, why = self._T_camera_tool(), Failure("unreachable", "there is no place to look from")
        for T_world_camera in _views_of(np.asarray(point_m, dtype=np.float64), height_m):
            task = replace(self._task(T_world_camera @ T_camera_tool), jaws_alike=False)
            answer = self._reach(task, start)
            if isinstance(answer, TimedPath):
                T = self.T_world_base @ self.ik.robot.link_pose(_end(answer), self.camera).homogeneous
                return ArmMotion((answer,), 0.0, T)
            why = answer
        return why

    def move_to(self, goal: Configuration, start: Configuration) -> TimedPath | Failure:
        """Bring the joints to where a planned way begins.

        Args:
            goal: Joints there.
            start: Joints now.
        """
        tool = self.ik.robot.tool
        T_base_tool = self.ik.robot.tool_pose(goal).homogeneous
        return self._go(GraspTask.of_pose(T_base_tool, tool.approach_axis, tool.closing_axis), goal, start)

    def fetch(self, T_world_tool: FloatArray, start: Configuration) -> ArmMotion | Failure:
        """Go straight down to a grasp, close, go straight up, carry what is held to the drop zone.

        Args:
            T_world_tool: The tool at the grasp, shape (4, 4).
            start: Joints now.

        Returns:
            The motion, its link the tool at the grasp; or why there is none.
        """
        T = read_only(T_world_tool, "T_world_tool", (4, 4))
        task = self._task(T)
        back_m = -ABOVE_M * task.approach if task.approach is not None else np.zeros(3)
        high = replace(task, point_m=task.point_m + back_m)
        above = self._reach(high, start)
        if isinstance(above, Failure):
            return above
        way = move_straight(self.ik, high, _end(above), -back_m, checker=self._checker)
        if isinstance(way, Failure):
            return way
        away = self._go(self._task(self._T_world_drop()), self._dropping, Configuration(way.path[0]))
        if isinstance(away, Failure):
            return away
        down, up = (
            in_time(self.ik.robot, stage, path) for stage, path in ((APPROACH, way.path), (LIFT, way.path[::-1]))
        )
        return ArmMotion((above, down, up, replace(away, stage=RETREAT)), CLOSING_S, T)

    def _reach(self, task: GraspTask, start: Configuration) -> TimedPath | Failure:
        return self._go(task, self._posture(task), start)

    def _go(self, task: GraspTask, goal: Configuration | Failure, start: Configuration) -> TimedPath | Failure:
        """Move the joints from where they are to those of a task, straight or over the resting posture."""
        if isinstance(goal, Failure):
            return goal
        worst: MotionReport | None = None
        for path in ((start, goal), (start, self.resting, goal)):
            worst = self._checker.check_path(path)
            if worst.free:
                return in_time(self.ik.robot, REACH, path)
        if worst is None or worst.clearance is None:
            raise AssertionError("a motion that is not free has a pair that touches")
        return self.ik.blocked_by(task, worst.clearance)

    def _posture(self, task: GraspTask) -> Configuration | Failure:
        """Joints for a task, bent as the resting posture is: solved step by step from there."""
        resting = self.ik.robot.tool_pose(self.resting).homogeneous
        at = self.resting
        for T in leg(resting, self._goal(task, resting), _STEP_M):
            tool = self.ik.robot.tool
            answer = self.ik.solve(GraspTask.of_pose(T, tool.approach_axis, tool.closing_axis), at)
            if isinstance(answer, Failure):
                return answer
            jump = np.abs(answer.configuration.joints - at.joints)
            if jump.max() > _JUMP_RAD:
                joint = self.ik.robot.joint_names[int(jump.argmax())]
                message = f"{joint} would have to jump by {jump.max():.2f} on the way"
                return Failure("joint_limit", message, (("joint", joint), ("jump", float(jump.max()))))
            at = Configuration(answer.configuration.joints)
        return at

    def _goal(self, task: GraspTask, resting: FloatArray) -> FloatArray:
        """Pose of the tool that does a task; of two that differ by half a turn, the one nearer to the resting one."""
        if task.approach is None or task.closing is None:
            raise ValueError("the task of this arm leaves no axis free")
        tool = self.ik.robot.tool
        in_tool = np.column_stack(
            [tool.closing_axis, np.cross(tool.approach_axis, tool.closing_axis), tool.approach_axis]
        )
        alike = task.jaws_alike and task.closing @ (resting[:3, :3] @ tool.closing_axis) < 0
        closing = -task.closing if alike else task.closing
        in_base = np.column_stack([closing, np.cross(task.approach, closing), task.approach])
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = in_base @ in_tool.T, task.point_m
        return T

    def _task(self, T_world_tool: FloatArray) -> GraspTask:
        tool = self.ik.robot.tool
        T_base_tool = np.linalg.inv(self.T_world_base) @ T_world_tool
        return GraspTask.of_pose(T_base_tool, tool.approach_axis, tool.closing_axis)

    def _T_world_drop(self) -> FloatArray:
        """The tool over the drop zone, turned as at rest."""
        T = np.array(self.T_world_base @ self.ik.robot.tool_pose(self.resting).homogeneous)
        T[:3, 3] = self.drop_m
        return T

    def _T_camera_tool(self) -> FloatArray:
        robot, still = self.ik.robot, self.resting
        return (robot.link_pose(still, self.camera).inverse() * robot.tool_pose(still)).homogeneous


def _views_of(point_m: FloatArray, height_m: float) -> Iterator[FloatArray]:
    """Poses of a camera that looks down at a point."""
    for higher_m in _HIGHER_M:
        for turn in _TURNS_RAD:
            c, s = np.cos(turn), np.sin(turn)
            T = np.eye(4)
            T[:3, :3] = np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])
            T[:3, 3] = point_m[0], point_m[1], height_m + higher_m
            yield T


def _end(path: TimedPath) -> Configuration:
    return Configuration(path.joints[-1])


def link_poses(arm: PileArm, path: FloatArray | Sequence[FloatArray], link: str) -> FloatArray:
    """Where a link of the arm is at each row of a path.

    Args:
        arm: The arm, with its place in the world.
        path: Joints [rad], shape (A, Q).
        link: Name of the link.

    Returns:
        Homogeneous poses in the world, shape (A, 4, 4).
    """
    robot = arm.ik.robot
    return np.array([arm.T_world_base @ robot.link_pose(Configuration(row), link).homogeneous for row in path])
