"""All poses that meet a set of rows: a solid in (x0, y0, θ), known exactly at each θ, where it is a polygon."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.geometry.angles import angle_difference
from rfcompass.localization.pose_kernels import can_break, moments, ranges_alive, slices
from rfcompass.localization.problem import PartitionProblem
from rfcompass.localization.regions import convex_hull

_SLICES = 64  # at least that many over the solid, unless it is too thin
_FIRST_RANGES = 32
_MAX_HALVINGS = 30  # ranges of 2e-10 rad


@dataclass(frozen=True, slots=True)
class PoseSet:
    """Poses (x0, y0, θ) of unit norm inside all rows and the bounds, cut into slices of θ.

    Attributes:
        theta_rad: Middle of each slice [rad], shape (T,); one slice of any θ if the rows do not name θ.
        width_rad: Width of each slice [rad], shape (T,).
        moments: Integrals of 1, x, y, x², x y, y² over each slice's polygon, times its width, shape (T, 6).
        corners_m: Corners of all slices' polygons [m], shape (C, 2).
        oriented: Whether the rows name θ at all.
    """

    theta_rad: FloatArray
    width_rad: FloatArray
    moments: FloatArray
    corners_m: FloatArray
    oriented: bool

    @property
    def volume(self) -> float:
        """Volume of the solid [m² rad]; 0 if no pose meets the rows."""
        return float(self.moments[:, 0].sum())

    @property
    def mean_z(self) -> FloatArray | None:
        """Mean of [x0, y0, cos θ, sin θ], or of [x0, y0] without θ; None if the set is empty.

        |mean (cos θ, sin θ)| is the mean resultant length: 1 for one orientation, 0 for all.
        """
        if self.volume <= 0.0:
            return None
        weight = self.moments[:, 0]
        sums = [*self.moments[:, 1:3].sum(axis=0)]
        if self.oriented:
            sums += [weight @ np.cos(self.theta_rad), weight @ np.sin(self.theta_rad)]
        return np.array(sums) / self.volume

    @property
    def covariance(self) -> FloatArray | None:
        """Covariance of (x0, y0, θ) if all poses weigh the same, shape (3, 3); None if the set is empty.

        θ is taken about its circular mean; its row and column are NaN if the rows do not name θ.
        """
        z = self.mean_z
        if z is None:
            return None
        _, x, y, xx, xy, yy = self.moments.sum(axis=0) / self.volume
        covariance = np.full((3, 3), np.nan)
        covariance[:2, :2] = [[xx - x * x, xy - x * y], [xy - x * y, yy - y * y]]
        if self.oriented:
            turn = angle_difference(self.theta_rad, np.arctan2(z[3], z[2]))
            weight, sum_x, sum_y = self.moments[:, :3].T / self.volume
            covariance[2, 2] = weight @ turn**2 - (weight @ turn) ** 2
            covariance[2, :2] = covariance[:2, 2] = [
                turn @ sum_x - x * (weight @ turn),
                turn @ sum_y - y * (weight @ turn),
            ]
        return covariance

    @property
    def theta_interval_rad(self) -> tuple[float, float] | None:
        """Smallest interval [low, high] of θ that holds all slices, low in [-π, π); None without θ or poses."""
        if not self.oriented or self.theta_rad.size == 0:
            return None
        order = np.argsort(self.theta_rad)
        low, high = (self.theta_rad - self.width_rad / 2)[order], (self.theta_rad + self.width_rad / 2)[order]
        gap = np.append(low[1:], low[0] + 2 * np.pi) - np.maximum.accumulate(high)
        last = int(gap.argmax())
        start = low[(last + 1) % low.size]
        return float(start), float(high[last] if high[last] > start else high[last] + 2 * np.pi)

    @property
    def region_m(self) -> FloatArray:
        """Convex hull of all centres [m], counter-clockwise, shape (V, 2); V = 0 if the set is empty."""
        return convex_hull(self.corners_m)


def pose_set(problem: PartitionProblem) -> PoseSet:
    """Find all poses with c² + s² = 1 that meet all rows of a problem.

    The circle is cut into ranges; a range that a certain bound proves empty is dropped, the others are halved,
    until there are enough. Each is then represented by the exact polygon at its middle.
    """
    A, b, bounds_m = problem.rows.A, problem.rows.b, problem.bounds_m
    if problem.unknowns == 4:
        ranges = _theta_ranges(A, b, bounds_m)
    else:
        ranges = _Ranges(np.zeros(1), 2.0 * np.pi, np.hstack([A, np.zeros((len(b), 2))]), b, bounds_m)
    vertices, counts = slices(ranges.A, ranges.b, ranges.bounds_m, ranges.theta_rad)
    width = np.full(ranges.theta_rad.size, ranges.width_rad)
    return _collect(vertices, counts, ranges.theta_rad, width, problem.unknowns == 4)


def unite(sets: Sequence[PoseSet]) -> PoseSet:
    """Union of pose sets that do not overlap."""
    return PoseSet(
        np.concatenate([one.theta_rad for one in sets]),
        np.concatenate([one.width_rad for one in sets]),
        np.vstack([one.moments for one in sets]),
        np.vstack([one.corners_m for one in sets]),
        all(one.oriented for one in sets),
    )


class _Ranges(NamedTuple):
    """Ranges of θ that are not proven empty, and what is left of the problem in them."""

    theta_rad: FloatArray  # middles, shape (T,)
    width_rad: float
    A: FloatArray
    b: FloatArray
    bounds_m: FloatArray


def _theta_ranges(A: FloatArray, b: FloatArray, bounds_m: FloatArray) -> _Ranges:
    """Cut the circle, and leave out the rows that no pose in the ranges and in a rectangle about them breaks."""
    half: float = np.pi / _FIRST_RANGES
    middle = np.linspace(half - np.pi, np.pi - half, _FIRST_RANGES)
    for _ in range(_MAX_HALVINGS):
        alive, box_m = ranges_alive(A, b, bounds_m, middle, half)
        middle = middle[alive]
        if middle.size == 0:
            break
        bounds_m = box_m
        open_rows = can_break(A, b, bounds_m, middle, half)
        A, b = A[open_rows], b[open_rows]
        if middle.size >= _SLICES:
            break
        half /= 2.0
        middle = np.concatenate([middle - half, middle + half])
    return _Ranges(middle, 2.0 * half, A, b, bounds_m)


def _collect(vertices: FloatArray, counts: IntArray, theta: FloatArray, width: FloatArray, oriented: bool) -> PoseSet:
    filled = counts > 0
    vertices, counts, theta, width = vertices[filled], counts[filled], theta[filled], width[filled]
    corners_m = vertices[np.arange(vertices.shape[1]) < counts[:, None]]
    return PoseSet(theta, width, moments(vertices, counts) * width[:, None], corners_m, oriented)
