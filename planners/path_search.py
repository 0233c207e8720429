"""A path from one configuration to another around what must not be touched: RRT-Connect of OMPL.

The straight line is tried first. The search looks at single configurations, a step apart; what it finds is shortened
and then checked without gaps (`motion_check`), and where that finds a touch between two steps the search is repeated
with half the step. How much it may look at is counted in configurations, so that equal seeds give equal answers on
fast and slow machines alike.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from planners.motion_check import MotionChecker, MotionReport
from rfcompass.arrays import FloatArray, read_only
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import Failure
from rfcompass.types.record import Record

NO_PATH, START_BLOCKED, GOAL_BLOCKED = "no_path", "start_collision", "goal_collision"

# Ours: after so many searches, each with half the step of the last, the gap between checks is not the problem.
_SEARCHES = 3
_SHORTCUTS = 40
_LARGEST_SEED = 2**31 - 1


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchRules(Record):
    """How hard to look. All values are ours.

    Attributes:
        most_checks: Configurations that one search may look at.
        step: Distance of two checks along an edge, in weighted coordinates [rad or m].
        stride: Longest edge of the tree, in weighted coordinates [rad or m].
    """

    most_checks: int = 50_000
    step: float = 0.04
    stride: float = 0.6

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: If one is not above 0.
        """
        if not (self.most_checks >= 1 and self.step > 0 and self.stride > 0):
            raise ValueError(f"SearchRules: all must be above 0: {self}")


@dataclass(frozen=True, slots=True)
class FoundPath(Record):
    """A path that was checked without gaps.

    Attributes:
        path: Configurations, with straight motions between them; at least two.
        report: What the check found along the whole path.
        searched: Configurations that the search looked at; 0 if the straight line was free.
    """

    path: tuple[Configuration, ...]
    report: MotionReport
    searched: int


@dataclass(frozen=True, slots=True)
class SearchSpace:
    """What moves, and how far: coordinates between bounds, and the configurations they stand for.

    Attributes:
        lower: Least coordinates, shape (D,).
        upper: Greatest coordinates, shape (D,).
        weights: What a unit of each counts as a distance, shape (D,).
        build: Configuration of coordinates (D,).
    """

    lower: FloatArray
    upper: FloatArray
    weights: FloatArray
    build: Callable[[FloatArray], Configuration]

    def __post_init__(self) -> None:
        """Freeze the bounds."""
        for name in ("lower", "upper", "weights"):
            object.__setattr__(self, name, read_only(getattr(self, name), f"SearchSpace.{name}", (None,)))


def find_path(
    checker: MotionChecker,
    space: SearchSpace,
    start: FloatArray,
    goal: FloatArray,
    rng: np.random.Generator,
    rules: SearchRules | None = None,
) -> FoundPath | Failure:
    """Find a path from start to goal that touches nothing.

    Args:
        checker: What must not be touched.
        space: What moves.
        start: Coordinates to start at, shape (D,).
        goal: Coordinates to end at, shape (D,).
        rng: Seeds the search. OMPL's own generator is set by it, for the whole process.
        rules: How hard to look.

    Returns:
        A path; or a failure: `"start_collision"` or `"goal_collision"` with the pair that touches there, `"no_path"`
        if the search ended without one.
    """
    rules = rules or SearchRules()
    for kind, end in ((START_BLOCKED, start), (GOAL_BLOCKED, goal)):
        if (failure := _blocked(checker, kind, space.build(end))) is not None:
            return failure
    straight = [space.build(start), space.build(goal)]
    report = checker.check_path(straight)
    if report.free:
        return FoundPath(tuple(straight), report, 0)
    searched = 0
    for attempt in range(_SEARCHES):
        rows, checks = _search(checker, space, (start, goal), rng, rules, rules.step / 2**attempt)
        searched += checks
        if rows is None:
            break
        path = _shortened(checker, [space.build(row) for row in rows], rng)
        if (report := checker.check_path(path)).free:
            return FoundPath(tuple(path), report, searched)
    return _no_path(report, searched)


def _blocked(checker: MotionChecker, kind: str, end: Configuration) -> Failure | None:
    if not checker.checker.collides(end):
        return None
    nearest = checker.checker.nearest(end)
    if nearest is None or nearest.distance_m > 0:
        return None
    where = "start" if kind == START_BLOCKED else "goal"
    message = f"at the {where} {nearest.first} and {nearest.second} overlap by {-nearest.distance_m * 1e3:.1f} mm"
    return Failure(
        kind, message, (("first", nearest.first), ("second", nearest.second), ("depth_m", -nearest.distance_m))
    )


