"""Inverse kinematics of grasp tasks: one call, and either joint values that were checked or the reason why not.

    solver = InverseKinematics(robot, world)
    answer = solver.solve(GraspTask(point_m, approach, closing), robot.posture("scan"))

An arm that yaws, pitches three times and rolls is solved in closed form: every branch is looked at, with alike jaws
either way round, and the nearest to the present posture that touches nothing is the answer. Any other arm, a base that
may drive, and a closed form of a family of answers that all touch something, go through the optimisation. Whoever
answers, pinocchio checks the pose and fcl certifies that nothing touches.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pinocchio as pin

from planners.closed_form import BEYOND_LIMIT, REACHED, solve_all
from planners.ik_failures import collision, joint_limit, out_of_reach, unreachable
from planners.ik_numeric import Attempt, NumericIk, NumericTask, Start, residual_tolerance
from planners.planar_arm import PlanarArm, read_planar_arm
from planners.task_forms import fixed_tasks, task_error
from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.robots import CollisionModel, FclCollisions, QuickCollisions, Robot
from rfcompass.robots.collision_model import homogeneous
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasp_task import GraspTask, Solution
from rfcompass.types.grasps import Failure
from rfcompass.types.record import Record
from rfcompass.types.world import Clearance, World

METHODS = ("auto", "closed_form", "nlp")

# A joint this near to its limit stands at it [rad or m].
_AT_LIMIT = 1e-6
# Starts of the search for an answer beyond the limits, which only explains a failure.
_FREE_STARTS = 4
# The roll, the last joint of a closed form's arm, turned by half a turn.
_HALF_TURN = np.array([0.0, 0.0, 0.0, 0.0, np.pi])


@dataclass(frozen=True, slots=True, kw_only=True)
class IkRules(Record):
    """What an answer must keep.

    Attributes:
        position_m: Largest distance of the tool from the task's point [m].
        angle_rad: Largest angle between an axis of the tool and the task's [rad].
        clearance_m: Distance to keep between all that must not touch [m].
        soft_limits: Keep the limits of the safety controller, where the URDF has them.
        starts: Starts of the optimisation.
        manipulability: How much the optimisation keeps away from singular postures where a task leaves it a choice
            [m²]; 1e-3 outweighs the present posture. The closed form takes no account of it.
        certify: Let fcl check the answer.
        explain: Look for the nearest pose where the closed form finds a task out of reach: milliseconds that a planner
            with many candidates may want to save.
        method: `"auto"`, `"closed_form"` (nothing else) or `"nlp"` (the optimisation, where a closed form exists too).
    """

    position_m: float = 1e-6
    angle_rad: float = 1e-6
    clearance_m: float = 0.0
    soft_limits: bool = True
    starts: int = 32
    manipulability: float = 0.0
    certify: bool = True
    explain: bool = True
    method: str = "auto"

    def __post_init__(self) -> None:
        """Check the numbers and the method.

        Raises:
            ValueError: If one is impossible.
        """
        if not (self.position_m > 0 and self.angle_rad > 0 and self.starts >= 1):
            raise ValueError("IkRules: tolerances and starts must be above 0")
        if not (np.isfinite(self.clearance_m) and self.clearance_m >= 0):
            raise ValueError(f"IkRules.clearance_m: {self.clearance_m} is not a finite distance >= 0")
        if not (np.isfinite(self.manipulability) and self.manipulability >= 0):
            raise ValueError(f"IkRules.manipulability: {self.manipulability} is not a finite weight >= 0")
        if self.method not in METHODS:
            raise ValueError(f"IkRules.method: {self.method!r} is none of {', '.join(METHODS)}")


@dataclass(eq=False)
class InverseKinematics:
    """Solves grasp tasks of one robot in one world. Not to be shared among threads.

    Args:
        robot: Robot with a tool.
        world: Floor and bodies in the present base frame; a floor under the base if None.
        rules: What an answer must keep.
        model: What may touch what, in place of `world`: with padding, tags as bodies, or pairs that may touch.

    Raises:
        RobotModelError: If the description names no tool.
        ValueError: If only the closed form may be used, and the arm has none; or the model is of another robot, or
            comes beside a world.
    """

    robot: Robot
    world: World | None = None
    rules: IkRules = field(default_factory=IkRules)
    model: CollisionModel | None = None

    def __post_init__(self) -> None:
        """Read the arm and the solids."""
        if self.model is not None and (
            self.world is not None or self.model.robot.joint_names != self.robot.joint_names
        ):
            raise ValueError("a model comes in place of a world, and with the same robot")
        self._model = self.model or CollisionModel(self.robot, self.world or World())
        self._quick = QuickCollisions(self._model)
        self._arm = read_planar_arm(self.robot, soft=self.rules.soft_limits)
        if self.rules.method == "closed_form" and self._arm is None:
            raise ValueError(f"the arm of {self.robot.name} has no closed form here")
        self._columns = [self.robot.joint_names.index(name) for name in self.robot.arm_joints]
        self._numeric: dict[bool, NumericIk] = {}

    @property
    def collisions(self) -> QuickCollisions:
        """The collision checker, for whoever goes on planning with the answer."""
        return self._quick

    @property
    def has_closed_form(self) -> bool:
        """True if the arm is solved in closed form while its base stands."""
        return self._arm is not None and self.rules.method != "nlp"

    @cached_property
    def _certifier(self) -> FclCollisions:
        return FclCollisions(self._model)

    def solve(
        self, task: GraspTask, start: Configuration | None = None, *, base_free: bool = False
    ) -> Solution | Failure:
        """Find joint values, and a base pose if it may drive, that do a task.

        Args:
            task: Where the tool must be, in the present base frame.
            start: Present joints: the answer is near them, and those outside the arm stay; at rest if None.
            base_free: The base may drive; the answer's `configuration.base` is where to, in the present base frame.

        Returns:
            A solution; or a failure: `"unreachable"` with the nearest pose, `"joint_limit"` with the joint,
            `"self_collision"` or `"scene_collision"` with the pair and its depth.

        Raises:
            ShapeError: If `start` is of another robot.
            ValueError: If a base that cannot drive is to be free.
        """
        if base_free and not self.robot.is_mobile:
            raise ValueError(f"the base of {self.robot.name} is fixed")
        present = self.robot.configuration(None if start is None else start.joints)
        if self._arm is None or base_free or self.rules.method == "nlp":
            return self._optimise(task, present, base_free)
        return self._in_closed_form(self._arm, task, present)

    def branches(self, task: GraspTask, start: Configuration | None = None) -> list[Configuration]:
        """Every branch of the closed form inside the limits, nearest to the start first, touching or not.

        Raises:
            ValueError: If the arm has no closed form.
        """
        if self._arm is None:
            raise ValueError(f"the arm of {self.robot.name} has no closed form here")
        present = self.robot.configuration(None if start is None else start.joints)
        q, status, *_ = self._solve_all(self._arm, task, present)
        return self._ordered(self._arm, task, q[status == REACHED], present)

    def does(self, task: GraspTask, configuration: Configuration) -> bool:
        """True if a configuration does a task within the tolerances, whatever it touches."""
        position_m, angle_rad = task_error(task, self._tool_pose(configuration), self.robot.tool)
        return position_m <= self.rules.position_m and angle_rad <= self.rules.angle_rad

    def blocked_by(self, task: GraspTask, nearest: Clearance) -> Failure:
        """The failure of a task, or of a motion from it, that a pair of things prevents."""
        return collision(task, nearest, self.rules.clearance_m, self.robot.kinematics.link_names)

    def within_limits(self, tasks: FloatArray, start: Configuration) -> BoolArray:
        """Which of many tasks the closed form reaches, touching or not, shape (B,).

        Args:
            tasks: Tool position [m], approach and closing axis (NaN if free), shape (B, 9).
            start: Present joints.

        Raises:
            ValueError: If the arm has no closed form.
        """
        if self._arm is None:
            raise ValueError(f"the arm of {self.robot.name} has no closed form here")
        _, status, *_ = solve_all(self._arm, np.ascontiguousarray(tasks), start.joints[self._columns], True)
        return np.asarray((status == REACHED).any(axis=1))

    def _solve_all(
        self, arm: PlanarArm, task: GraspTask, present: Configuration
    ) -> tuple[FloatArray, IntArray, IntArray, FloatArray]:
        near = present.joints[self._columns]
        return solve_all(arm, fixed_tasks(arm, task), near, task.jaws_alike)

    def _ordered(
        self, arm: PlanarArm, task: GraspTask, arms: FloatArray, present: Configuration
    ) -> list[Configuration]:
        """Arm joints (B, 5) as configurations, nearest first; those with the jaws the other way round too."""
        if task.jaws_alike:
            turned = np.concatenate([arms + _HALF_TURN, arms - _HALF_TURN])
            inside = ((turned >= arm.lower) & (turned <= arm.upper)).all(axis=1)
            arms = np.concatenate([arms, turned[inside]])
        order = np.argsort(np.abs(arms - present.joints[self._columns]).sum(axis=1), kind="stable")
        return [self._with_arm(arm, present) for arm in arms[order]]

    def _with_arm(self, arm: FloatArray, present: Configuration) -> Configuration:
        joints = present.joints.copy()
        joints[self._columns] = arm
        return Configuration(joints)

    def _in_closed_form(self, arm: PlanarArm, task: GraspTask, present: Configuration) -> Solution | Failure:
        q, status, joint, beyond = self._solve_all(arm, task, present)
        found = self._ordered(arm, task, q[status == REACHED], present)
        for tries, configuration in enumerate(found, start=1):
            if (solution := self._accept(task, configuration, "closed_form", tries)) is not None:
                return solution
        if _is_family(task) and self.rules.method == "auto":
            return self._optimise(task, present, base_free=False)
        if found:
            return self._all_touch(task, found)
        if (status == BEYOND_LIMIT).any():
            least = np.where(status == BEYOND_LIMIT, beyond, np.inf).argmin()
            name = self.robot.arm_joints[int(joint.flat[least])]
            return joint_limit(task, [(name, float(beyond.flat[least]))])
        return self._too_far(task, present)

    def _too_far(self, task: GraspTask, present: Configuration) -> Failure:
        """The failure of a task that the closed form rules out; with the nearest pose, if it is to be explained."""
        if not self.rules.explain:
            return out_of_reach(task)
        problem = NumericTask(self._numeric_ik(base_free=False), task, present)
        attempts = [(problem.reach(start), start) for start in problem.starts(2)]
        best, start = min(attempts, key=lambda row: row[0].residual)
        nearest = min(best, problem.come_near(best, start), key=lambda attempt: attempt.residual)
        return self._unreachable(task, nearest)

    def _optimise(self, task: GraspTask, present: Configuration, base_free: bool) -> Solution | Failure:
        numeric = self._numeric_ik(base_free)
        problem = NumericTask(numeric, task, present)
        tolerance = residual_tolerance(self.rules.position_m, self.rules.angle_rad)
        attempts = []
        for k, start in enumerate(problem.starts(self.rules.starts)):
            attempt = problem.reach(start)
            attempts.append((attempt, start))
            if attempt.residual <= tolerance and (solution := self._accept_or_avoid(problem, attempt, start, k)):
                return solution
        attempts.sort(key=lambda row: row[0].residual)
        best, start = attempts[0]
        if best.residual > tolerance:
            nearest = min(best, problem.come_near(best, start), key=lambda attempt: attempt.residual)
            solution = self._accept(task, nearest.configuration, nearest.method, self.rules.starts + 1)
            return solution or self._out_of_reach(problem, nearest, tolerance)
        slow = problem.avoid_slowly(best, start, self.rules.clearance_m)
        solution = self._accept(task, slow.configuration, slow.method, self.rules.starts + 1)
        done = [attempt.configuration for attempt, _ in attempts if attempt.residual <= tolerance]
        return solution or self._all_touch(task, done)

    def _accept_or_avoid(self, problem: NumericTask, attempt: Attempt, start: Start, k: int) -> Solution | None:
        """Take an attempt as it is; or, if it touches something, what keeping a distance makes of it."""
        if (solution := self._accept(problem.task, attempt.configuration, attempt.method, k + 1)) is not None:
            return solution
        around = problem.avoid(attempt, start, k, self.rules.clearance_m)
        return self._accept(problem.task, around.configuration, around.method, k + 1)

    def _numeric_ik(self, base_free: bool) -> NumericIk:
        if base_free not in self._numeric:
            self._numeric[base_free] = NumericIk(
                self._model, base_free, self.rules.soft_limits, self.rules.manipulability
            )
        return self._numeric[base_free]

    def _accept(self, task: GraspTask, configuration: Configuration, method: str, tries: int) -> Solution | None:
        """A solution, if it does the task and keeps its distance from everything."""
        position_m, angle_rad = task_error(task, self._tool_pose(configuration), self.robot.tool)
        if position_m > self.rules.position_m or angle_rad > self.rules.angle_rad:
            return None
        if self._quick.collides(configuration):
            return None
        nearest = self._quick.nearest(configuration)
        if nearest is not None and nearest.distance_m <= self.rules.clearance_m:
            return None
        if self.rules.certify and self._certifier.collides(configuration):
            return None
        at_limit = self._at_limit(configuration)
        certified = self._certifier.pair_count if self.rules.certify else None
        return Solution(configuration, method, position_m, angle_rad, at_limit, nearest, tries, certified)

    def _tool_pose(self, configuration: Configuration) -> "pin.SE3":
        """Pose of the tool in the present base frame."""
        return pin.SE3(homogeneous(configuration.base)) * self.robot.tool_pose(configuration)

    def _at_limit(self, configuration: Configuration) -> tuple[str, ...]:
        values, limits = configuration.joints, self.robot.limits
        soft = self.rules.soft_limits
        lower, upper = (limits.soft_lower, limits.soft_upper) if soft else (limits.lower, limits.upper)
        near = np.minimum(values - lower, upper - values) < _AT_LIMIT
        return tuple(self.robot.joint_names[i] for i in self._columns if near[i])

    def _all_touch(self, task: GraspTask, configurations: list[Configuration]) -> Failure:
        """Name the pair that touches in the answer that touches least."""
        nearest = [self._quick.nearest(configuration) for configuration in configurations]
        least = max((row for row in nearest if row is not None), key=lambda row: row.distance_m)
        return self.blocked_by(task, least)

    def _out_of_reach(self, problem: NumericTask, best: Attempt, tolerance: float) -> Failure:
        """Tell a limit of one joint from a task that no joint values do."""
        beyond = []
        for start in problem.starts(_FREE_STARTS):
            attempt = problem.reach_beyond_limits(start)
            if attempt.residual <= tolerance and (rows := problem.ik.beyond(attempt.configuration)):
                beyond.append(rows)
        if beyond:
            return joint_limit(problem.task, min(beyond, key=lambda rows: rows[0][1]))
        return self._unreachable(problem.task, best)

    def _unreachable(self, task: GraspTask, nearest: Attempt) -> Failure:
        T = self._tool_pose(nearest.configuration)
        return unreachable(task, T, task_error(task, T, self.robot.tool))


def _is_family(task: GraspTask) -> bool:
    """True if a task has more answers than the closed form lists: a pitch or a roll may be anything."""
    return task.approach is None or task.closing is None or (task.any_heading and task.is_vertical)
