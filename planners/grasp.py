"""Choose a grasp of a part whose pose is only estimated, and plan every motion of it.

    plan = GraspPlanner(robot).plan(leg, estimate)          # GraspPlan, or a GraspFailure that says why

A placement T of the hand holds with the probability

    P(T) = 1/S Σ_s [with the part at z_s, the hand at T ε_s and friction μ_s it comes down around it and closes on it]

over samples z_s of the estimate and ε_s, μ_s of how tries differ (`success`). The grasp with the largest P whose
motions touch nothing is the answer: they are tried from the most likely on, so the first that can be done is the best.

What stands around is known, so whether hand or part meets it on the way is no matter of chance: that is checked without
gaps, with the part where it is thought to lie.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from planners.antipodal import AntipodalRules
from planners.drive_stage import DriveStage, plan_drive_stage
from planners.grasp_elsewhere import places_to_drive_to
from planners.grasp_failures import NO_GRASP, after, all_failed, drive_first, failed
from planners.grasp_question import GraspQuestion, ask
from planners.grasp_ranking import GraspRanking, RankedGrasp, Tries
from planners.grasp_stages import StagePlanner, StageRules, Stages
from planners.hand_joints import hand_joints
from planners.hand_poses import UNREACHABLE
from planners.path_search import SearchRules
from planners.planar_arm import read_planar_arm
from planners.success import pose_samples
from planners.task_map import TaskMap
from rfcompass.robots import Robot
from rfcompass.robots.grasp_judge import weight_failure
from rfcompass.robots.hand import hand_of
from rfcompass.types.configuration import Configuration
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.grasp_noise import GraspNoise
from rfcompass.types.grasps import Failure, GraspCandidate, GraspFailure, GraspPlan
from rfcompass.types.hands import Hand
from rfcompass.types.parts import Part
from rfcompass.types.record import Record
from rfcompass.types.shapes import Shape
from rfcompass.types.world import World

NOT_TRIED, TOO_UNLIKELY = "not_tried", "too_unlikely"

# Ours: grasps whose motions are planned from a place that the base would have to drive to.
_TRIES_THERE = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspRules(Record):
    """How to look for a grasp. All values are ours.

    Attributes:
        antipodal: Which grasps to list.
        stages: How a grasp is carried out.
        samples: Samples that a chance is computed over.
        noise: How tries of one grasp differ: where the hand ends up, and friction.
        least_chance: Chance below which a grasp is not worth a try.
        most_tries: Grasps whose motions are planned before giving up.
        drive: Where the part is out of reach and the base can bring it into reach: plan that drive as well. If not,
            the answer is a failure that says where to drive.
        drive_search: How hard to look for the way of the base.
    """

    antipodal: AntipodalRules = field(default_factory=AntipodalRules)
    stages: StageRules = field(default_factory=StageRules)
    samples: int = 1000
    noise: GraspNoise = field(default_factory=GraspNoise)
    least_chance: float = 0.01
    most_tries: int = 200
    drive: bool = False
    drive_search: SearchRules = field(default_factory=SearchRules)

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: If one is impossible.
        """
        if not (self.samples >= 1 and self.most_tries >= 1 and 0 <= self.least_chance <= 1):
            raise ValueError(f"GraspRules: counts and chance cannot be: {self.samples, self.most_tries}")


