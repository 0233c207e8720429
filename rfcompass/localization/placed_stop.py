"""Stops as the posterior sees them: anchors in one frame, proximities by part tag, and how far odometry can be off."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import DegenerateAnchors, InputError
from rfcompass.interfaces import ProximityMeter
from rfcompass.localization.measuring import measure_proximities
from rfcompass.types.comparisons import Comparisons
from rfcompass.types.observation import Observation
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.record import Record

SAME_PLACE_M = 0.005  # ours: anchors of two stops nearer than this are one anchor that did not move


@dataclass(frozen=True, slots=True)
class OdometrySpread(Record):
    """How far a stop can be displaced, seen from the newest one: variance v + w |p - c|² along any direction at p.

    Attributes:
        shift_m2: v, variance of the displacement at c [m²].
        turn_rad2: w, variance of the turn [rad²].
        pivot_m: c, the point whose displacement is not correlated with the turn, newest base frame [m], shape (2,).
    """

    shift_m2: float = 0.0
    turn_rad2: float = 0.0
    pivot_m: FloatArray = field(default_factory=lambda: np.zeros(2))

    def __post_init__(self) -> None:
        """Freeze the pivot."""
        object.__setattr__(self, "pivot_m", read_only(self.pivot_m, "OdometrySpread.pivot_m", (2,)))

    @property
    def row(self) -> FloatArray:
        """[v, w, c_x, c_y], shape (4,)."""
        return np.array([self.shift_m2, self.turn_rad2, *self.pivot_m])


@dataclass(frozen=True, slots=True)
class PlacedStop(Record):
    """One stop in the newest base frame.

    Attributes:
        anchors_m: Anchors in the newest base frame [m], shape (N, 3).
        part_points_m: Part tags: x, y in the part frame, z in the base frame [m], shape (K, 3).
        m: Proximity of part tag k to anchor i, NaN where missing, shape (K, N).
        anchor_m: Proximity of the anchors to each other, NaN where missing, shape (N, N).
        kind: Meter that was used.
        odometry: How far the stop can be displaced.
    """

    anchors_m: FloatArray
    part_points_m: FloatArray
    m: FloatArray
    anchor_m: FloatArray
    kind: str
    odometry: OdometrySpread = field(default_factory=OdometrySpread)

    def __post_init__(self) -> None:
        """Freeze the arrays; check that the anchors can tell places apart."""
        set_ = object.__setattr__
        set_(self, "anchors_m", read_only(self.anchors_m, "PlacedStop.anchors_m", (None, 3)))
        set_(self, "part_points_m", read_only(self.part_points_m, "PlacedStop.part_points_m", (None, 3)))
        N, K = len(self.anchors_m), len(self.part_points_m)
        set_(self, "m", read_only(self.m, "PlacedStop.m", (K, N), finite=False))
        set_(self, "anchor_m", read_only(self.anchor_m, "PlacedStop.anchor_m", (N, N), finite=False))
        if N < 2:
            raise DegenerateAnchors(f"{N} anchor(s): a comparison needs two", anchors=N)
        if np.ptp(self.anchors_m, axis=0).max() < 1e-9:
            raise DegenerateAnchors(f"all {N} anchors are in one place: {self.anchors_m[0].tolist()} m", anchors=N)

    @property
    def distances_m(self) -> FloatArray:
        """True distances of the anchors [m], shape (N, N)."""
        return np.asarray(np.linalg.norm(self.anchors_m[:, None] - self.anchors_m[None], axis=2))


class PlacedComparisons(NamedTuple):
    """Comparisons of one stop in the newest base frame.

    Attributes:
        anchors_m: Anchors in the newest base frame [m], shape (N, 3).
        part_points_m: Part tags: x, y in the part frame, z in the base frame [m], shape (K, 3).
        comparisons: Which anchor each part tag is nearer to; indices into the two arrays above.
        odometry: How far the stop can be displaced.
    """

    anchors_m: FloatArray
    part_points_m: FloatArray
    comparisons: Comparisons
    odometry: OdometrySpread


def place_stops(observations: Sequence[Observation], meter: ProximityMeter | None = None) -> tuple[PlacedStop, ...]:
    """Measure every stop where it brings no proximities, and place it in the newest base frame.

    Args:
        observations: Stops of one part, newest last.
        meter: Measures the proximities of stops that do not bring their own; `auto` if None.

    Raises:
        InputError: If there is no stop, or stops are about different parts.
        NoAnswer: If the meter has no answer; the subclass says why.
        DegenerateAnchors: If a stop has fewer than two anchors, or all in one place.
    """
    if not observations:
        raise InputError("no observation was given", observations=0)
    if len(bodies := sorted({stop.part.body for stop in observations})) > 1:
        raise InputError(f"observations of different parts: {', '.join(bodies)}", parts=bodies)
    newest = observations[-1]
    return tuple(_place(stop, newest, measure_proximities(stop, meter)) for stop in observations)


def _place(stop: Observation, newest: Observation, matrix: ProximityMatrix) -> PlacedStop:
    rows, columns = _places(stop.part.epcs, matrix.target_epcs), _places(stop.anchors.epcs, matrix.anchor_epcs)
    return PlacedStop(
        (newest.base_pose.inverse() @ stop.base_pose).apply(stop.anchors.points_m),
        np.column_stack([stop.part.points_m[:, :2], stop.part_tag_heights_m]),
        _picked(matrix.m, rows, columns),
        _picked(matrix.anchor_m, columns, columns),
        matrix.kind,
        odometry_spread(stop, newest),
    )


def _places(wanted: Sequence[str], given: Sequence[str]) -> IntArray:
    """Index of each wanted EPC among the given ones; -1 for one that is not there."""
    place = {epc: n for n, epc in enumerate(given)}
    return np.array([place.get(epc, -1) for epc in wanted], dtype=np.int64)


def _picked(m: FloatArray, rows: IntArray, columns: IntArray) -> FloatArray:
    """Return the given rows and columns, NaN where an index is -1."""
    if not m.size:
        return np.full((rows.size, columns.size), np.nan)
    found = np.array(m[rows[:, None], columns])
    found[rows < 0] = np.nan
    found[:, columns < 0] = np.nan
    return found


def odometry_spread(stop: Observation, newest: Observation) -> OdometrySpread:
    """How far the anchors of a stop can be off in the newest base frame, from the covariances of both base poses.

    Odometry adds up: P_new = J P_stop Jᵀ + Q, where J carries an error of heading along the way. What is left, Q,
    belongs to the way from the stop to the newest one. A point p is then displaced by δ + ω × p, and

        c = the point where E[ω (δ + ω × c)] = 0,    v = largest eigenvalue of Cov(δ + ω × c),    w = Var(ω).
    """
    way = newest.base_pose.translation_m - stop.base_pose.translation_m
    J = np.array([[1.0, 0.0, -way[1]], [0.0, 1.0, way[0]], [0.0, 0.0, 1.0]])
    turn = np.eye(3)
    turn[:2, :2] = newest.base_pose.rotation.T
    Q = turn @ (newest.base_covariance - J @ stop.base_covariance @ J.T) @ turn.T
    w = float(Q[2, 2])
    if w <= 1e-15:
        return OdometrySpread(max(float(np.linalg.eigvalsh(Q[:2, :2])[-1]), 0.0))
    pivot = np.array([-Q[1, 2], Q[0, 2]]) / w
    at_pivot = Q[:2, :2] - np.outer(Q[:2, 2], Q[:2, 2]) / w
    return OdometrySpread(max(float(np.linalg.eigvalsh(at_pivot)[-1]), 0.0), w, pivot)


def place_labels(points_m: FloatArray) -> IntArray:
    """Give points in the same place the same number, that of the first of them, shape (P,).

    Args:
        points_m: Points [m], shape (P, 3).
    """
    apart = np.abs(points_m[:, None] - points_m[None]).max(axis=2) > SAME_PLACE_M
    return np.asarray((~apart).argmax(axis=1), dtype=np.int64)


def same_tags(points_m: FloatArray, others_m: FloatArray) -> IntArray:
    """Index of the tag in the same place on the part, for each tag; -1 where there is none, shape (K,).

    Args:
        points_m: Tags: x, y in the part frame, z in the base frame [m], shape (K, 3).
        others_m: Tags of another stop, in any order [m], shape (L, 3).
    """
    apart = np.abs(points_m[:, None, :2] - others_m[None, :, :2]).max(axis=2)
    return np.where(apart.min(axis=1) <= SAME_PLACE_M, apart.argmin(axis=1), -1)
