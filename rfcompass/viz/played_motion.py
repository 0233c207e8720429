"""A plan as a film: where everything is at each moment, in the base frame before the robot moves."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.geometry.pose2 import Pose2, as_pose2
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import GraspPlan
from rfcompass.types.motions import CLOSE, DRIVE, TimedPath
from rfcompass.types.record import Record
from rfcompass.viz.overlay import StageMark

# Longest time from one picture to the next [s]; ours: between two, links move along straight lines.
_PICTURE_S = 0.1
_STAGE_NAMES = {"reach": "pre-grasp"}


@dataclass(frozen=True, slots=True)
class PlayedMotion(Record):
    """Pictures of a motion.

    Attributes:
        times_s: When each is taken [s], rising (T).
        configurations: Robot in each, base pose in the frame in which the estimate was made (T).
        parts: Pose of the part in each, homogeneous, shape (4, 4) each (T).
        stages: When each stage begins.
    """

    times_s: tuple[float, ...]
    configurations: tuple[Configuration, ...]
    parts: tuple[FloatArray, ...]
    stages: tuple[StageMark, ...]


def play(plan: GraspPlan, robot: Robot) -> PlayedMotion:
    """Take the pictures of a plan; the part rides in the hand once the jaws have closed.

    Raises:
        InputError: If the plan was made for a robot with other joints, or has no motion.
    """
    if not plan.stages:
        raise InputError("the plan has no stages, so there is no motion to show")
    _check_joints(plan, robot)
    starts_s = np.cumsum([0.0, *(stage.duration_s for stage in plan.stages)])
    times_s: list[float] = []
    configurations: list[Configuration] = []
    for stage, start_s in zip(plan.stages, starts_s[:-1], strict=True):
        frame = Pose2() if stage.stage == DRIVE else plan.base
        for time_s in _picture_times(stage)[1 if times_s else 0 :]:  # a stage begins where the last one ended
            times_s.append(float(start_s + time_s))
            configurations.append(_at(stage, time_s, frame))
    marks = [
        StageMark(_STAGE_NAMES.get(stage.stage, stage.stage), float(start_s))
        for stage, start_s in zip(plan.stages, starts_s[:-1], strict=True)
    ]
    parts = _ride(plan, robot, times_s, configurations)
    return PlayedMotion(tuple(times_s), tuple(configurations), parts, tuple(marks))


def _check_joints(plan: GraspPlan, robot: Robot) -> None:
    for stage in plan.stages:
        if stage.names != robot.joint_names:
            message = f"stage {stage.stage} moves {', '.join(stage.names)}; {robot.name} has other joints"
            raise InputError(message, plan=list(stage.names), robot=list(robot.joint_names))


def _ride(
    plan: GraspPlan, robot: Robot, times_s: Sequence[float], configurations: Sequence[Configuration]
) -> tuple[FloatArray, ...]:
    """Where the part is in each picture: where it lies, and in the hand once the jaws have closed."""
    T_hand_part = np.linalg.inv(plan.T_part_hand)
    lying = homogeneous(plan.base) @ plan.T_base_hand @ T_hand_part
    upto = [index for index, stage in enumerate(plan.stages) if stage.stage == CLOSE]
    closed_s = sum(stage.duration_s for stage in plan.stages[: upto[0] + 1]) if upto else np.inf
    return tuple(
        homogeneous(at.base) @ robot.tool_pose(at).homogeneous @ T_hand_part if time_s > closed_s else lying
        for time_s, at in zip(times_s, configurations, strict=True)
    )


def _picture_times(stage: TimedPath) -> FloatArray:
    """All waypoints, and enough between them."""
    between = np.arange(0.0, stage.duration_s, _PICTURE_S)
    return np.unique(np.concatenate([stage.times_s, between]).round(9))


def _at(stage: TimedPath, time_s: float, frame: Pose2) -> Configuration:
    """Where the robot is at a time of a stage; between two waypoints everything moves evenly."""
    joints = np.array([np.interp(time_s, stage.times_s, values) for values in stage.joints.T])
    bases = stage.bases.copy()
    bases[:, 2] = np.unwrap(bases[:, 2])
    base = np.array([np.interp(time_s, stage.times_s, values) for values in bases.T])
    return Configuration(joints, frame @ as_pose2(base))


def homogeneous(pose: Pose2, height_m: float = 0.0) -> FloatArray:
    """A pose in the plane as a homogeneous pose in space, shape (4, 4)."""
    T = np.eye(4)
    T[:2, :2], T[:2, 3], T[2, 3] = pose.rotation, pose.translation_m, height_m
    return T
