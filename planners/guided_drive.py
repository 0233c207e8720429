"""Drives along ways around what is known, and learns from the bumper of what was not."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planners.drive_around import Approach, DriveAround
from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.interfaces import MobileManipulator
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.observation import Observation

# Ours.
MOST_BUMPS = 3
BACK_M = 0.15  # after a bump the robot goes back so far, along the way that it came
SHORT_M, SHORT_RAD = 0.02, np.radians(2.0)  # a drive that ends this much before its goal was stopped
REACHED_M = 0.05  # a way that ends further from its goal leads somewhere near it


@dataclass(frozen=True, slots=True)
class GuidedDrive:
    """Drives a robot around what a map shows; what stops it is put on the map, and another way is looked for.

    Args:
        device: The robot, real or simulated.
        around: Finds ways, and keeps the map.
    """

    device: MobileManipulator
    around: DriveAround

    def drive(
        self,
        observation: Observation,
        joints: FloatArray,
        goals: Sequence[Pose2],
        approach: Approach | None = None,
        beside: PartEstimate | None = None,
    ) -> tuple[Pose2, ...]:
        """Drive to the first goal that a way leads to; if to none, as near to the first one as a way does.

        Args:
            observation: The newest stop.
            joints: How the arm is held, shape (Q,).
            goals: Where to, in the base frame of that stop.
            approach: The part, if the drive leads to it.
            beside: Where the part seems to be, if the drive is to pass beside it.

        Returns:
            The straight drives that were made, each in the base frame before it, as the robot believes.
        """
        stands, made = Pose2(), list[Pose2]()
        part_m = approach.part_m if approach is not None else None if beside is None else beside.centre_m
        for _ in range(MOST_BUMPS + 1):
            bumped = False
            for pose in self._way(observation, joints, goals, approach, beside, stands):
                asked = stands.inverse() @ pose
                moved = self.device.move_base(asked)
                made.append(moved)
                stands = stands @ moved
                if is_short(asked, moved):
                    rest = moved.inverse() @ asked
                    bumped = self.around.bumped(observation, joints, stands, rest, part_m)
                    break
            if not bumped:
                break
            made.append(self.device.move_base(_back(moved)))
            stands = stands @ made[-1]
        return tuple(made)

    def _way(
        self,
        observation: Observation,
        joints: FloatArray,
        goals: Sequence[Pose2],
        approach: Approach | None,
        beside: PartEstimate | None,
        stands: Pose2,
    ) -> tuple[Pose2, ...]:
        near = tuple[Pose2, ...]()
        for goal in goals:
            way = self.around.way(observation, joints, goal, approach, beside, stands)
            if way and np.linalg.norm(way[-1].translation_m - goal.translation_m) <= REACHED_M:
                return way
            near = near or way
        return near


def is_short(asked: Pose2, moved: Pose2) -> bool:
    """Whether something stopped a drive before it was over."""
    rest = moved.inverse() @ asked
    return bool(np.hypot(rest.x_m, rest.y_m) > SHORT_M or abs(rest.theta_rad) > SHORT_RAD)


def _back(moved: Pose2) -> Pose2:
    """The last of a drive, backwards, without turning."""
    length_m = float(np.hypot(moved.x_m, moved.y_m))
    share = 0.0 if length_m == 0.0 else min(1.0, BACK_M / length_m)
    x_m, y_m = Pose2(0.0, 0.0, -moved.theta_rad).apply(np.array([-share * moved.x_m, -share * moved.y_m])).tolist()
    return Pose2(x_m, y_m, 0.0)


def whole(made: Sequence[Pose2]) -> Pose2:
    """Several drives as one."""
    stands = Pose2()
    for moved in made:
        stands = stands @ moved
    return stands
