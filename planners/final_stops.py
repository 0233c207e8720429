"""Where the hand goes next over a part in reach: where it would tell most, until the part is known well enough."""

from dataclasses import dataclass, field

import numpy as np

from planners.motion_check import MotionChecker
from planners.next_stop import choose_next_stop
from rfcompass.errors import OutOfReach
from rfcompass.interfaces import StopProposer
from rfcompass.localization import NoiseModel, StopRule
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.tags import TagLayout

TRIED = 10  # ours: stops, the best first, whose motion is checked before the fixed sweep goes on


@dataclass(frozen=True, slots=True)
class FinalStops:
    """Chooses the last stops of a fetch.

    Attributes:
        robot: Kinematics, for where its tags would be.
        proposer: Stops that it can make.
        checker: What the motion to a stop must not touch; None if nobody checks.
        rule: When the part is known well enough; a leg looks the same after half a turn.
        noise: How good the meter is; the default is a meter that nobody looked at.
    """

    robot: Robot
    proposer: StopProposer
    checker: MotionChecker | None = None
    rule: StopRule = field(default_factory=lambda: StopRule(symmetry=2))
    noise: NoiseModel = field(default_factory=NoiseModel)

    def is_enough(self, estimate: PartEstimate) -> bool:
        """Whether no further stop is needed; never, for an estimate without samples."""
        return bool(len(estimate.samples)) and self.rule.met_by(estimate)

    def choose(self, now: Configuration, estimate: PartEstimate, part: TagLayout) -> Configuration | None:
        """Find the stop that tells most for its time among those that the straight motion of arm and base gets to.

        Args:
            now: Where the robot is.
            estimate: Where the part seems to be, in its base frame.
            part: The part's tags.

        Returns:
            Where to stop; None if the estimate has no samples, or none of the best stops can be had.
        """
        if len(estimate.samples) < 2:
            return None
        points_m = part.points_m + np.array([0.0, 0.0, estimate.height_m])
        try:
            offered = choose_next_stop(self.robot, now, self.proposer, estimate.samples, points_m, self.noise)
        except OutOfReach:
            return None
        order = np.argsort(-offered.scores.gain_nat / offered.scores.seconds, kind="stable")[:TRIED]
        stops = (offered.stops[int(i)].configuration for i in order)
        return next((stop for stop in stops if self._is_free(now, stop)), None)

    def _is_free(self, now: Configuration, stop: Configuration) -> bool:
        return self.checker is None or self.checker.check(now, stop).free
