"""Inverse kinematics by optimisation, for any arm: from several starts, the same ones in every call."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from planners.ik_program import DIRECTION_WEIGHT_M, IkProgram, box_parameters, recent_program
from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import CollisionModel
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasp_task import GraspTask
from rfcompass.types.world import WORLD

# Ours. How the links' spheres grow from those inside (0) to those that cover them (1), start after start.
_SIZES = (0.5, 0.0, 1.0)
# How far the base may drive in one go [m], and how heavy a metre or a radian of it is beside a radian of a joint.
_DRIVE_M, _BASE_PULL = 20.0, 4.0
# Newton: steps at most, the residual at which it is done, and the one from which it does not start [m]; the smallest
# singular value that counts, relative to the largest.
_NEWTON_STEPS = 40
_DONE, _HOPELESS = 1e-12, 0.05
_RANK = 1e-6
# An axis with a horizontal part below this has no heading.
_LEVEL = 0.1


class Start(NamedTuple):
    """Where to begin.

    Attributes:
        x: Variables, shape (X,).
        reference: Variables that the answer should be near to, shape (X,).
        numbers: The task, with the jaws either way round if they are alike, shape (9,).
    """

    x: FloatArray
    reference: FloatArray
    numbers: FloatArray


class Attempt(NamedTuple):
    """Where a start led.

    Attributes:
        configuration: Joints and base.
        residual: Norm of the task's residual, directions times `DIRECTION_WEIGHT_M` [m].
        method: `"sqp"` or `"ipopt"`.
    """

    configuration: Configuration
    residual: float
    method: str


@dataclass(eq=False)
class NumericIk:
    """The optimisation of one robot in one world.

    Args:
        model: Robot and world.
        base_free: The base may drive.
        soft: Keep the narrower limits of the safety controller.
        manipulability: Weight of the manipulability [m²].
    """

    model: CollisionModel
    base_free: bool = False
    soft: bool = True
    manipulability: float = 0.0
    program: IkProgram = field(init=False, repr=False)
    lower: FloatArray = field(init=False, repr=False)
    upper: FloatArray = field(init=False, repr=False)
    draw_bounds: tuple[FloatArray, FloatArray] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Make the program and its bounds."""
        self.program = recent_program(self.model, self.base_free, self.manipulability)
        limits = self.model.robot.limits
        lower, upper = (limits.soft_lower, limits.soft_upper) if self.soft else (limits.lower, limits.upper)
        columns = self.program.columns
        drive = np.array([_DRIVE_M, _DRIVE_M, 2 * np.pi][: 3 * self.base_free])
        self.lower = np.concatenate([lower[columns], -drive])
        self.upper = np.concatenate([upper[columns], drive])
        self.boxes = box_parameters([solid for solid in self.model.solids if solid.carrier == WORLD])
        low, high = self.lower[: len(columns)], self.upper[: len(columns)]
        low, high = np.maximum(low, np.minimum(high, 0) - 2 * np.pi), np.minimum(high, np.maximum(low, 0) + 2 * np.pi)
        self.draw_bounds = low, high

    @property
    def free_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Bounds as if every joint turned freely; sliding joints and the base keep theirs."""
        keeps = self.upper - self.lower < 1.0
        keeps[len(self.program.columns) :] = True
        return np.where(keeps, self.lower, -2 * np.pi), np.where(keeps, self.upper, 2 * np.pi)

    def beyond(self, configuration: Configuration) -> list[tuple[str, float]]:
        """Arm joints outside their limits, and how far, the shorter way round [rad or m]; furthest first."""
        values = configuration.joints[self.program.columns]
        turns = values + np.array([[0.0], [-2 * np.pi], [2 * np.pi]])
        count = len(values)
        out = np.maximum(self.lower[:count] - turns, turns - self.upper[:count]).min(axis=0)
        rows = zip(self.model.robot.arm_joints, map(float, out), strict=True)
        return sorted(((name, by) for name, by in rows if by > 1e-9), key=lambda row: -row[1])

    def x_of(self, configuration: Configuration) -> FloatArray:
        """Variables of a configuration."""
        joints, base = configuration.joints[self.program.columns], configuration.base
        return np.concatenate([joints, [base.x_m, base.y_m, base.theta_rad][: 3 * self.base_free]])

    def configuration(self, x: FloatArray, present: Configuration) -> Configuration:
        """Configuration of variables; joints outside the arm as at present."""
        joints, count = present.joints.copy(), len(self.program.columns)
        joints[self.program.columns] = x[:count]
        return Configuration(joints, Pose2(*x[count:]))


@dataclass(eq=False)
class NumericTask:
    """One task for the optimisation.

    Args:
        ik: Robot and world.
        task: Where the tool must be, in the present base frame.
        present: Present joints.
    """

    ik: NumericIk
    task: GraspTask
    present: Configuration

    def starts(self, count: int) -> Iterator[Start]:
        """The present posture with the jaws both ways round, then fixed draws inside the limits."""
        columns = self.ik.program.columns
        low, high = self.ik.draw_bounds
        present = np.clip(self.present.joints[columns], low, high)
        for k in range(min(2, count)):
            yield self._start(present, flipped=k == 1)
        rng = np.random.default_rng(0)
        for k in range(2, count):
            yield self._start(rng.uniform(low, high), flipped=k % 2 == 1)

    def reach(self, start: Start) -> Attempt:
        """Solve from one start without looking at distances."""
        return self._solve(self.ik.program.plain, start, size=0.0)

    def avoid(self, attempt: Attempt, start: Start, k: int, clearance_m: float) -> Attempt:
        """Solve from where an attempt ended, keeping a distance from everything; `k` counts the starts."""
        again = start._replace(x=self.ik.x_of(attempt.configuration))
        return self._solve(self.ik.program.guarded, again, size=_SIZES[k % len(_SIZES)], clearance_m=clearance_m)

    def avoid_slowly(self, attempt: Attempt, start: Start, clearance_m: float) -> Attempt:
        """The same by the interior-point solver, with the smallest spheres."""
        again = start._replace(x=self.ik.x_of(attempt.configuration))
        found = self._solve(self.ik.program.fallback, again, size=0.0, clearance_m=clearance_m)
        return found._replace(method="ipopt")

    def come_near(self, attempt: Attempt, start: Start) -> Attempt:
        """Lower the residual of an attempt that does not reach, with second derivatives."""
        again = start._replace(x=self.ik.x_of(attempt.configuration))
        return self._solve(self.ik.program.nearest, again, size=0.0)._replace(method="ipopt")

    def reach_beyond_limits(self, start: Start) -> Attempt:
        """Solve as if every joint turned freely."""
        return self._solve(self.ik.program.plain, start, size=0.0, bounds=self.ik.free_bounds)

    def _start(self, joints: FloatArray, *, flipped: bool) -> Start:
        robot, full = self.ik.model.robot, self.present.joints.copy()
        full[self.ik.program.columns] = joints
        T = robot.tool_pose(Configuration(full))
        base = self._base_below(T) if self.ik.base_free else Pose2()
        closing = _turned(base, T.rotation @ robot.tool.closing_axis)
        approach, wanted = (np.zeros(3) if axis is None else axis for axis in (self.task.approach, self.task.closing))
        if self.task.jaws_alike and (closing @ wanted < 0) != flipped:
            wanted = -wanted
        x = self.ik.x_of(Configuration(full, base))
        return Start(x, x, np.concatenate([self.task.point_m, approach, wanted]))

    def _base_below(self, T: "pin.SE3") -> Pose2:
        """Where the base brings a tool over the task's point, and to its heading."""
        tool, turn = self.ik.model.robot.tool, 0.0
        for wanted, axis in ((self.task.approach, tool.approach_axis), (self.task.closing, tool.closing_axis)):
            got = T.rotation @ axis
            if wanted is not None and min(np.hypot(*wanted[:2]), np.hypot(*got[:2])) > _LEVEL:
                turn = float(np.arctan2(wanted[1], wanted[0]) - np.arctan2(got[1], got[0]))
                break
        x_m, y_m = self.task.point_m[:2] - Pose2(0.0, 0.0, turn).apply(T.translation[:2])
        return Pose2(x_m, y_m, turn)

    def _solve(
        self,
        solver: Any,  # noqa: ANN401 - casadi has no types
        start: Start,
        *,
        size: float,
        clearance_m: float | None = None,
        bounds: tuple[FloatArray, FloatArray] | None = None,
    ) -> Attempt:
        p = self._parameters(start, size)
        lower, upper = bounds or (self.ik.lower, self.ik.upper)
        guard = {} if clearance_m is None else {"lbg": clearance_m, "ubg": np.inf}
        found = solver(x0=start.x, p=p, lbx=lower, ubx=upper, **guard)
        residual = self.ik.program.residual
        x, size_m = newton(lambda x: residual(x, p), np.asarray(found["x"]).ravel(), lower, upper)
        return Attempt(self.ik.configuration(x, self.present), size_m, "sqp")

    def _parameters(self, start: Start, size: float) -> FloatArray:
        task, program = self.task, self.ik.program
        upright = task.any_heading and task.is_vertical
        any_heading = task.any_heading and not upright
        weights = [task.approach is not None, task.closing is not None and not upright, any_heading]
        pull = np.ones(len(self.ik.lower))
        pull[len(program.columns) :] = _BASE_PULL
        return program.parameters(
            task=start.numbers, weights=np.array(weights, dtype=np.float64), joints=self.present.joints,
            reference=start.reference, pull=pull, size=size, floor=self.ik.model.world.floor_m or 0.0,
            boxes=self.ik.boxes,
        )  # fmt: skip


