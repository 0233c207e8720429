"""Deliver: drive to a place in the odometry frame with the part in the hand, and put it down there.

    raise → drive → the same way down → open the hand → the same way back as the hand came

Where the part ends is as true as the odometry, and as the estimate that it was grasped by.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from planners.carry import RAISES_M, Carry, plan_carry
from planners.guided_drive import whole
from rfcompass.arrays import FloatArray
from rfcompass.errors import DeliveryFailed
from rfcompass.geometry.pose2 import Pose2
from rfcompass.interfaces import HandOpener, MobileManipulator
from rfcompass.robots import Robot
from rfcompass.types.grasps import GraspPlan
from rfcompass.types.motions import CLOSE, REACH
from rfcompass.types.parts import Part
from rfcompass.types.record import Record


class CarryingDevice(MobileManipulator, HandOpener, Protocol):
    """A robot that drives, moves its arm, and closes and opens its hand."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DeliverRules(Record):
    """How a part is delivered. All values are ours.

    Attributes:
        raises_m: How much higher than a grasp ends the part is carried, the first that the arm can do [m].
        step_m: Longest single drive [m].
        reached_m: A part that is put down further than this from its goal, as believed, is not delivered [m].
    """

    raises_m: Sequence[float] = RAISES_M
    step_m: float = 2.0
    reached_m: float = 0.02


@dataclass(frozen=True, slots=True)
class PutDown(Record):
    """How a part was put down, as the robot believes.

    Attributes:
        goal: Where it was to go, in the odometry frame.
        T_odom_part: Where it was put.
        T_odom_base: Where the base stood then.
        carry: How it was carried.
        drives: Drives of the base on the way.
    """

    goal: Pose2
    T_odom_part: Pose2
    T_odom_base: Pose2
    carry: Carry
    drives: int

    @property
    def short_m(self) -> float:
        """Distance between where it was put and where it was to go, as believed [m]."""
        return float(np.linalg.norm(self.T_odom_part.translation_m - self.goal.translation_m))


@dataclass(slots=True)
class Delivery:
    """Delivers what a pick-up has left in the hand.

    Args:
        robot: Kinematics of the robot.
        device: The robot, real or simulated.
        rules: How a part is delivered.
        drive: Drives to a pose in the present base frame, or as near as it can, and returns the straight drives that it
            made; straight if None.
    """

    robot: Robot
    device: CarryingDevice
    rules: DeliverRules = field(default_factory=DeliverRules)
    drive: Callable[[Pose2], Sequence[Pose2]] | None = None

    def put_down(self, part: Part, plan: GraspPlan, T_odom_base: Pose2, goal: Pose2) -> PutDown:
        """Carry the part to its goal and let go of it; afterwards the hand is back where the grasp began.

        Args:
            part: What is in the hand.
            plan: The grasp that holds it; its motions bring the part down and the hand away.
            T_odom_base: Where the base believes that it stands.
            goal: Where the part's centre and x axis are to end, the latter up to half a turn, in the odometry frame.

        Returns:
            What was done; `check_reached` says whether the goal was reached.
        """
        carry = plan_carry(self.robot, part, plan, self.rules.raises_m)
        up = np.concatenate([plan.retreat, carry.joints])
        T_base_part = _part_in_base(plan)
        self._follow(carry.joints)
        base, drives = self._drive(T_odom_base, base_goal(T_base_part, goal))
        self._follow(up[::-1])
        self.device.open_hand()
        self._follow(self._stage(plan, CLOSE)[::-1])
        self._follow(plan.approach[::-1])
        self._follow(self._stage(plan, REACH)[::-1])
        return PutDown(goal, base @ T_base_part, base, carry, drives)

    def check_reached(self, put: PutDown) -> None:
        """Refuse a delivery that ended short of its goal, for example at the bumper.

        Raises:
            DeliveryFailed: With how far it is short.
        """
        if put.short_m > self.rules.reached_m:
            message = f"the part was put down {put.short_m:.2f} m short of where it was to go"
            raise DeliveryFailed(message, short_m=put.short_m)

    def _drive(self, T_odom_base: Pose2, T_odom_goal: Pose2) -> tuple[Pose2, int]:
        """Drive to a pose; return where the base believes that it is, and the number of drives."""
        if self.drive is None:
            return self._drive_straight(T_odom_base, T_odom_goal)
        made = self.drive(T_odom_base.inverse() @ T_odom_goal)
        return T_odom_base @ whole(made), len(made)

    def _drive_straight(self, T_odom_base: Pose2, T_odom_goal: Pose2) -> tuple[Pose2, int]:
        """Drive in even steps; returns as `_drive` does."""
        whole = T_odom_base.inverse() @ T_odom_goal
        count = max(1, int(np.ceil(np.hypot(whole.x_m, whole.y_m) / self.rules.step_m)))
        base = T_odom_base
        for left in range(count, 0, -1):
            rest = base.inverse() @ T_odom_goal
            base = base @ self.device.move_base(Pose2(rest.x_m / left, rest.y_m / left, rest.theta_rad / left))
        return base, count

    def _stage(self, plan: GraspPlan, name: str) -> FloatArray:
        """Waypoints of a stage of the plan, shape (T, Q); none if the plan lacks it."""
        return next((stage.joints for stage in plan.stages if stage.stage == name), plan.approach[:0])

    def _follow(self, joints: FloatArray) -> None:
        """Move the arm along waypoints, shape (T, Q)."""
        for waypoint in joints:
            self.device.move_arm(waypoint)


def base_goal(T_base_part: Pose2, goal: Pose2) -> Pose2:
    """Where the base must stand so that the part in its hand comes down at a goal.

    The part may lie half a turn round; of the two places the one at the goal's negative y is taken.

    Args:
        T_base_part: Where the part comes down, in the base frame.
        goal: Where it is to lie, in any frame; the answer is in the same.
    """
    ways = [goal @ Pose2(0.0, 0.0, turn_rad) @ T_base_part.inverse() for turn_rad in (0.0, np.pi)]
    return min(ways, key=lambda base: (goal.inverse() @ base).y_m)


def _part_in_base(plan: GraspPlan) -> Pose2:
    """Where the part lay as it was grasped, and will lie as it is put down, in the base frame."""
    T = plan.T_base_hand @ np.linalg.inv(plan.T_part_hand)
    return Pose2(float(T[0, 3]), float(T[1, 3]), float(np.arctan2(T[1, 0], T[0, 0])))
