"""Ways of a base made shorter: what a random tree finds is a way, not a good one.

Two places along the way are drawn, anywhere on its legs, and where the straight drive between them is free and shorter,
it takes the place of what was there. Of two searches the shorter way is kept.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from planners.motion_check import MotionChecker, between
from planners.navigation import plan_drive
from planners.path_search import SearchRules
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import Failure

# Ours. A radian of turning counts as in `planners.navigation`.
SEARCHES = 2
SHORTCUTS = 100
_LOOK_M = 0.1
_M_PER_RAD = 0.3


def plan_short_drive(
    checker: MotionChecker, start: Configuration, goal: Pose2, rng: np.random.Generator, rules: SearchRules
) -> tuple[Configuration, ...] | Failure:
    """Find a short way of the base that touches nothing; arguments and failures as for `plan_drive`.

    Returns:
        Configurations with straight drives between them; the straight drive wherever it is free.
    """
    ways: list[tuple[Configuration, ...]] = []
    for _ in range(SEARCHES):
        found = plan_drive(checker, start, goal, rng, rules)
        if isinstance(found, Failure):
            return min(ways, key=cost_m) if ways else found
        if found.searched == 0:
            return found.path
        ways.append(shortened(checker, found.path, rng))
    return min(ways, key=cost_m)


def shortened(
    checker: MotionChecker, path: Sequence[Configuration], rng: np.random.Generator, tries: int = SHORTCUTS
) -> tuple[Configuration, ...]:
    """Cut corners where that is free; the ends stay.

    Args:
        checker: What must not be touched.
        path: Configurations with free straight drives between them.
        rng: Draws where to cut.
        tries: How often.
    """
    rows = list(path)
    for _ in range(tries):
        if len(rows) < 3:
            break
        first, last = sorted(rng.uniform(0, len(rows) - 1, 2).tolist())
        i, j = int(first), int(last)
        if i == j:
            continue
        a, b = between(rows[i], rows[i + 1], first - i), between(rows[j], rows[j + 1], last - j)
        if cost_m([a, b]) < cost_m([a, *rows[i + 1 : j + 1], b]) - 1e-6 and _is_free(checker, a, b):
            rows = [*rows[: i + 1], a, b, *rows[j + 1 :]]
    return _fewest(checker, rows)


def _fewest(checker: MotionChecker, rows: Sequence[Configuration]) -> tuple[Configuration, ...]:
    """Leave out what a free straight drive can skip, from the start on: the wheels slip anew with each drive."""
    kept = [rows[0]]
    while kept[-1] is not rows[-1]:
        here = next(i for i, row in enumerate(rows) if row is kept[-1])
        ahead = range(len(rows) - 1, here + 1, -1)
        kept.append(next((rows[i] for i in ahead if _is_free(checker, rows[here], rows[i])), rows[here + 1]))
    return tuple(kept)


def _is_free(checker: MotionChecker, one: Configuration, other: Configuration) -> bool:
    """Whether a straight drive is free; a few looks spare most checks without gaps, which take longer."""
    looks = int(np.ceil(cost_m([one, other]) / _LOOK_M)) + 1
    if any(checker.checker.collides(between(one, other, t)) for t in np.linspace(0, 1, looks).tolist()):
        return False
    return checker.check(one, other).free


def cost_m(path: Sequence[Configuration]) -> float:
    """Length of a way, turns counted [m]."""
    moves = [one.base.inverse() @ other.base for one, other in pairwise(path)]
    return sum(float(np.hypot(move.x_m, move.y_m)) + _M_PER_RAD * abs(move.theta_rad) for move in moves)


def first_part(path: Sequence[Configuration], length_m: float) -> tuple[Configuration, ...]:
    """The beginning of a way, up to a length of driving [m]; all of it if it is shorter."""
    rows = [path[0]]
    for one, other in pairwise(path):
        move = one.base.inverse() @ other.base
        leg_m = float(np.hypot(move.x_m, move.y_m))
        if leg_m > length_m:
            return (*rows, between(one, other, length_m / leg_m))
        rows.append(other)
        length_m -= leg_m
    return tuple(rows)