@dataclass(eq=False)
class GraspPlanner:
    """Plans grasps for one robot. Not to be shared among threads.

    Args:
        robot: Robot with a hand of two fingers. Its postures may overlap with themselves: see `grasp_worlds`.
        hand: Its hand; read from the URDF if None. A hand with its fingers mounted wider is weighed as such, while
            collisions are checked with the URDF's.
        rules: How to look for a grasp.
        task_map: What the arm can do from straight above: tells where to drive for a part that is out of reach.

    Raises:
        RobotModelError: If the description names no tool, or the hand is not of two fingers that slide.
    """

    robot: Robot
    hand: Hand | None = None
    rules: GraspRules = field(default_factory=GraspRules)
    task_map: TaskMap | None = None

    def __post_init__(self) -> None:
        """Read hand and arm."""
        self._hand = self.hand or hand_of(self.robot)
        self._joints = hand_joints(self.robot)
        arm = read_planar_arm(self.robot, soft=True)
        self._ranking = GraspRanking(self.robot, self._hand, arm, self.rules.antipodal)
        self._listed: tuple[Shape, tuple[GraspCandidate, ...]] | None = None

    def plan(
        self,
        part: Part,
        estimate: PartEstimate,
        world: World | None = None,
        start: Configuration | None = None,
        rng: np.random.Generator | None = None,
    ) -> GraspPlan | GraspFailure:
        """Choose and plan a grasp.

        Args:
            part: What to grasp.
            estimate: Where it seems to lie, in the present base frame.
            world: Floor and what else stands there, in the same frame; a floor under the base if None.
            start: Believed joints of the robot; the posture "scan", or at rest, if None.
            rng: Draws samples from a covariance, thins them, and seeds searches for ways; seed 0 if None, so that
                equal questions get equal answers.

        Returns:
            A plan; or a failure with every candidate and its reason: `"orientation_unknown"`, `"bad_covariance"`,
            `"part_in_the_floor"`, `"too_heavy"`, `"too_wide"` if it is so everywhere, `"start_collision"`,
            `"unreachable"` if the arm gets to none of the grasps, else `"no_grasp"` with how many fell for which
            reason. The last two have `base`, if a drive there helps: from there a grasp was found.

        Raises:
            PartError: If the surface of a mesh has holes, and no single convex piece stands for the solid.
            ShapeError: If `start` is of another robot.
        """
        rng = rng or np.random.default_rng(0)
        question = ask(self.robot, part, estimate, world or World(), start)
        if isinstance(question, Failure):
            return failed(question, ())
        if (heavy := weight_failure(self._hand, part.mass_kg)) is not None:
            return failed(heavy, ())
        answer = self._answer(question, rng, self.rules.most_tries)
        if isinstance(answer, GraspPlan) or answer.kind not in (UNREACHABLE, NO_GRASP) or not self.robot.is_mobile:
            return answer
        return self._elsewhere(question, answer, rng)

    def _elsewhere(
        self, question: GraspQuestion, failure: GraspFailure, rng: np.random.Generator
    ) -> GraspPlan | GraspFailure:
        """Look for a place of the base from which there is a grasp: drive there, or say so."""
        opened = self._joints.at_opening(question.start, self._hand, self._hand.greatest_m)
        listed = self._grasps_of(question)
        for base in places_to_drive_to(self.robot, question, listed, self.task_map, opened, rng):
            there = self._answer(question.from_base(base), rng, min(_TRIES_THERE, self.rules.most_tries))
            if not isinstance(there, GraspPlan):
                continue
            if not self.rules.drive:
                return drive_first(failure, base, there)
            drive = plan_drive_stage(self.robot, question.world, question.start, base, rng, self.rules.drive_search)
            if isinstance(drive, DriveStage):
                return after(drive, base, there)
        return failure

    def _answer(self, question: GraspQuestion, rng: np.random.Generator, most_tries: int) -> GraspPlan | GraspFailure:
        """Choose and plan a grasp from where the base stands."""
        stages = StagePlanner(
            self.robot, self._hand, self._joints, question.world, question.part.part_id, question.start,
            self.rules.stages, rng,
        )  # fmt: skip
        if stages.start_failure is not None:
            return failed(stages.start_failure, ())
        tries = self._tries(question, rng)
        if isinstance(tries, Failure):
            return failed(tries, ())
        rows = self._ranking.place(question, self._grasps_of(question))
        for row in rows:
            if row.is_open and (in_the_way := stages.blocked(row.T_base_hand)) is not None:
                row.reject(in_the_way)
        for count, row in enumerate(self._ranking.in_order(question, rows, tries)):
            if (why_not := self._not_worth_it(row, count, most_tries)) is not None:
                row.reject(why_not)
                continue
            found = stages.plan(row.T_base_hand, self._hand.greatest_m)
            if isinstance(found, Stages):
                return self._plan(question, row, found, rows)
            row.reject(found)
        return all_failed(question, rows)

    def _tries(self, question: GraspQuestion, rng: np.random.Generator) -> Tries | Failure:
        samples = pose_samples(question.estimate, rng, self.rules.samples, shape=question.part.shape)
        if isinstance(samples, Failure):
            return samples
        return Tries(rng.permutation(samples), self.rules.noise.draw(len(samples), rng))

    def _not_worth_it(self, row: RankedGrasp, count: int, most_tries: int) -> Failure | None:
        """Why a grasp is not tried, after `count` others."""
        if row.chance is not None and row.chance.probability < self.rules.least_chance:
            message = f"it would hold with a probability of {row.chance.probability:.3f} only"
            return Failure(TOO_UNLIKELY, message, (("least", self.rules.least_chance),))
        if count >= most_tries:
            return Failure(NOT_TRIED, f"{count} more likely grasps were tried before")
        return None

    def _grasps_of(self, question: GraspQuestion) -> tuple[GraspCandidate, ...]:
        """Grasps by shape alone; those of the part that was asked about last are remembered."""
        shape = question.part.shape
        if self._listed is None or self._listed[0] is not shape:
            self._listed = shape, self._ranking.list_grasps(question, np.random.default_rng(0))
        return self._listed[1]

    def _plan(
        self, question: GraspQuestion, row: RankedGrasp, stages: Stages, rows: Sequence[RankedGrasp]
    ) -> GraspPlan:
        chance, seen = row.chance, question.estimate
        is_point = not len(seen.samples) and seen.covariance is None
        return GraspPlan(
            configuration=stages.solution.configuration.joints,
            approach=stages.approach,
            retreat=stages.away,
            aperture_m=self._hand.greatest_m,
            clearance_m=stages.clearance_m,
            success_probability=None if is_point or chance is None else chance.probability,
            candidates=tuple(one.judged for one in rows),
            part_id=question.part.part_id,
            T_base_hand=row.T_base_hand,
            T_part_hand=row.candidate.T_part_hand,
            closed_m=stages.closed_m,
            success_sd=0.0 if is_point or chance is None else chance.standard_error,
            risks=() if chance is None else chance.risks,
            stages=stages.timed,
            solution=stages.solution,
            certificates=stages.certificates,
        )
