"""The pose that agrees with the most comparisons: RF-Compass's stated aim of outlier rejection, taken literally."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError, SolverFailed
from rfcompass.interfaces import ProximityMeter
from rfcompass.localization.best_cells import best_cells, cell_of
from rfcompass.localization.compared_stop import ComparedStop, compared_stops
from rfcompass.localization.pose_fit import PoseFit, judge
from rfcompass.localization.pose_set import PoseSet, unite
from rfcompass.localization.problem import build_partition
from rfcompass.localization.window import MAX_MOTIONS, MAX_TRAVEL_M, recent_stops
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.observation import Observation

_FEWEST_BOXES = 64  # ours; the search starts with 4
_FIRM = 0.5  # ours: mean resultant length below which θ is reported as not observable


@dataclass(frozen=True, slots=True, kw_only=True)
class ConsistencyLocalizer:
    """Centroid of the poses that agree with the most comparisons [Wang2013], section 4.3.A and 4.4.

    The paper rejects outliers "by seeking a solution that agrees with most of the constraints", and flips ten
    per cent of them to test it. ε cannot do that: flipped comparisons have no small margin. Here the pose that
    meets the most is searched for until nothing can meet more: over all cells of the half-planes if the part has
    one tag, at its centre; else by branch and bound over (x0, y0, θ). All poses that meet the same comparisons are
    one cell; cells that tie for the best are kept together as the region, and the estimate is their centroid, or
    that of the largest cell where the common one lies between cells and meets fewer comparisons than they do.

    What is proven: no pose meets more than `gap` comparisons beyond `best`, both counted with the margin below. A
    `gap` of 0 is a certificate. It is above 0 where `max_boxes` ended the search, or where a cell might be smaller
    than a leaf. `complete` tells whether the cells are all that tie for the best.

    Attributes:
        margin_m: A comparison counts if the tag lies at least this far on the right side of the bisector [m].
            Above 0, because bisectors of symmetric anchors coincide: on one line a comparison and its opposite
            would both hold.
        leaf_m: Side of the smallest box [m].
        leaf_rad: Its extent in θ [rad].
        max_boxes: Boxes to keep; if that does not suffice, `gap` says what is left open. A budget in boxes gives
            the same answer on every machine; 1000 take about 5 ms.
        bounds_m: Where the centre may lie, newest base frame [m], [[xmin, xmax], [ymin, ymax]]; 3 m about all
            anchors if None.
        max_motions: Length of the window in stops.
        max_travel_m: Length of the window along the base's path [m].
        meter: Measures proximities where an observation does not bring its own.
    """

    margin_m: float = 1e-3
    leaf_m: float = 2.5e-6
    leaf_rad: float = 1.25e-5
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
            InputError: If `max_boxes` is below 64, or the margin or a leaf's size not above 0.
            Infeasible: If there is no comparison.
            SolverFailed: If the best cells are too thin to measure.
        """
        self._check()
        problem = build_partition(stops, bounds_m=self.bounds_m, transitive_reduction=False)
        leaf = np.array([self.leaf_m / 2.0, self.leaf_m / 2.0, self.leaf_rad / 2.0])
        best = best_cells(problem, self.margin_m, leaf, self.max_boxes)
        cells = [cell_of(problem, met) for met in best.sets]
        union = unite(cells)
        z, theta_rad = _centroid(union)
        verdict = judge(stops, z, theta_rad)
        if verdict.met < best.met:  # between cells that lie apart
            z, theta_rad = _centroid(max(cells, key=lambda cell: cell.volume))
            verdict = judge(stops, z, theta_rad)
        return PoseFit(
            z, theta_rad, verdict.relaxed, verdict.met, verdict.total, union.region_m,
            None if theta_rad is None else union.theta_interval_rad, _covariance(union, theta_rad), verdict.broken,
            gap=best.bound - best.met,
            diagnostics={"best": best.met, "cells": len(cells), "complete": best.complete, "boxes": best.boxes},
        )  # fmt: skip

    def _check(self) -> None:
        if self.max_boxes < _FEWEST_BOXES:
            raise InputError(f"max_boxes = {self.max_boxes} is below {_FEWEST_BOXES}", max_boxes=self.max_boxes)
        for name in ("margin_m", "leaf_m", "leaf_rad"):
            if not (value := getattr(self, name)) > 0.0:
                raise InputError(f"{name} = {value} is not above 0", name=name, value=value)


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
