"""The shortest way of a base past the corners of what stands around, by a search that checks drives only when it must.

A shortest way among things with corners runs straight from corner to corner [LozanoPerez1979]. Here the base is no
point, so places to pass are poses beside each corner, at a few distances from it and with a few headings, and drives
between any two of them count by their length until a check says that they touch something. A* looks at drives in the
order of the ways that they would make, and checks one when it is about to use it: most never are [Cohen2014].

The way is shortest among these poses only; `planners.short_drive` cuts its corners afterwards.
"""

from collections.abc import Sequence
from dataclasses import replace
from heapq import heappop, heappush
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from planners.motion_check import MotionChecker, between
from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.configuration import Configuration
from rfcompass.types.world import Body

AreaM: TypeAlias = tuple[tuple[float, float], tuple[float, float]]

# Ours: how far beside each side of a corner the base's middle may pass [m]; the youBot is 0.38 m wide and 0.58 m long.
BESIDE_M = (0.25, 0.32, 0.42)
# Ours: what a radian of turning counts [m]. Turning takes time, not way, and a drive turns while it goes.
M_PER_RAD = 0.05
# Ours: two looks at a drive are so far apart [m]; what they miss the check without gaps finds, so many times.
LOOK_M = 0.08
CORE_M = 0.15  # ours: how far beside a body the base's middle can never be, if it can be nowhere over the body [m]
_REPAIRS = 20
MOST_LOOKS = 20_000  # ours: at single poses in one search


def way_past_corners(
    checker: MotionChecker, start: Configuration, goals: Sequence[Pose2], area_m: AreaM | None = None
) -> tuple[Configuration, ...]:
    """Find the shortest way to any of some poses; the straight drive to the first one wherever that is free.

    Args:
        checker: What must not be touched; the corners are those of the bodies in its world.
        start: Where the robot is, and how it holds its arm while it drives.
        goals: Poses to end at, any of them; those that are not free are left out.
        area_m: Lower and upper corner of where the base's centre may be [m]; None for everywhere.

    Returns:
        Configurations with free straight drives between them, the start first; empty if nothing was found.
    """
    ends = [end for end in (replace(start, base=goal) for goal in goals) if not checker.checker.collides(end)]
    if ends and ends[0].base == goals[0] and checker.check(start, ends[0]).free:
        return (start, ends[0])
    if not ends:
        return ()
    search = _Search(checker, start, [end.base for end in ends], area_m)
    for _ in range(_REPAIRS):
        path = search.path()
        blocked = next(((i, j) for i, j in pairwise(path) if not search.is_free(i, j)), None)
        if blocked is None:
            return tuple(search.configuration(i) for i in path)
        search.forbid(*blocked)
    return ()


def corner_poses(bodies: Sequence[Body], headings_rad: Sequence[float]) -> FloatArray:
    """Poses beside the corners of bodies, x, y [m] and heading [rad], shape (N, 3).

    Args:
        bodies: Upright ones; of others the corners of the bounding box, seen from above.
        headings_rad: With which headings each corner is passed, beside those of the body's own sides.
    """
    poses = []
    for body in bodies:
        own = float(np.arctan2(body.T_parent_body[1, 0], body.T_parent_body[0, 0]))
        turns = [*headings_rad, *(own + quarter * np.pi / 2 for quarter in range(4))]
        for beside_m in BESIDE_M:
            poses += [(*corner, turn) for corner in _corners_m(body, beside_m).tolist() for turn in turns]
    return np.array(poses).reshape(-1, 3)