def newton(
    residual: Callable[[FloatArray], tuple[Any, Any]], x: FloatArray, lower: FloatArray, upper: FloatArray
) -> tuple[FloatArray, float]:
    """Take the shortest Newton steps to r(x) = 0 inside bounds, as long as they help.

    Args:
        residual: Function x -> r, dr/dx.
        x: Where to begin, shape (X,).
        lower: Bounds, shape (X,).
        upper: Bounds, shape (X,).

    Returns:
        The last x, and the norm of its residual.
    """
    x = np.clip(x, lower, upper)
    r, J = (np.asarray(part) for part in residual(x))
    for _ in range(_NEWTON_STEPS):
        size = np.linalg.norm(r)
        if size < _DONE or size > _HOPELESS:
            break
        step = _shortest_step(J, r.ravel(), x, (lower, upper))
        new = np.clip(x + step, lower, upper)
        r_new, J_new = (np.asarray(part) for part in residual(new))
        if np.linalg.norm(r_new) >= size:
            break
        x, r, J = new, r_new, J_new
    return x, float(np.linalg.norm(r))


def _shortest_step(J: FloatArray, r: FloatArray, x: FloatArray, bounds: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Least-norm solution of J step = -r; what stands at a bound and would leave stays."""
    lower, upper = bounds
    step = np.linalg.lstsq(J, -r, rcond=_RANK)[0]
    free = ~(((x <= lower) & (step < 0)) | ((x >= upper) & (step > 0)))
    if not free.all():
        step = np.zeros(len(x))
        step[free] = np.linalg.lstsq(J[:, free], -r, rcond=_RANK)[0]
    return np.asarray(step, dtype=np.float64)


def _turned(base: Pose2, direction: FloatArray) -> FloatArray:
    """A direction of the base frame in the frame that the base stands in, shape (3,)."""
    return np.concatenate([base.rotation @ direction[:2], direction[2:]])


def residual_tolerance(position_m: float, angle_rad: float) -> float:
    """Residual below which both tolerances are surely met."""
    return min(position_m, DIRECTION_WEIGHT_M * angle_rad)
