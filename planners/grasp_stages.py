"""All motions of one grasp: there, down, close, up and away, each checked without gaps and certified by fcl.

    reach      from the start to the pre-grasp, hand open                  part stands, must not be touched
    approach   straight along the approach axis                           part stands, must not be touched
    close      the fingers alone                                          part stands, the fingers may touch it
    lift       straight up                                                part in the hand
    retreat    straight back against the approach axis, if the arm can    part in the hand

Cheap questions come first, so that most bad grasps cost a millisecond.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from planners.arm_path import plan_arm
from planners.certificates import certify
from planners.grasp_worlds import GraspWorlds, start_failure
from planners.hand_blocked import hand_blocked
from planners.hand_joints import HandJoints
from planners.ik import IkRules, InverseKinematics
from planners.margins import with_margin
from planners.motion_check import MotionChecker, MotionReport
from planners.path_search import SearchRules
from planners.path_timing import in_time
from planners.straight_motion import StraightMotion, move_straight
from rfcompass.arrays import FloatArray
from rfcompass.robots import CollisionModel, FclCollisions, QuickCollisions, Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasp_task import GraspTask, Solution
from rfcompass.types.grasps import Failure
from rfcompass.types.hands import Hand
from rfcompass.types.motions import APPROACH, CLOSE, LIFT, REACH, RETREAT, StageCertificate, TimedPath
from rfcompass.types.record import Record
from rfcompass.types.world import World

APPROACH_BLOCKED, CLOSE_BLOCKED, LIFT_BLOCKED = "approach_blocked", "close_blocked", "lift_blocked"
HITS_PART, NOT_CERTIFIED = "hand_hits_part", "not_certified"


@dataclass(frozen=True, slots=True, kw_only=True)
class StageRules(Record):
    """How a grasp is carried out. All values are ours.

    Attributes:
        beyond_m: How much further than its fingers are long the hand stands off before the approach [m].
        lift_m: Height to lift by [m].
        retreats_m: Lengths of the retreat, the first that can be done [m]; without any the plan ends with the lift.
        clearance_m: Distance to keep from all that must not be touched at the grasp, the part included [m].
        margin_m: What stands around counts as grown by this much, unless robot or part are nearer already [m].
        ik_starts: Starts of the optimisation, for arms without a closed form.
        reach: How hard to look for the way to the pre-grasp.
    """

    beyond_m: float = 0.01
    lift_m: float = 0.05
    retreats_m: tuple[float, ...] = (0.05, 0.025)
    clearance_m: float = 0.0
    margin_m: float = 0.005
    ik_starts: int = 8
    reach: SearchRules = field(default_factory=SearchRules)

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: If one is impossible.
        """
        lengths_are_good = self.beyond_m >= 0 and min(self.lift_m, *self.retreats_m, 1.0) > 0
        if not (lengths_are_good and min(self.clearance_m, self.margin_m) >= 0 and self.ik_starts >= 1):
            raise ValueError(f"StageRules: lengths and starts must be positive: {self}")


@dataclass(frozen=True, slots=True)
class Stages:
    """A grasp that was planned from start to end.

    Attributes:
        solution: Joint values at the grasp, certified.
        closed_m: Opening after closing on the part [m].
        approach: From pre-grasp to grasp, shape (A, Q).
        away: Lift and retreat, shape (B, Q).
        timed: Each stage in time.
        certificates: What each stage was checked against.
    """

    solution: Solution
    closed_m: float
    approach: FloatArray
    away: FloatArray
    timed: tuple[TimedPath, ...]
    certificates: tuple[StageCertificate, ...]

    @property
    def clearance_m(self) -> float:
        """Nothing comes nearer than this in any stage [m]."""
        return min(row.at_least_m for row in self.certificates)


@dataclass(frozen=True, slots=True)
class _Motion:
    """One stage before it is certified."""

    stage: str
    path: Sequence[Configuration]
    report: MotionReport
    model: CollisionModel


