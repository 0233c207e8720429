"""Where the hand goes from stop to stop, in studies of what moves are worth.

Three ways: a fixed sweep with the base still; places drawn at random, half of them after a short drive; and the stop
that tells most for its time (`planners.next_stop`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Protocol

import numpy as np

from planners.hand_over import hand_over
from planners.hand_stops import HandStops
from planners.next_stop import BODY_HALF_M, choose_next_stop
from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.localization import NoiseModel
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration

# Ours, from the pilot study: x, y of the hand in the base frame [m] and heading of its jaws [°]. Five of its places lie
# beyond what the arm reaches with the tool straight down; these are drawn in towards the arm's first axis.
SWEEP = (
    (0.42, 0.0, 0), (0.34, -0.14, 60), (0.451, 0.123, 120), (0.34, 0.14, -60), (0.451, -0.123, 90),
    (0.387, 0.218, 30), (0.30, 0.0, 90), (0.387, -0.218, 150), (0.477, 0.0, 45), (0.36, 0.20, 75),
)  # fmt: skip
HAND_HEIGHT_M = 0.10
TRIES = 100


class Knowledge(Protocol):
    """What a robot that chooses its moves knows before each: nothing but its own measurements."""

    def poses(self) -> FloatArray:
        """Poses (x, y, θ) of the part in question, in the present base frame [m, m, rad], shape (S, 3)."""
        ...


@dataclass(frozen=True, slots=True)
class HandMoves:
    """Yields where the robot stands at each stop; base poses in the frame of the first one.

    Attributes:
        robot: The robot.
        policy: `"sweep"`, `"random"` or `"active"`.
        part_points_m: Part tags: x, y in the part frame, z in the base frame [m], shape (K, 3).
        noise: What `active` takes comparisons to be worth.
    """

    robot: Robot
    policy: str
    part_points_m: FloatArray
    noise: NoiseModel

    def configurations(
        self, T_first_part: Pose2, knowledge: Knowledge, rng: np.random.Generator
    ) -> Iterator[Configuration]:
        """Go on for as long as one asks.

        Args:
            T_first_part: Where the part truly lies; a base that is drawn at random does not drive over it.
            knowledge: Asked by `"active"` only.
            rng: Source of `"random"`.
        """
        sweep = sweep_configurations(self.robot)
        if self.policy == "sweep":
            yield from sweep
            return
        proposer, now = HandStops(robot=self.robot, height_m=HAND_HEIGHT_M), sweep[0]
        while True:
            yield now
            if self.policy == "active":
                poses = knowledge.poses()
                now = choose_next_stop(self.robot, now, proposer, poses, self.part_points_m, self.noise).configuration
            else:
                now = self._random(proposer, now, T_first_part, rng)

    def _random(
        self, proposer: HandStops, now: Configuration, T_first_part: Pose2, rng: np.random.Generator
    ) -> Configuration:
        stops = proposer.candidates(now)
        for _ in range(TRIES):
            chosen = stops[int(rng.integers(len(stops)))].configuration
            if not on_body(chosen.base.inverse() @ T_first_part, self.part_points_m):
                return chosen
        return now


def on_body(T_base_part: Pose2, part_points_m: FloatArray) -> bool:
    """True if a tag of the part lies under the robot's body."""
    return bool((np.abs(T_base_part.apply(part_points_m[:, :2])) < BODY_HALF_M).all(axis=1).any())


@cache
def sweep_configurations(robot: Robot) -> Sequence[Configuration]:
    """Joint values of the fixed sweep, the base where it is."""
    start = robot.posture("scan")
    return tuple(
        hand_over(robot, start, np.array([x_m, y_m, HAND_HEIGHT_M]), float(np.deg2rad(yaw))) for x_m, y_m, yaw in SWEEP
    )
