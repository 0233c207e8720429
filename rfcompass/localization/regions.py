"""Regions for drawing: what the cell of Eq. 8 looks like in the plane, and which orientations it allows."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import SolverFailed
from rfcompass.geometry.polygons import intersect_half_planes
from rfcompass.localization import partition_kernels as kernels
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.pose_kernels import lower_chain
from rfcompass.localization.problem import PartitionProblem, build_partition
from rfcompass.localization.scaled_rows import scale_rows

_DIRECTIONS = 64
_TOLERANCE_M = 1e-9
_MAX_TURNS = 50


def region_polygon(problem: PartitionProblem) -> FloatArray:
    """Projection of the cell {A z <= b, c² + s² <= 1, bounds} on (x0, y0), from outside.

    The intersection of the half-planes that touch the projection in 64 directions. More rows never enlarge it.
    Where c and s are no unknowns the polygon is exact.

    Args:
        problem: Rows and bounds; feasible.

    Returns:
        Vertices [m], counter-clockwise, shape (V, 2).

    Raises:
        SolverFailed: If the linear program stops without a verdict.
    """
    if problem.unknowns == 2:
        return intersect_half_planes(problem.rows.A, problem.rows.b, problem.bounds_m)
    cell = _Cell(problem)
    side = np.arange(_DIRECTIONS) * (2.0 * np.pi / _DIRECTIONS)
    normals = np.column_stack([np.cos(side), np.sin(side)])
    touching = [cell.farthest(np.concatenate([normal, [0.0, 0.0]])) for normal in normals]
    reach = np.array([normal @ point[:2] for normal, point in zip(normals, touching, strict=True)])
    return intersect_half_planes(normals, reach, problem.bounds_m)


def tag_region(
    stops: Sequence[ComparedStop], target: int, *, epsilon: float = 0.0, bounds_m: FloatArray | None = None
) -> FloatArray:
    """Where one part tag lies by its own comparisons alone [Wang2013], Eq. 2-4: the white cells of Fig. 6.

    Args:
        stops: Stops, newest last.
        target: Index k of the tag.
        epsilon: Confidence threshold of the comparisons.
        bounds_m: Where the tag may lie [m], [[xmin, xmax], [ymin, ymax]]; 3 m about all anchors if None.

    Returns:
        Vertices in the newest base frame [m], counter-clockwise, shape (V, 2); V = 0 if they contradict each other.

    Raises:
        Infeasible: If the tag has no comparison of this margin.
    """
    own = [replace(stop, comparisons=stop.comparisons.take(stop.comparisons.target == target)) for stop in stops]
    return region_polygon(build_partition(own, epsilon=epsilon, bounds_m=bounds_m, as_object=True))


def theta_interval(problem: PartitionProblem, theta_rad: float) -> tuple[float, float]:
    """Orientations atan2(s, c) of all points of the cell of Eq. 8.

    Each end is found by turning a ray about (c, s) = 0: the point of the cell that lies farthest beyond the ray
    gives the next ray, until none lies beyond. Needs a cell that does not hold (c, s) = 0, see `far field`.

    Args:
        problem: Rows and bounds over four unknowns; feasible.
        theta_rad: Orientation of a point of the cell [rad].

    Returns:
        (low, high) [rad] with low <= θ <= high.

    Raises:
        SolverFailed: If the linear program stops without a verdict.
    """
    cell = _Cell(problem)
    return theta_rad - cell.turn(theta_rad, -1.0), theta_rad + cell.turn(theta_rad, 1.0)


class _Cell:
    """The cell as rows of a linear program, with a point strictly inside to start from."""

    def __init__(self, problem: PartitionProblem) -> None:
        self._scaled = scale_rows(problem)
        G, self._h = self._scaled.with_polygon()
        self._G = np.ascontiguousarray(G.T)
        self._inside, _, self._status = kernels.chebyshev(self._G, self._h, _TOLERANCE_M)

    def farthest(self, direction: FloatArray) -> FloatArray:
        """Return the point z of the cell with the largest direction · z, shape (4,)."""
        c = direction / self._scaled.scale
        length = float(np.linalg.norm(c))
        y, status = kernels.maximise(self._G, self._h, c / length, self._inside, _TOLERANCE_M)
        if kernels.STALLED in (status, self._status):
            raise SolverFailed(f"the linear program stalled on {self._h.size} rows", status="stalled")
        return self._scaled.to_metric(y)

    def turn(self, theta_rad: float, sign: float) -> float:
        """How far the cell reaches beyond θ, counter-clockwise for sign = 1 [rad]."""
        turned = 0.0
        for _ in range(_MAX_TURNS):
            c, s = np.cos(theta_rad + sign * turned), np.sin(theta_rad + sign * turned)
            point = self.farthest(np.array([0.0, 0.0, -sign * s, sign * c]))
            beyond = float(np.arctan2(sign * (c * point[3] - s * point[2]), c * point[2] + s * point[3]))
            if beyond <= 1e-7 or turned + beyond >= np.pi:
                break
            turned += beyond
        return turned


def convex_hull(points_m: FloatArray) -> FloatArray:
    """Corners of the convex hull [Andrew1979] [m], counter-clockwise, shape (V, 2).

    Args:
        points_m: Points [m], shape (C, 2).
    """
    points = np.unique(points_m, axis=0)
    if len(points) < 3:
        return points
    rising, falling = points, points[::-1]
    return np.vstack([rising[lower_chain(rising)[:-1]], falling[lower_chain(falling)[:-1]]])
