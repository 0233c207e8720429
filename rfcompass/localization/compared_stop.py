"""A stop as the comparison methods see it: where the anchors were, and what was nearer to what."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray, read_only
from rfcompass.errors import DegenerateAnchors, InputError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.interfaces import ProximityMeter
from rfcompass.localization.comparing import compare_proximities
from rfcompass.localization.measuring import measure_proximities
from rfcompass.types.comparisons import Comparisons
from rfcompass.types.observation import Observation
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class ComparedStop(Record):
    """Comparisons made at one stop.

    Attributes:
        anchors_m: Anchors in the base frame of this stop [m], shape (N, 3).
        part_points_m: Part tags: x, y in the part frame, z in the base frame [m], shape (K, 3).
        comparisons: Which anchor each part tag is nearer to; indices into the two arrays above.
        T_newest_stop: Base frame of this stop in the base frame of the newest one.
    """

    anchors_m: FloatArray
    part_points_m: FloatArray
    comparisons: Comparisons
    T_newest_stop: Pose2 = field(default_factory=Pose2)

    def __post_init__(self) -> None:
        """Freeze the points; check the indices and that the anchors can tell places apart."""
        set_ = object.__setattr__
        set_(self, "anchors_m", read_only(self.anchors_m, "ComparedStop.anchors_m", (None, 3)))
        set_(self, "part_points_m", read_only(self.part_points_m, "ComparedStop.part_points_m", (None, 3)))
        N, K = len(self.anchors_m), len(self.part_points_m)
        if N < 2:
            raise DegenerateAnchors(f"{N} anchor(s): a comparison needs two", anchors=N)
        if np.ptp(self.anchors_m, axis=0).max() < 1e-9:
            raise DegenerateAnchors(f"all {N} anchors are in one place: {self.anchors_m[0].tolist()} m", anchors=N)
        for name, size in (("target", K), ("nearer", N), ("farther", N)):
            _check_indices(getattr(self.comparisons, name), name, size)

    @property
    def anchors_newest_m(self) -> FloatArray:
        """Anchors in the base frame of the newest stop [m], shape (N, 3)."""
        return self.T_newest_stop.apply(self.anchors_m)

    @property
    def compared_points_m(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Nearer anchor, farther anchor (this stop's base frame) and part tag of each comparison, (M, 3) each."""
        chosen = self.comparisons
        nearer_m, farther_m = self.anchors_m[chosen.nearer], self.anchors_m[chosen.farther]
        return nearer_m, farther_m, self.part_points_m[chosen.target]

    def as_object(self) -> "ComparedStop":
        """Return the same stop as if all part tags were at the part's centre, at their own heights."""
        at_centre_m = self.part_points_m * [0.0, 0.0, 1.0]
        return ComparedStop(self.anchors_m, at_centre_m, self.comparisons, self.T_newest_stop)

    def satisfied(self, T_newest_part: Pose2, tolerance_m: float) -> BoolArray:
        """Tell which comparisons hold for a pose of the part.

        Args:
            T_newest_part: Pose of the part in the newest base frame.
            tolerance_m: By how much the "nearer" anchor may be the farther one [m].

        Returns:
            Whether |p_k - a_i| <= |p_k - a_j| + tolerance, in 3-D, for each comparison, shape (M,).
        """
        nearer_m, farther_m, points_m = self.compared_points_m
        tags_m = (self.T_newest_stop.inverse() @ T_newest_part).apply(points_m)
        to_nearer_m = np.linalg.norm(tags_m - nearer_m, axis=1)
        return np.asarray(to_nearer_m <= np.linalg.norm(tags_m - farther_m, axis=1) + tolerance_m)


def _check_indices(indices: IntArray, name: str, size: int) -> None:
    if indices.size and (largest := int(indices.max())) >= size:
        row = int(indices.argmax())
        raise InputError(f"comparison {row}: {name} {largest} is not below {size}", row=row, index=largest, size=size)


def compared_stops(
    observations: Sequence[Observation], meter: ProximityMeter | None = None
) -> tuple[ComparedStop, ...]:
    """Compare at every stop, and place every stop in the newest base frame by odometry.

    Args:
        observations: Stops of one part, newest last.
        meter: Measures the proximities of stops that do not bring their own.

    Raises:
        InputError: If stops are about different parts, or a stop has no proximities and there is no meter.
        DegenerateAnchors: If a stop has fewer than two anchors, or all in one place.
    """
    newest = observations[-1]
    if len(bodies := sorted({stop.part.body for stop in observations})) > 1:
        raise InputError(f"observations of different parts: {', '.join(bodies)}", parts=bodies)
    stops = []
    for stop in observations:
        points_m = np.column_stack([stop.part.points_m[:, :2], stop.part_tag_heights_m])
        comparisons = compare_proximities(_proximities_of(stop, meter))
        T_newest_stop = newest.base_pose.inverse() @ stop.base_pose
        stops.append(ComparedStop(stop.anchors.points_m, points_m, comparisons, T_newest_stop))
    return tuple(stops)


def _proximities_of(stop: Observation, meter: ProximityMeter | None) -> FloatArray:
    """Proximity of the part's tags to the anchors, in the order of the observation, shape (K, N)."""
    matrix = measure_proximities(stop, meter)
    return _arranged(matrix, stop.part.epcs, stop.anchors.epcs)


def _arranged(matrix: ProximityMatrix, targets: Sequence[str], anchors: Sequence[str]) -> FloatArray:
    """Pick rows and columns by EPC; NaN for a tag that the matrix does not know."""
    m = np.full((len(targets), len(anchors)), np.nan)
    row_of = {epc: k for k, epc in enumerate(matrix.target_epcs)}
    column_of = {epc: i for i, epc in enumerate(matrix.anchor_epcs)}
    rows = [k for k, epc in enumerate(targets) if epc in row_of]
    columns = [i for i, epc in enumerate(anchors) if epc in column_of]
    source = np.ix_([row_of[targets[k]] for k in rows], [column_of[anchors[i]] for i in columns])
    m[np.ix_(rows, columns)] = matrix.m[source]
    return m
