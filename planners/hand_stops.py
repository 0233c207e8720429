"""Stops with the hand over the floor before the base: a stand-in until grasp planning offers its own.

It checks joint limits and a keep-out box, and knows neither self-collision nor obstacles: `FreeStops` leaves out the
stops at which something touches.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from planners.hand_over import hand_over
from rfcompass.arrays import FloatArray
from rfcompass.errors import OutOfReach
from rfcompass.geometry.pose2 import Pose2
from rfcompass.interfaces import StopProposer
from rfcompass.robots import QuickCollisions, Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.stops import ProposedStop

# Of the youBot, from its data sheet.
BASE_M_PER_S, BASE_RAD_PER_S = 0.8, 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class HandStops:
    """Proposes hand poses over a rectangle, half of them after a short drive (`StopProposer`).

    Where the hand can be is drawn once, from a fixed seed: equal questions get equal answers. The rectangle, the
    drives and their number are ours.

    Attributes:
        robot: A robot with a tool and a posture "scan"; a base that is bolted down is left where it is.
        low_m: Least x, y of the hand in the base frame [m].
        high_m: Largest x, y [m].
        height_m: Height of the tool over the floor [m].
        count: Number of stops; half of them without a drive, all if the base does not drive.
        drive_m: Longest drive along x and along y [m].
        turn_rad: Largest turn of the base [rad].
        keep_out_m: Rectangle [[xmin, xmax], [ymin, ymax]] that the base's centre must not enter [m], in the frame of
            the configurations; None for none.
        seed: Of the draws.
    """

    robot: Robot
    low_m: tuple[float, float] = (0.30, -0.25)
    high_m: tuple[float, float] = (0.49, 0.25)
    height_m: float = 0.10
    count: int = 70
    drive_m: float = 0.25
    turn_rad: float = float(np.deg2rad(30.0))
    keep_out_m: FloatArray | None = None
    seed: int = 0

    def candidates(self, configuration: Configuration) -> Sequence[ProposedStop]:
        """List stops, in the frame of the configuration's base."""
        hands = hand_poses(self.robot, self.low_m, self.high_m, self.height_m, self.count, self.seed)
        rng = np.random.default_rng(self.seed)
        found = []
        for index, joints in enumerate(hands):
            motion = self._drive(rng) if index % 2 and self.robot.is_mobile else Pose2()
            base = configuration.base @ motion
            if not self._kept_out(base):
                seconds = max(self._arm_seconds(configuration.joints, joints), _drive_seconds(motion))
                found.append(ProposedStop(Configuration(joints, base), seconds))
        return found

    def _drive(self, rng: np.random.Generator) -> Pose2:
        x_m, y_m = rng.uniform(-self.drive_m, self.drive_m, 2)
        return Pose2(float(x_m), float(y_m), float(rng.uniform(-self.turn_rad, self.turn_rad)))

    def _kept_out(self, base: Pose2) -> bool:
        if self.keep_out_m is None:
            return False
        (x_low, x_high), (y_low, y_high) = self.keep_out_m
        return bool(x_low <= base.x_m <= x_high and y_low <= base.y_m <= y_high)

    def _arm_seconds(self, before: FloatArray, after: FloatArray) -> float:
        speed = self.robot.limits.velocity
        moving = np.isfinite(speed) & (speed > 0)
        return float((np.abs(after - before)[moving] / speed[moving]).max(initial=0.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeStops:
    """Those of another's stops at which nothing touches; the ways there are not looked at (`StopProposer`).

    Attributes:
        proposer: Who offers.
        collisions: Robot and world, in the frame of the configurations.
    """

    proposer: StopProposer
    collisions: QuickCollisions

    def candidates(self, configuration: Configuration) -> Sequence[ProposedStop]:
        """List stops, in the frame of the configuration's base."""
        offered = self.proposer.candidates(configuration)
        return [stop for stop in offered if not self.collisions.collides(stop.configuration)]


def _drive_seconds(motion: Pose2) -> float:
    return float(max(np.hypot(motion.x_m, motion.y_m) / BASE_M_PER_S, abs(motion.theta_rad) / BASE_RAD_PER_S))


@cache
def hand_poses(
    robot: Robot,
    low_m: tuple[float, float],
    high_m: tuple[float, float],
    height_m: float,
    count: int,
    seed: int,
) -> tuple[FloatArray, ...]:
    """Draw joint values that hold the hand over a rectangle, pointing down at any heading; (Q,) each.

    Raises:
        OutOfReach: If hardly any place of the rectangle can be reached.
    """
    rng = np.random.default_rng(seed)
    start, tried = robot.posture("scan"), 0
    found: list[FloatArray] = []
    while len(found) < count:
        tried += 1
        x_m, y_m = rng.uniform(low_m, high_m)
        try:
            pose = hand_over(robot, start, np.array([x_m, y_m, height_m]), float(rng.uniform(-np.pi, np.pi)))
        except OutOfReach as error:
            if tried > 20 * (count + 5):
                raise error.with_numbers(tried=tried, found=len(found)) from error
            continue
        found.append(pose.joints)
    return tuple(found)
