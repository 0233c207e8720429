"""The partition as a convex problem: build it here, solve it in `partition_solver` [Wang2013], Eq. 2-12.

The unknown is z = [x0, y0] or z' = [x0, y0, c, s] with c = cos θ, s = sin θ of the part in the newest base frame:

    A z' <= b,   c² + s² <= 1,   xmin <= x0 <= xmax,   ymin <= y0 <= ymax.

The last two rows are ours: the cells of a single stop can be open, and an open cell has no centre.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import Infeasible, InputError, ShapeError
from rfcompass.geometry.half_spaces import bisector_rows
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.transitive_reduction import implied_by_others
from rfcompass.types.comparisons import HalfSpaces
from rfcompass.types.record import Record

ORIENTATION_SCALE_M = 0.2  # ours: c and s count as this length when a ball is fitted; half the paper's 0.4 m leg
BOUNDS_MARGIN_M = 3.0  # ours: how far from the anchors the part may lie


@dataclass(frozen=True, slots=True)
class PartitionProblem(Record):
    """Rows A z <= b that a pose of the part must meet, inside a rectangle.

    Attributes:
        rows: Comparisons as half-spaces in the newest base frame, over 2 or 4 unknowns; `provenance` counts the
            comparisons of all stops in order.
        bounds_m: Where the centre may lie [m], [[xmin, xmax], [ymin, ymax]], shape (2, 2).
        epsilon: Confidence threshold that chose the rows.
    """

    rows: HalfSpaces
    bounds_m: FloatArray
    epsilon: float = 0.0

    def __post_init__(self) -> None:
        """Freeze the bounds and check their order."""
        object.__setattr__(self, "bounds_m", check_bounds(self.bounds_m))

    @property
    def unknowns(self) -> int:
        """2 for [x0, y0], 4 for [x0, y0, c, s]."""
        return int(self.rows.A.shape[1])

    @property
    def all_rows(self) -> tuple[FloatArray, FloatArray]:
        """A, shape (M + 4, n), and b, shape (M + 4,): comparisons, then the box xmax, xmin, ymax, ymin."""
        (xmin, xmax), (ymin, ymax) = self.bounds_m
        box = np.zeros((4, self.unknowns))
        box[:, :2] = [[1, 0], [-1, 0], [0, 1], [0, -1]]
        return np.vstack([self.rows.A, box]), np.concatenate([self.rows.b, [xmax, -xmin, ymax, -ymin]])


def check_bounds(bounds_m: FloatArray) -> FloatArray:
    """Freeze a rectangle [m], [[xmin, xmax], [ymin, ymax]].

    Raises:
        ShapeError: If a lower bound is not below its upper one.
    """
    bounds = read_only(bounds_m, "bounds_m", (2, 2))
    if (bounds[:, 0] >= bounds[:, 1]).any():
        raise ShapeError(f"bounds_m: {bounds.tolist()} m holds no area", name="bounds_m")
    return bounds


def bounds_about(points_m: FloatArray, margin_m: float = BOUNDS_MARGIN_M) -> FloatArray:
    """Bounding rectangle of points, grown on all sides.

    With the hand's tags and 0.25 m or 0.30 m this is the prior "the part lies about the hand".

    Args:
        points_m: Points in the newest base frame [m], shape (N, 2 or 3).
        margin_m: How far beyond the points the part may lie [m].

    Returns:
        Rectangle [m], [[xmin, xmax], [ymin, ymax]], shape (2, 2).
    """
    plane_m = np.asarray(points_m)[:, :2]
    return np.column_stack([plane_m.min(axis=0) - margin_m, plane_m.max(axis=0) + margin_m])


def stop_rows(stop: ComparedStop) -> HalfSpaces:
    """Rows of one stop over [x0, y0, c, s] [Wang2013], Eq. 5-7, in the newest base frame (Eq. 9-12)."""
    A, b = bisector_rows(*stop.compared_points_m)
    return HalfSpaces(A, b, np.arange(len(b))).in_frame(stop.T_newest_stop)


def object_rows(stop: ComparedStop) -> HalfSpaces:
    """Rows of one stop over [x0, y0], as if all part tags were at the centre [Wang2013], Eq. 2-3 and 9-12."""
    rows = stop_rows(stop.as_object())
    return HalfSpaces(rows.A[:, :2], rows.b, rows.provenance)


def comparison_rows(stops: Sequence[ComparedStop], *, as_object: bool = False) -> HalfSpaces:
    """Rows of all comparisons of all stops, in order, before any is left out.

    Args:
        stops: Stops, newest last.
        as_object: Treat all part tags as lying at the part's centre (Eq. 4) instead of Eq. 8.
    """
    parts = [object_rows(stop) if as_object else stop_rows(stop) for stop in stops]
    A, b = np.vstack([rows.A for rows in parts]), np.concatenate([rows.b for rows in parts])
    return HalfSpaces(A, b, np.arange(len(b)))


def build_partition(
    stops: Sequence[ComparedStop],
    *,
    epsilon: float = 0.0,
    bounds_m: FloatArray | None = None,
    transitive_reduction: bool = True,
    as_object: bool = False,
) -> PartitionProblem:
    """Collect the rows of Eq. 4 or Eq. 8 that ε keeps [Wang2013], section 4.2-4.3.

    Eq. 4 is taken for a part whose only tag sits at its centre, or on demand; Eq. 8 otherwise.

    Args:
        stops: Stops, newest last.
        epsilon: Keep comparisons of this margin or more; those without margin are always kept.
        bounds_m: Where the centre may lie [m], [[xmin, xmax], [ymin, ymax]]; 3 m about all anchors if None.
        transitive_reduction: Leave out rows that are sums of others. The set of poses stays the same; its
            analytic centre moves, since each row repels.
        as_object: Treat all part tags as lying at the part's centre: Eq. 4 for any K.

    Raises:
        InputError: If there is no stop.
        Infeasible: If no comparison is left to build rows from.
    """
    if not stops:
        raise InputError("no stop was given", stops=0)
    kept = np.concatenate([stop.comparisons.used_at(epsilon) for stop in stops])
    if not kept.any():
        raise Infeasible(f"no comparison has a margin of {epsilon:.2f} or more", epsilon=epsilon, rows=0)
    if transitive_reduction:
        kept &= ~np.concatenate([implied_by_others(stop.comparisons, epsilon) for stop in stops])
    centred = all(np.all(stop.part_points_m[:, :2] == 0.0) for stop in stops)
    rows = comparison_rows(stops, as_object=as_object or centred)
    kept &= ~((rows.A == 0.0).all(axis=1) & (rows.b >= 0.0))  # anchors above each other: always true
    if bounds_m is None:
        bounds_m = bounds_about(np.vstack([stop.anchors_newest_m for stop in stops]))
    chosen = HalfSpaces(rows.A[kept], rows.b[kept], rows.provenance[kept])
    return PartitionProblem(chosen, bounds_m, epsilon)
