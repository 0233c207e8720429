"""Grasps in front of the robot, from the most likely to hold to the least, with quick reasons against the others.

Asked in this order, each of all grasps that are left: does the part fit between the jaws (`antipodal`), does the
approach suit the arm, does the hand stay above the floor, does the arm get there, does the grasp hold at the estimated
pose, and how likely does it hold over all that may be true?
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planners.antipodal import AntipodalRules, antipodal_grasps
from planners.grasp_question import GraspQuestion
from planners.grasp_queue import most_likely_first
from planners.hand_poses import floor_failures, into_arm_plane, reach_failures, turning_for
from planners.planar_arm import PlanarArm
from planners.success import GraspChance, success_probability
from rfcompass.arrays import FloatArray, read_only
from rfcompass.robots import Robot
from rfcompass.robots.hand import VERDICTS, judge_grasps
from rfcompass.types.grasp_noise import GraspDraws
from rfcompass.types.grasps import Failure, GraspCandidate
from rfcompass.types.hands import Hand
from rfcompass.types.record import Record


@dataclass(slots=True)
class RankedGrasp:
    """One grasp, with what is known about it so far.

    Attributes:
        candidate: The grasp in the part's frame; rejected, or scored by its shape.
        T_base_hand: Pose of the tool frame in the present base frame, shape (4, 4).
        chance: How likely it holds, over as many samples as it took to know that it is not the best; None where
            nobody needed to know.
    """

    candidate: GraspCandidate
    T_base_hand: FloatArray
    chance: GraspChance | None = None

    @property
    def is_open(self) -> bool:
        """True while nothing speaks against it."""
        return self.candidate.rejection is None

    def reject(self, failure: Failure) -> None:
        """Keep the reason, and the chance it would have had."""
        if self.chance is not None:
            failure = replace(failure, numbers=(*failure.numbers, ("probability", self.chance.probability)))
        self.candidate = replace(self.candidate, score=None, rejection=failure)

    @property
    def judged(self) -> GraspCandidate:
        """The candidate for a report: its score is its chance, where that is known."""
        if self.chance is None or not self.is_open:
            return self.candidate
        return replace(self.candidate, score=self.chance.probability)


@dataclass(frozen=True, slots=True)
class Tries(Record):
    """What may be true when a grasp is tried, one row for each sample.

    Attributes:
        samples: Poses x, y, θ of the part [m, m, rad], in no order, shape (S, 3).
        draws: Where the hand ends up and how slippery the part is.
    """

    samples: FloatArray
    draws: GraspDraws

    def __post_init__(self) -> None:
        """Freeze the array."""
        object.__setattr__(self, "samples", read_only(self.samples, "Tries.samples", (len(self.draws.friction), 3)))

    def first(self, count: int) -> "Tries":
        """The first of them."""
        draws = self.draws
        some = GraspDraws(draws.shifts_m[:count], draws.T_hand_turned[:count], draws.friction[:count])
        return Tries(self.samples[:count], some)


@dataclass(frozen=True, slots=True)
class GraspRanking:
    """Lists and ranks the grasps of parts for one robot.

    Attributes:
        robot: Whose hand.
        hand: The hand.
        arm: Its closed form; None if it has none.
        rules: Which grasps to list.
    """

    robot: Robot
    hand: Hand
    arm: PlanarArm | None
    rules: AntipodalRules

    def list_grasps(self, question: GraspQuestion, rng: np.random.Generator) -> tuple[GraspCandidate, ...]:
        """Grasps of the part by its shape alone; rng draws points on a mesh.

        Raises:
            PartError: If the surface of a mesh has holes, and no single convex piece stands for the solid.
        """
        hand, tool = self.hand, self.robot.tool
        return antipodal_grasps(
            question.part.shape, tool, opening_m=hand.greatest_m, friction=hand.friction, rng=rng, rules=self.rules
        )

    def place(self, question: GraspQuestion, listed: Sequence[GraspCandidate]) -> list[RankedGrasp]:
        """Put grasps of a part in front of the robot and reject what can be rejected quickly.

        Args:
            question: What is asked.
            listed: Grasps of the part.
        """
        T_base_part = question.T_base_part
        if self.arm is not None:
            turning = turning_for(self.arm, question.part.shape, self.rules.depth_m, self.hand.friction)
            listed = into_arm_plane(listed, self.robot, T_base_part, turning)
        rows = [RankedGrasp(row, T_base_part @ row.T_part_hand) for row in listed]
        self._reject_by_floor_and_reach(question, rows)
        self._reject_what_does_not_hold(question, rows)
        return rows

    def in_order(self, question: GraspQuestion, rows: Sequence[RankedGrasp], tries: Tries) -> Iterator[RankedGrasp]:
        """Yield the open grasps with their chances, most likely first; equals by their shape.

        Args:
            question: What is asked.
            rows: Grasps; their chances are filled in as far as they are needed.
            tries: What may be true.
        """
        left = _open(rows)
        steps: dict[int, Tries] = {}

        def weigh(i: int, count: int) -> GraspChance:
            now = steps.setdefault(count, tries.first(count))
            left[i].chance = chance = success_probability(
                self.hand, question.part, left[i].T_base_hand, now.samples, question.estimate.height_m, draws=now.draws
            )
            return chance

        scores = [row.candidate.score or 0.0 for row in left]
        for i, _ in most_likely_first(scores, len(tries.samples), weigh):
            yield left[i]

    def _reject_by_floor_and_reach(self, question: GraspQuestion, rows: Sequence[RankedGrasp]) -> None:
        floor_m, opening_m = question.world.floor_m, self.hand.greatest_m
        left = _open(rows)
        _reject(left, floor_failures(self.hand, _poses(left), opening_m, floor_m))
        if self.arm is not None:
            left = _open(rows)
            _reject(left, reach_failures(self.arm, self.robot, _poses(left), question.start))

    def _reject_what_does_not_hold(self, question: GraspQuestion, rows: Sequence[RankedGrasp]) -> None:
        left = _open(rows)
        if not left:
            return
        poses = np.array([row.candidate.T_part_hand for row in left])
        verdicts = [VERDICTS[code] for code in judge_grasps(self.hand, question.part.shape, poses)]
        _reject(left, [None if verdict == VERDICTS[0] else _does_not_hold(verdict) for verdict in verdicts])


def _open(rows: Sequence[RankedGrasp]) -> list[RankedGrasp]:
    return [row for row in rows if row.is_open]


def _poses(rows: Sequence[RankedGrasp]) -> FloatArray:
    return np.array([row.T_base_hand for row in rows]).reshape(-1, 4, 4)


def _reject(rows: Sequence[RankedGrasp], failures: Sequence[Failure | None]) -> None:
    for row, failure in zip(rows, failures, strict=True):
        if failure is not None:
            row.reject(failure)


def _does_not_hold(verdict: str) -> Failure:
    words = {
        "hand_hits_part": "the hand would come down on the part",
        "too_wide": "the part is wider here than the jaws open",
        "nothing_between_jaws": "there would be nothing between the jaws",
        "outside_friction_cone": "the jaws would slip",
        "not_opposite": "the jaws would touch beside each other",
    }
    return Failure(verdict, f"{words.get(verdict, verdict)}, with the part where it is thought to lie")
