"""The comparisons that one pose can meet together: the largest sets of them, found and proven.

All poses that meet the same comparisons are one cell. Over [x0, y0] alone the cells are those of half-planes, and
`arrangement` walks along all their borders; with θ, `consistency_kernels` halves boxes of poses.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.localization.arrangement import deepest_cells
from rfcompass.localization.consistency_kernels import search
from rfcompass.localization.pose_set import PoseSet, pose_set
from rfcompass.localization.problem import PartitionProblem
from rfcompass.types.comparisons import HalfSpaces

MAX_CELLS = 64  # cells that tie for the best and are kept (ours)


@dataclass(frozen=True, slots=True)
class BestCells:
    """The sets of comparisons that no pose outnumbers.

    Attributes:
        met: Largest number of comparisons that was found to hold together.
        bound: No pose meets more than that; `bound == met` is a proof.
        sets: Which comparisons, for each cell that reaches `met`, shape (C, M).
        complete: Whether these are proven to be all such cells.
        boxes: Boxes that the search kept; 0 if it needed none.
    """

    met: int
    bound: int
    sets: BoolArray
    complete: bool
    boxes: int


def best_cells(problem: PartitionProblem, margin_m: float, leaf: FloatArray, max_boxes: int) -> BestCells:
    """Find the largest sets of rows that one pose meets.

    Args:
        problem: Rows over 2 or 4 unknowns, and bounds.
        margin_m: A row counts if the part tag lies at least this far on the right side of the bisector [m].
        leaf: Half sizes (x, y, θ) of a box of poses that is not halved any more [m, m, rad], shape (3,).
        max_boxes: Boxes to keep before giving up, at least 64.
    """
    G = signed_distances(problem, margin_m)
    if problem.unknowns == 2:
        cells = deepest_cells(G[:, :2], G[:, 4], problem.bounds_m, MAX_CELLS)
        return BestCells(cells.met, cells.met, cells.sets, cells.complete, 0)
    poses = np.zeros((MAX_CELLS, 3))
    found = search(G, fingerprints(len(G)), problem.bounds_m, leaf, max_boxes, poses)
    return BestCells(found.met, found.bound, rows_met(G, poses[: found.found]), found.undecided == 0, found.boxes)


def signed_distances(problem: PartitionProblem, margin_m: float) -> FloatArray:
    """Rows as signed distances of a part tag from the bisector.

    Args:
        problem: Rows over 2 or 4 unknowns.
        margin_m: How far on the right side a tag must lie [m].

    Returns:
        [n_x, n_y, g₂, g₃, β, |g|], shape (M, 6). A row of two anchors above each other has no distance: it is
        met everywhere or nowhere.
    """
    A, b = problem.rows.A, problem.rows.b
    length = np.linalg.norm(A[:, :2], axis=1)
    above = length == 0.0
    length[above] = 1.0
    G = np.zeros((len(b), 6))
    G[:, : A.shape[1]] = A / length[:, None]
    G[:, 4] = b / length - np.where(above, 0.0, margin_m)
    G[:, 5] = np.hypot(G[:, 2], G[:, 3])
    return G


def rows_met(G: FloatArray, poses: FloatArray) -> BoolArray:
    """Which rows each pose (x, y, θ) meets, shape (P, M)."""
    z = np.column_stack([poses[:, :2], np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    return np.asarray(z @ G[:, :4].T <= G[:, 4])


def fingerprints(rows: int) -> IntArray:
    """A number for each row, so that different sets of rows have different sums, shape (M,)."""
    return np.random.default_rng(0).integers(-(2**62), 2**62, rows)


def cell_of(problem: PartitionProblem, met: BoolArray) -> PoseSet:
    """Measure a cell: all poses that meet the rows which one pose meets.

    Args:
        problem: All rows.
        met: Which of them the pose meets, shape (M,).
    """
    rows = HalfSpaces(problem.rows.A[met], problem.rows.b[met], problem.rows.provenance[met])
    return pose_set(PartitionProblem(rows, problem.bounds_m))