@dataclass(eq=False)
class StagePlanner:
    """Plans the motions of grasps of one part in one world.

    Args:
        robot: Robot with a hand.
        hand: Its hand.
        joints: How its fingers are driven.
        world: Floor and bodies in the present base frame, the part among them where it is thought to lie.
        part_name: Name of that body.
        start: Where the arm is.
        rules: How a grasp is carried out.
        rng: Seeds the searches for ways.
    """

    robot: Robot
    hand: Hand
    joints: HandJoints
    world: World
    part_name: str
    start: Configuration
    rules: StageRules
    rng: np.random.Generator

    def __post_init__(self) -> None:
        """Build what all grasps share: the part standing, and the part between the fingers."""
        self._start = Configuration(self.start.joints)
        self._ik_rules = IkRules(
            certify=False, explain=False, starts=self.rules.ik_starts, clearance_m=self.rules.clearance_m
        )
        around = with_margin(self.robot, self.world, self._start, self.rules.margin_m, self.part_name)
        self._worlds = GraspWorlds(self.robot, around, self.part_name, self.joints.fingers)
        self._ik = InverseKinematics(self.robot, model=self._worlds.standing, rules=self._ik_rules)
        self._close_checker = MotionChecker(QuickCollisions(self._worlds.closing))
        touching = self._ik.collisions.touching(self._start)
        self.start_failure = start_failure(self.robot, touching)
        self._reaching = self._worlds.reaching(touching) if self.start_failure is None else self._worlds.standing
        same = self._reaching is self._worlds.standing
        self._reach_checker = MotionChecker(self._ik.collisions if same else QuickCollisions(self._reaching))
        shared = (self._worlds.standing, self._worlds.closing, self._reaching)
        self._hand_blocked = hand_blocked(self._worlds.standing, self.opened(self.hand.greatest_m), self.part_name)
        self._fcl = {id(model): FclCollisions(model) for model in shared}

    @property
    def ik(self) -> InverseKinematics:
        """Solver with the part standing."""
        return self._ik

    def opened(self, opening_m: float) -> Configuration:
        """The start with the hand open."""
        return self.joints.at_opening(self._start, self.hand, opening_m)

    def blocked(self, T_base_hand: FloatArray) -> Failure | None:
        """Why a grasp cannot be done whatever the arm does: something stands where the open hand would be."""
        return self._hand_blocked(T_base_hand)

    def plan(self, T_base_hand: FloatArray, opening_m: float) -> Stages | Failure:
        """Plan all motions of one grasp.

        Args:
            T_base_hand: Pose of the tool frame at the grasp, shape (4, 4).
            opening_m: Opening of the jaws on the way there [m].

        Returns:
            The stages; or the failure of the first that cannot be done.
        """
        tool = self.robot.tool
        task = GraspTask.of_pose(T_base_hand, tool.approach_axis, tool.closing_axis)
        solution = self._ik.solve(task, self.opened(opening_m))
        if isinstance(solution, Failure):
            return self._of_the_part(solution)
        return self._around(task, solution, T_base_hand, opening_m)

    def _around(
        self, task: GraspTask, solution: Solution, T_base_hand: FloatArray, opening_m: float
    ) -> Stages | Failure:
        """The motions to the grasp and away from it."""
        grasp = solution.configuration
        if isinstance(approach := self._approach(task, grasp), Failure):
            return approach
        if isinstance(contacts := self._worlds.contacts(self.hand, T_base_hand, opening_m), Failure):
            return contacts
        closed = self.joints.at_opening(grasp, self.hand, contacts.width_m)
        if isinstance(close := self._close(grasp, closed), Failure):
            return close
        if isinstance(away := self._lift_and_retreat(task, closed), Failure):
            return away
        if isinstance(reach := self._reach(approach.path[0]), Failure):
            return reach
        return self._certified(solution, contacts.width_m, [reach, approach, close, *away])

    def _approach(self, task: GraspTask, grasp: Configuration) -> _Motion | Failure:
        fingers_m = -float(self.hand.palm_m[:, 1, 2].max(initial=-0.05))
        away = -(fingers_m + self.rules.beyond_m) * np.asarray(task.approach)
        motion = move_straight(self._ik, task, grasp, away)
        if isinstance(motion, Failure):
            return _because(APPROACH_BLOCKED, "on the straight approach", motion)
        path = [Configuration(row) for row in motion.reversed_path]
        return _Motion(APPROACH, path, motion.report, self._worlds.standing)

    def _close(self, grasp: Configuration, closed: Configuration) -> _Motion | Failure:
        report = self._close_checker.check(grasp, closed)
        if not report.free and report.clearance is not None:
            nearest = report.clearance
            message = f"while the jaws close, {nearest.first} touches {nearest.second}"
            return Failure(CLOSE_BLOCKED, message, (("first", nearest.first), ("second", nearest.second)))
        return _Motion(CLOSE, [grasp, closed], report, self._worlds.closing)

    def _lift_and_retreat(self, task: GraspTask, closed: Configuration) -> list[_Motion] | Failure:
        model = self._worlds.holding(self.robot.tool_pose(closed).homogeneous)
        ik = InverseKinematics(self.robot, model=model, rules=self._ik_rules)
        up = np.array([0.0, 0.0, self.rules.lift_m])
        lift = move_straight(ik, task, closed, up)
        if isinstance(lift, Failure):
            return _because(LIFT_BLOCKED, "while the part is lifted", lift)
        lifted = replace(task, point_m=task.point_m + up)
        away = [(LIFT, lift)]
        for length_m in self.rules.retreats_m:
            back = move_straight(ik, lifted, Configuration(lift.path[-1]), -length_m * np.asarray(task.approach))
            if isinstance(back, StraightMotion):
                away.append((RETREAT, back))
                break
        return [_Motion(stage, [Configuration(row) for row in one.path], one.report, model) for stage, one in away]

    def _reach(self, pregrasp: Configuration) -> _Motion | Failure:
        found = plan_arm(self._reach_checker, self._start, pregrasp, self.rng, self.rules.reach)
        if isinstance(found, Failure):
            return found
        return _Motion(REACH, found.path, found.report, self._reaching)

    def _of_the_part(self, failure: Failure) -> Failure:
        """A collision of the arm with the part itself has a name of its own."""
        names = dict(failure.numbers)
        if self.part_name in (names.get("first"), names.get("second")):
            return Failure(HITS_PART, failure.message, failure.numbers)
        return failure

    def _certified(self, solution: Solution, closed_m: float, motions: list[_Motion]) -> Stages | Failure:
        certificates = [self._certificate(motion) for motion in motions]
        for row in certificates:
            if not row.apart:
                message = f"fcl finds something touching in the stage {row.stage}, where the other checker does not"
                return Failure(NOT_CERTIFIED, message, (("stage", row.stage),))
        pairs = next(row.pairs for row in certificates if row.stage == APPROACH)
        certified = replace(solution, certified_pairs=pairs)
        paths = {motion.stage: np.array([row.joints for row in motion.path]) for motion in motions}
        away = [paths[stage] for stage in (LIFT, RETREAT) if stage in paths]
        timed = tuple(in_time(self.robot, motion.stage, motion.path) for motion in motions)
        return Stages(certified, closed_m, paths[APPROACH], np.concatenate(away), timed, tuple(certificates))

    def _certificate(self, motion: _Motion) -> StageCertificate:
        fcl = self._fcl.get(id(motion.model)) or FclCollisions(motion.model)
        return certify(fcl, motion.stage, motion.path, motion.report)


def _because(kind: str, where: str, cause: Failure) -> Failure:
    return Failure(kind, f"{where}: {cause.message}", (("cause", cause.kind), *cause.numbers))
