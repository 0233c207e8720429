"""Grasp now, or measure once more first? What one more stop would do for the chance of a grasp.

Played through before it is measured (preposterior analysis). From the poses z in question, S draws of the estimate, and
for each stop that seems worth it:

1. draw a pose z_h as the truth and what the stop would then measure: distances d_ki of part tag k from anchor i, with

       Σ_k = diag(α² + β² d_ki²) + b² U_k U_kᵀ

   of the noise model (`hypothetical_stop`);
2. weigh every pose by the likelihood of that measurement: the posterior after the stop;
3. put the plan's grasp of the part onto the mean of that posterior and count for how much of it the grasp holds.

The mean over the draws h is the success to expect.

Hopeful: errors are Gaussian; a stop tells distances, even where the meter is only good for comparisons (their spread is
then taken for that of two distances); the bias of the tags' places is another than at the stops before; the grasp can
be reached wherever the mean moves to. Cautious: no other contact point is chosen after the stop.
"""

from dataclasses import dataclass, field

import numpy as np

from planners.hypothetical_stop import Hearing, posteriors
from planners.next_stop import choose_next_stop
from planners.success import pose_samples
from rfcompass.arrays import FloatArray
from rfcompass.errors import OutOfReach
from rfcompass.interfaces import StopProposer
from rfcompass.localization import NoiseModel
from rfcompass.robots import Robot
from rfcompass.robots.hand import judge_grasps
from rfcompass.types.configuration import Configuration
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.grasps import Failure, GraspPlan, MeasureAdvice
from rfcompass.types.hands import Hand
from rfcompass.types.parts import Part
from rfcompass.types.record import Record
from rfcompass.types.stops import ProposedStop
from rfcompass.types.tags import TagLayout

# Poses that stops are scored by; ours.
_SCORED = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class AgainRules(Record):
    """How to play it through. All values are ours.

    Attributes:
        stops: Stops to play through, those that tell most per second.
        outcomes: Measurements to draw for each.
        poses: Poses that posteriors are weighed over.
        judged: Poses of each posterior that the grasp is judged at.
        least_rise: Rise of the success below which another stop is not worth it.
    """

    stops: int = 3
    outcomes: int = 24
    poses: int = 3000
    judged: int = 200
    least_rise: float = 0.05

    def __post_init__(self) -> None:
        """Check the counts.

        Raises:
            ValueError: If one is impossible.
        """
        counts = self.stops, self.outcomes, self.judged, self.poses
        if min(counts) < 1 or self.poses < 2 or not 0 <= self.least_rise <= 1:
            raise ValueError(f"AgainRules: {counts} draws or a rise of {self.least_rise} cannot be")


