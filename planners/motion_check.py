"""Is a motion free of collision, all along the way? Conservative advancement, so that no gap is skipped.

Along the joint-space line q(t) = q0 + t (q1 - q0) no point of solid i can move against solid j faster than

    v_ij = Σ_k |Δq_k| R_ki + Σ_l |Δq_l| R_lj  [m per unit of t],

k over the joints that move i but not j, l over those that move j but not i, and R the reaches of `approach_bounds`.
With the distances d_ij at t, nothing can touch before t + min d_ij / v_ij: the next place to look at is half as far
away. Between two such places, s apart, a pair cannot come nearer than (d_ij + d'_ij - v_ij s) / 2.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from planners.approach_bounds import pair_reaches
from rfcompass.arrays import FloatArray
from rfcompass.robots.quick_collisions import QuickCollisions
from rfcompass.types.configuration import Configuration
from rfcompass.types.record import Record
from rfcompass.types.world import Clearance

# A touch shallower than this may be missed [m]; ours.
RESOLUTION_M = 1e-4


@dataclass(frozen=True, slots=True)
class MotionReport(Record):
    """What was found along a motion.

    Attributes:
        free: True if nothing touches anywhere.
        clearance: The nearest pair seen: where the motion is blocked, or the tightest place; None without pairs.
        at_least_m: No pair comes nearer than this anywhere [m]; 0 where the motion is blocked.
        at: Where the pair is that near, between 0 (start) and 1 (end).
        checks: Configurations that were looked at.
    """

    free: bool
    clearance: Clearance | None
    at_least_m: float
    at: float
    checks: int


NOTHING_NEAR = MotionReport(True, None, float("inf"), 0.0, 0)


@dataclass(eq=False)
class MotionChecker:
    """Checks motions of one robot in one world.

    Args:
        checker: Distances at single configurations.
        resolution_m: Touches shallower than this may be missed [m].
    """

    checker: QuickCollisions
    resolution_m: float = RESOLUTION_M
    _reach_m: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Bound how fast each pair can approach."""
        self._reach_m = pair_reaches(self.checker)

    def check(self, start: Configuration, end: Configuration) -> MotionReport:
        """Check the straight line between two configurations, of base and joints together.

        The base turns the shorter way and moves on a straight line. Its turn and travel are bounded like a joint's.
        """
        speed = self._speeds(start, end)
        if not speed.size:
            return NOTHING_NEAR
        walk = _Walk(self.checker.distances(start), speed)
        while not walk.blocked and walk.t < 1:
            t = min(1.0, walk.t + walk.step(self.resolution_m))
            walk.go_to(t, self.checker.distances(between(start, end, t)))
        clearance = Clearance(*self.checker.pair_names[walk.pair], walk.worst_m)
        return MotionReport(not walk.blocked, clearance, max(0.0, walk.at_least_m), walk.worst_at, walk.checks)

    def check_path(self, path: Sequence[Configuration]) -> MotionReport:
        """Check the straight lines between successive configurations; `at` counts along the whole path.

        Raises:
            ValueError: If the path has fewer than two configurations.
        """
        if len(path) < 2:
            raise ValueError(f"a path has two configurations or more, not {len(path)}")
        reports = []
        for start, end in pairwise(path):
            reports.append(self.check(start, end))
            if not reports[-1].free:
                break
        return _join(reports, len(path) - 1)

    def _speeds(self, start: Configuration, end: Configuration) -> FloatArray:
        """Bound of each pair's approach [m per unit of t], shape (P,)."""
        travel = self.checker.model.robot.kinematics.joint_map.gain @ (end.joints - start.joints)
        moved = start.base.inverse() @ end.base
        turn, way = abs(moved.theta_rad), float(np.hypot(moved.x_m, moved.y_m))
        return np.asarray(self._reach_m @ np.abs([*travel, turn, way]))


def between(start: Configuration, end: Configuration, t: float) -> Configuration:
    """The configuration at `t` on the straight line from start (0) to end (1)."""
    joints = start.joints + t * (end.joints - start.joints)
    if start.base == end.base:
        return Configuration(joints, start.base)
    moved = start.base.inverse() @ end.base
    part = type(moved)(t * moved.x_m, t * moved.y_m, t * moved.theta_rad)
    return Configuration(joints, start.base @ part)


def _join(reports: Sequence[MotionReport], count: int) -> MotionReport:
    """Reports of successive motions, out of `count`, as one."""

    def distance_m(i: int) -> float:
        clearance = reports[i].clearance
        return np.inf if clearance is None else clearance.distance_m

    worst = min(range(len(reports)), key=distance_m)
    tightest = reports[worst]
    at_least_m = min(report.at_least_m for report in reports)
    checks = sum(report.checks for report in reports)
    return MotionReport(reports[-1].free, tightest.clearance, at_least_m, (worst + tightest.at) / count, checks)


class _Walk:
    """Where a check has got to, and the nearest pair so far.

    Args:
        distances_m: Of all pairs at the start [m], shape (P,).
        speed: Bound of each pair's approach [m per unit of t], shape (P,).
    """

    def __init__(self, distances_m: FloatArray, speed: FloatArray) -> None:
        self.t, self.checks, self._speed, self._distances_m = 0.0, 1, speed, distances_m
        self.pair, self.worst_at = int(distances_m.argmin()), 0.0
        self.worst_m = self.at_least_m = float(distances_m.min())

    @property
    def blocked(self) -> bool:
        return self.worst_m <= 0

    def step(self, resolution_m: float) -> float:
        """How far to go: half of what is safe, or a step in which nothing moves further than the resolution."""
        moving = self._speed > 0
        if not moving.any():
            return 1.0
        safe = float((self._distances_m[moving] / self._speed[moving]).min())
        return max(safe / 2, resolution_m / float(self._speed.max()))

    def go_to(self, t: float, distances_m: FloatArray) -> None:
        bounds_m = (self._distances_m + distances_m - self._speed * (t - self.t)) / 2
        nearest = int(distances_m.argmin())
        self.at_least_m = min(self.at_least_m, float(bounds_m.min()), float(distances_m[nearest]))
        if distances_m[nearest] < self.worst_m:
            self.pair, self.worst_m, self.worst_at = nearest, float(distances_m[nearest]), t
        self.t, self._distances_m, self.checks = t, distances_m, self.checks + 1