def _no_path(straight: MotionReport, searched: int) -> Failure:
    numbers: list[tuple[str, float | str]] = [("searched", float(searched))]
    message = f"no way was found that touches nothing, among {searched} configurations"
    if straight.clearance is not None and not straight.free:
        first, second = straight.clearance.first, straight.clearance.second
        message += f"; straight ahead {first} would touch {second}"
        numbers += [("first", first), ("second", second), ("at", straight.at)]
    return Failure(NO_PATH, message, tuple(numbers))


def _search(
    checker: MotionChecker,
    space: SearchSpace,
    ends: tuple[FloatArray, FloatArray],
    rng: np.random.Generator,
    rules: SearchRules,
    step: float,
) -> tuple[list[FloatArray] | None, int]:
    """One run of RRT-Connect: coordinates along the path, or None, and how many configurations were looked at."""
    counted = _Counted(checker, space)
    with _seeded_and_quiet(int(rng.integers(1, _LARGEST_SEED))):
        rows = _rrt_connect(counted, space, ends, rules, step)
    return rows, counted.count


@contextmanager
def _seeded_and_quiet(seed: int) -> Iterator[None]:
    """Seed OMPL's generators of the whole process, and keep it from writing to the terminal."""
    from ompl import util  # noqa: PLC0415 - slow to import, and most paths are straight

    util.noOutputHandler()
    try:
        util.RNG.setSeed(seed)
        yield
    finally:
        util.restorePreviousOutputHandler()


def _rrt_connect(
    counted: "_Counted", space: SearchSpace, ends: tuple[FloatArray, FloatArray], rules: SearchRules, step: float
) -> list[FloatArray] | None:
    from ompl import base, geometric  # noqa: PLC0415

    real = _real_space(base, space)
    information = base.SpaceInformation(real)
    information.setStateValidityChecker(counted)
    information.setStateValidityCheckingResolution(min(0.5, step / real.getMaximumExtent()))
    information.setup()
    problem = base.ProblemDefinition(information)
    problem.setStartAndGoalStates(*(_state(real, space, end) for end in ends), 1e-9)
    planner = geometric.RRTConnect(information)
    planner.setRange(rules.stride)
    planner.setProblemDefinition(problem)
    planner.setup()
    stop = base.PlannerTerminationCondition(lambda: counted.count > rules.most_checks)
    if str(planner.solve(stop)) != "Exact solution":
        return None
    path = problem.getSolutionPath()
    between_ends = [counted.coordinates(path.getState(i)) for i in range(1, path.getStateCount() - 1)]
    return [ends[0], *between_ends, ends[1]]


class _Counted:
    """Tells OMPL whether a state is free, and counts how often it was asked."""

    def __init__(self, checker: MotionChecker, space: SearchSpace) -> None:
        self._checker, self._space, self.count = checker.checker, space, 0

    def __call__(self, state: Any) -> bool:  # noqa: ANN401 - OMPL has no types
        self.count += 1
        return not self._checker.collides(self._space.build(self.coordinates(state)))

    def coordinates(self, state: Any) -> FloatArray:  # noqa: ANN401
        """A state of OMPL, whose coordinates are weighted, as ours."""
        weighted = [state[i] for i in range(len(self._space.weights))]
        return np.asarray(np.array(weighted) / self._space.weights)


def _real_space(base: Any, space: SearchSpace) -> Any:  # noqa: ANN401
    real, bounds = base.RealVectorStateSpace(len(space.lower)), base.RealVectorBounds(len(space.lower))
    for i, (low, high, weight) in enumerate(zip(space.lower, space.upper, space.weights, strict=True)):
        bounds.setLow(i, float(low * weight))
        bounds.setHigh(i, float(high * weight))
    real.setBounds(bounds)
    return real


def _state(real: Any, space: SearchSpace, values: FloatArray) -> Any:  # noqa: ANN401
    state = real.allocState()
    for i, value in enumerate(values * space.weights):
        state[i] = float(value)
    return state


def _shortened(checker: MotionChecker, path: Sequence[Configuration], rng: np.random.Generator) -> list[Configuration]:
    """Leave out waypoints where the straight motion past them is free."""
    rows = list(path)
    for _ in range(_SHORTCUTS):
        if len(rows) < 3:
            break
        i, j = sorted(rng.choice(len(rows), 2, replace=False))
        if j - i > 1 and checker.check(rows[i], rows[j]).free:
            del rows[i + 1 : j]
    return rows