class _Search:
    """Poses, which of them are free, and which drives between them were found to be blocked."""

    def __init__(
        self, checker: MotionChecker, start: Configuration, goals: Sequence[Pose2], area_m: AreaM | None
    ) -> None:
        self._checker, self._start, self._looks = checker, start, 0
        self._drives: dict[tuple[int, int], bool] = {}
        self._goals = range(1, 1 + len(goals))
        bodies = [body for body in checker.checker.model.world.bodies if body.stands_still]
        corners = corner_poses(bodies, (start.base.theta_rad, goals[0].theta_rad))
        if area_m is not None:
            corners = corners[((corners[:, :2] >= area_m[0]) & (corners[:, :2] <= area_m[1])).all(axis=1)]
        corners = corners[[not self._collides(self._at(row)) for row in corners]]
        self._cores = _Cores([body for body in bodies if self._is_core(body)])
        self._poses = np.concatenate([[_row(start.base)], [_row(goal) for goal in goals], corners])
        self._left_m = np.min([self._costs_m(goal) for goal in self._goals], axis=0)

    def _is_core(self, body: Body) -> bool:
        """Whether the base's middle can be nowhere in a body's outline, nor a little beside it."""
        corners = _corners_m(body, CORE_M)
        places = np.concatenate([corners, (corners + np.roll(corners, 1, axis=0)) / 2])
        turns = self._start.base.theta_rad + np.array([0.0, np.pi / 2])
        return all(self._collides(self._at(np.array([*at, turn]))) for at in places for turn in turns)

    def configuration(self, i: int) -> Configuration:
        return self._at(self._poses[i])

    def _at(self, row: FloatArray) -> Configuration:
        x_m, y_m, theta_rad = row.tolist()
        return replace(self._start, base=Pose2(x_m, y_m, theta_rad))

    def is_free(self, i: int, j: int) -> bool:
        """Check a drive without gaps."""
        return self._checker.check(self.configuration(i), self.configuration(j)).free

    def forbid(self, i: int, j: int) -> None:
        self._drives[min(i, j), max(i, j)] = False

    def path(self) -> tuple[int, ...]:
        """Shortest way by what is known of the drives so far; empty if there is none."""
        before: dict[int, int] = {}
        heap = [(float(self._left_m[0]), 0.0, 0, -1)]
        while heap and self._looks < MOST_LOOKS:
            _, done_m, here, parent = heappop(heap)
            if here in before or (parent >= 0 and not self._seems_free(parent, here)):
                continue
            before[here] = parent
            if here in self._goals:
                return self._back(before, here)
            costs_m = done_m + self._costs_m(here)
            costs_m[self._cores.crossed(self._poses[here, :2], self._poses[:, :2])] = np.inf
            for there in np.flatnonzero(np.isfinite(costs_m)).tolist():
                if there not in before:
                    heappush(heap, (float(costs_m[there] + self._left_m[there]), float(costs_m[there]), there, here))
        return ()

    @staticmethod
    def _back(before: dict[int, int], end: int) -> tuple[int, ...]:
        path = [end]
        while before[path[-1]] >= 0:
            path.append(before[path[-1]])
        return tuple(reversed(path))

    def _costs_m(self, i: int) -> FloatArray:
        offsets = self._poses - self._poses[i]
        turns = np.abs((offsets[:, 2] + np.pi) % (2 * np.pi) - np.pi)
        return np.asarray(np.hypot(offsets[:, 0], offsets[:, 1]) + M_PER_RAD * turns)

    def _seems_free(self, i: int, j: int) -> bool:
        """Look at a drive here and there: at its ends, in the middle, and ever closer."""
        key = min(i, j), max(i, j)
        if key not in self._drives:
            self._drives[key] = not self._meets(i, j)
        return self._drives[key]

    def _meets(self, i: int, j: int) -> bool:
        one, other = self.configuration(i), self.configuration(j)
        looks = max(2, int(np.ceil(float(self._costs_m(i)[j]) / LOOK_M)))
        halves = 2 ** int(np.ceil(np.log2(looks)))
        seen = 1
        while seen < halves:
            shares = (np.arange(seen) + 0.5) / seen
            if any(self._collides(between(one, other, t)) for t in shares.tolist()):
                return True
            seen *= 2
        return False

    def _collides(self, configuration: Configuration) -> bool:
        self._looks += 1
        return self._checker.checker.collides(configuration)


def _corners_m(body: Body, beside_m: float) -> FloatArray:
    """Corners of a body's outline, so much beside each of its sides [m], in turn, shape (4, 2)."""
    T, low_m, high_m = body.T_parent_body, body.shape.lower_m[:2] - beside_m, body.shape.upper_m[:2] + beside_m
    own_m = np.array([low_m, (high_m[0], low_m[1]), high_m, (low_m[0], high_m[1])])
    return np.asarray(own_m @ T[:2, :2].T + T[:2, 3])


class _Cores:
    """Outlines that no drive's middle crosses: most drives are ruled out by them, without a look at the robot."""

    def __init__(self, bodies: Sequence[Body] = ()) -> None:
        self._corners_m = np.array([_corners_m(body, CORE_M) for body in bodies]).reshape(-1, 4, 2)

    def crossed(self, from_m: FloatArray, to_m: FloatArray) -> BoolArray:
        """Whether straight lines from one point (2,) to others (N, 2) pass through an outline, shape (N,)."""
        found = np.zeros(len(to_m), dtype=np.bool_)
        for corners_m in self._corners_m:
            enter, leave = np.zeros(len(to_m)), np.ones(len(to_m))
            for along_m in (corners_m[1] - corners_m[0], corners_m[3] - corners_m[0]):
                at, rate = (from_m - corners_m[0]) @ along_m, (to_m - from_m) @ along_m
                with np.errstate(divide="ignore", invalid="ignore"):
                    meets = np.sort([-at / rate, (along_m @ along_m - at) / rate], axis=0)
                level = np.where(0.0 < at < along_m @ along_m, 1.0, -1.0) * np.inf  # a drive along the side
                enter = np.maximum(enter, np.where(rate == 0, -level, meets[0]))
                leave = np.minimum(leave, np.where(rate == 0, level, meets[1]))
            found |= enter < leave
        return found


def _row(pose: Pose2) -> tuple[float, float, float]:
    return pose.x_m, pose.y_m, pose.theta_rad
