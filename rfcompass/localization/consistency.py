"""The pose that agrees with the most comparisons: RF-Compass's stated aim of outlier rejection, taken literally."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.errors import InputError, SolverFailed
from rfcompass.interfaces import ProximityMeter
from rfcompass.localization.compared_stop import ComparedStop, compared_stops
from rfcompass.localization.consistency_kernels import search
from rfcompass.localization.pose_fit import PoseFit, judge
from rfcompass.localization.pose_set import PoseSet, pose_set, unite
from rfcompass.localization.problem import PartitionProblem, build_partition
from rfcompass.localization.window import MAX_MOTIONS, MAX_TRAVEL_M, recent_stops
from rfcompass.types.comparisons import HalfSpaces
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.observation import Observation

_MAX_CELLS = 64  # cells that tie for the best and are measured
_FEWEST_BOXES = 64  # the search starts with 16
_FIRM = 0.5  # ours: mean resultant length below which θ is reported as not observable


@dataclass(frozen=True, slots=True, kw_only=True)
class ConsistencyLocalizer:
    """Centroid of the poses that agree with the most comparisons [Wang2013], section 4.3.A and 4.4.

    The paper rejects outliers "by seeking a solution that agrees with most of the constraints", and flips ten
    per cent of them to test it. ε cannot do that: flipped comparisons have no small margin. Here a branch and
    bound over (x0, y0, θ) looks for the pose that meets the most. All poses that meet the same comparisons are
    one cell; cells that tie for the best are kept together as the region, and the estimate is their centroid, or
    that of the largest cell where the common one lies between cells and meets fewer comparisons than they do.

    What is proven: no pose meets more than `gap` comparisons beyond `best`, both counted with the margin below.
    A cell smaller than a leaf can be missed; then `gap` is above 0.

    Attributes:
        margin_m: A comparison counts if the tag lies at least this far on the right side of the bisector [m].
            Above 0, because bisectors of symmetric anchors coincide: on one line a comparison and its opposite
            would both hold.
        leaf_m: Side of the smallest box [m].
        leaf_rad: Its extent in θ [rad].
        max_boxes: Boxes to keep; if that does not suffice, `gap` says what is left open.
        bounds_m: Where the centre may lie, newest base frame [[xmin, xmax], [ymin, ymax]] [m]; 3 m about all
            anchors if None.
        max_motions: Length of the window in stops.
        max_travel_m: Length of the window along the base's path [m].
        meter: Measures proximities where an observation does not bring its own.
    """

    margin_m: float = 1e-3
    leaf_m: float = 2.5e-3
    leaf_rad: float = np.radians(0.75)
    max_boxes: int = 400_000
    bounds_m: FloatArray | None = None
    max_motions: int = MAX_MOTIONS
    max_travel_m: float = MAX_TRAVEL_M
    meter: ProximityMeter | None = None

    def estimate(self, observations: Sequence[Observation]) -> PartEstimate:
        """Estimate the pose of the part in the newest base frame.

        Args:
            observations: Stops, newest last.

        Raises:
            InputError: If a stop has neither proximities nor a meter, or the anchors define no comparison.
            Infeasible: If no pair of anchors could be compared.
            SolverFailed: If the best cells are too thin to measure.
        """
        recent = recent_stops(observations, self.max_motions, self.max_travel_m)
        return self.fit(compared_stops(recent, self.meter)).to_estimate(recent, "consistency")

    def fit(self, stops: Sequence[ComparedStop]) -> PoseFit:
        """Find the pose from comparisons; the stops are taken as they are, without a window.

        Raises:
            InputError: If `max_boxes` is below 64.
            Infeasible: If there is no comparison.
            SolverFailed: If the best cells are too thin to measure.
        """
        if self.max_boxes < _FEWEST_BOXES:
            raise InputError(f"max_boxes = {self.max_boxes} is below {_FEWEST_BOXES}", max_boxes=self.max_boxes)
        problem = build_partition(stops, bounds_m=self.bounds_m, transitive_reduction=False)
        G = signed_distances(problem, self.margin_m)
        leaf = np.array([self.leaf_m / 2.0, self.leaf_m / 2.0, self.leaf_rad / 2.0])
        poses = np.zeros((_MAX_CELLS, 3))
        best, bound, found, boxes = search(G, _fingerprints(len(G)), problem.bounds_m, leaf, self.max_boxes, poses)
        cells = [cell_of(problem, met) for met in rows_met(G, poses[:found])]
        union = unite(cells)
        z, theta_rad = _centroid(union)
        verdict = judge(stops, z, theta_rad)
        if verdict.met < best:  # between cells that lie apart
            z, theta_rad = _centroid(max(cells, key=lambda cell: cell.volume))
            verdict = judge(stops, z, theta_rad)
        return PoseFit(
            z, theta_rad, verdict.relaxed, verdict.met, verdict.total, union.region_m,
            None if theta_rad is None else union.theta_interval_rad, _covariance(union, theta_rad), verdict.broken,
            gap=int(bound - best),
            diagnostics={"best": int(best), "cells": len(cells), "boxes": int(boxes)},
        )  # fmt: skip


def signed_distances(problem: PartitionProblem, margin_m: float) -> FloatArray:
    """Rows as signed distances of a part tag from the bisector, for the branch and bound.

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


def cell_of(problem: PartitionProblem, met: BoolArray) -> PoseSet:
    """Measure a cell: all poses that meet the rows which one pose meets.

    Args:
        problem: All rows.
        met: Which of them the pose meets, shape (M,).
    """
    rows = HalfSpaces(problem.rows.A[met], problem.rows.b[met], problem.rows.provenance[met])
    return pose_set(PartitionProblem(rows, problem.bounds_m))


def _fingerprints(rows: int) -> IntArray:
    """A number for each row, so that different sets of rows have different sums, shape (M,)."""
    return np.random.default_rng(0).integers(-(2**62), 2**62, rows)


def _centroid(union: PoseSet) -> tuple[FloatArray, float | None]:
    """Mean [x0, y0, c, s] and θ, or [x0, y0] and None where the cells do not agree on an orientation."""
    z = union.mean_z
    if z is None:
        raise SolverFailed("the best cells are too thin to measure", status="thin")
    if z.size == 2 or np.hypot(*z[2:]) < _FIRM:
        return z[:2], None
    return z, float(np.arctan2(z[3], z[2]))


def _covariance(union: PoseSet, theta_rad: float | None) -> FloatArray | None:
    """Covariance of (x0, y0, θ), with NaN for θ where it is not reported."""
    covariance = union.covariance
    if covariance is not None and theta_rad is None:
        covariance[2] = covariance[:, 2] = np.nan
    return covariance