@dataclass(frozen=True, slots=True)
class MeasureAgain:
    """Advises whether to measure again.

    Attributes:
        robot: Kinematics, for where its tags would be.
        hand: Its hand.
        proposer: Stops that it can make.
        noise: How good the meter is; the default is a meter that nobody looked at.
        rules: How to play it through.
    """

    robot: Robot
    hand: Hand
    proposer: StopProposer
    noise: NoiseModel = field(default_factory=NoiseModel)
    rules: AgainRules = field(default_factory=AgainRules)

    def advise(
        self,
        plan: GraspPlan,
        part: Part,
        estimate: PartEstimate,
        now: Configuration,
        tags: TagLayout,
        rng: np.random.Generator,
    ) -> MeasureAdvice | None:
        """Advise to measure once more before a grasp, if that is expected to help.

        Args:
            plan: What would be done now.
            part: What is to be grasped.
            estimate: Where it seems to lie, with samples or a covariance, in the base frame of `now`.
            now: Where the robot is.
            tags: Tags of the part that are heard.
            rng: Draws poses and measurements.

        Returns:
            The best stop and what it would bring; None if no stop raises the success enough, or there is nothing to
            be unsure about, or no stop leaves the part alone.
        """
        if plan.success_probability is None:
            return None
        drawn = pose_samples(estimate, rng, self.rules.poses, shape=part.shape)
        if isinstance(drawn, Failure):
            return None
        poses = _spread(drawn, rng, self.rules.poses)
        points_m = tags.points_m + np.array([0.0, 0.0, estimate.height_m])
        try:
            offered = choose_next_stop(self.robot, now, self.proposer, poses[:_SCORED], points_m, self.noise)
        except OutOfReach:
            return None
        order = np.argsort(-offered.scores.gain_nat / offered.scores.seconds, kind="stable")[: self.rules.stops]
        successes = [
            self.successes(plan, part, poses, Hearing(self._anchors_m(now, offered.stops[i]), points_m), rng)
            for i in order
        ]
        best = int(np.argmax([row.mean() for row in successes]))
        after = float(successes[best].mean())
        if after < plan.success_probability + self.rules.least_rise:
            return None
        stop, spread = offered.stops[int(order[best])], float(successes[best].std())
        return MeasureAdvice(stop, plan.success_probability, after, spread, self.rules.outcomes)

    def successes(
        self, plan: GraspPlan, part: Part, poses: FloatArray, hearing: Hearing, rng: np.random.Generator
    ) -> FloatArray:
        """Success of the plan's grasp after each of the measurements that a stop could give, shape (H,).

        Args:
            plan: Its grasp of the part is the one that is repeated.
            part: What is grasped.
            poses: Poses in question, shape (S, 3).
            hearing: What the stop hears.
            rng: Draws truths and measurements.
        """
        truths = rng.choice(len(poses), self.rules.outcomes)
        weights = posteriors(poses, truths, hearing, self.noise, rng)
        rows = [
            self._success(plan, part, poses[rng.choice(len(poses), self.rules.judged, p=row)], _mean(poses, row))
            for row in weights
        ]
        return np.array(rows)

    def _success(self, plan: GraspPlan, part: Part, poses: FloatArray, mean: FloatArray) -> float:
        """Share of poses at which the grasp holds if it is aimed at the mean."""
        T_part_hands = _seen_from(poses, mean) @ plan.T_part_hand
        verdicts = judge_grasps(self.hand, part.shape, T_part_hands, opening_m=plan.aperture_m)
        return float((verdicts == 0).mean())

    def _anchors_m(self, now: Configuration, stop: ProposedStop) -> FloatArray:
        """Where the robot's tags would be, in the present base frame [m], shape (N, 3)."""
        own_m = self.robot.tag_positions(stop.configuration).points_m
        return np.asarray((now.base.inverse() @ stop.configuration.base).apply(own_m))


def _spread(samples: FloatArray, rng: np.random.Generator, count: int) -> FloatArray:
    """More poses of the same mean and covariance: drawn again, moved a little, and drawn together as much [Liu2001]."""
    drawn = samples[rng.choice(len(samples), count)]
    if len(samples) < 2:
        return drawn
    mean, covariance = samples.mean(axis=0), np.cov(samples.T)
    width = (4 / (5 * len(samples))) ** (1 / 7)  # Silverman's, in three dimensions
    moved = rng.multivariate_normal(np.zeros(3), covariance, count, method="svd")
    return np.asarray(mean + np.sqrt(1 - width**2) * (drawn - mean) + width * moved)


def _mean(poses: FloatArray, weights: FloatArray) -> FloatArray:
    """Weighted mean of poses, headings as directions, shape (3,)."""
    x, y = weights @ poses[:, :2]
    turn = np.angle(weights @ np.exp(1j * poses[:, 2]))
    return np.array([x, y, turn])


def _seen_from(poses: FloatArray, mean: FloatArray) -> FloatArray:
    """Pose `mean` of a part in the frame of each of some poses (S, 3), homogeneous, shape (S, 4, 4)."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    dx, dy, turn = mean[0] - poses[:, 0], mean[1] - poses[:, 1], mean[2] - poses[:, 2]
    T = np.tile(np.eye(4), (len(poses), 1, 1))
    T[:, 0, 0], T[:, 0, 1], T[:, 0, 3] = np.cos(turn), -np.sin(turn), c * dx + s * dy
    T[:, 1, 0], T[:, 1, 1], T[:, 1, 3] = np.sin(turn), np.cos(turn), c * dy - s * dx
    return T
