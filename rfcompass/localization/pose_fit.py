"""What a comparison method found, before it becomes a `PartEstimate` or the answer to a partition file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.geometry.pose2 import Pose2
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.problem import comparison_rows
from rfcompass.types.estimate import DiagnosticValue, PartEstimate
from rfcompass.types.observation import Observation
from rfcompass.types.record import Record, frozen_mapping

MET_WITHIN_M = 1e-3  # a comparison counts as met if the "nearer" anchor is farther by no more than this


@dataclass(frozen=True, slots=True)
class PoseFit(Record):
    """A pose, and how it stands to the comparisons.

    Attributes:
        z: [x0, y0, c, s], or [x0, y0] where the orientation cannot be observed [m, m, 1, 1].
        theta_rad: Orientation atan2(s, c) [rad]; None where it cannot be observed.
        satisfied_relaxed: Comparisons whose row z meets.
        satisfied: Comparisons that the pose (x0, y0, θ) meets to 1 mm in distance difference; without θ all part
            tags count as lying at the centre.
        total: Number of comparisons, those that ε left out included.
        region_m: Polygon that holds the centre [m], counter-clockwise, shape (V, 2).
        theta_interval_rad: Orientations in question (low, high) [rad]; None without θ.
        covariance: Covariance of (x0, y0, θ) if all poses in question weigh the same, shape (3, 3), or None.
        outliers: Comparisons that were left out or are not met, shape (R,).
        epsilon: Confidence threshold that was used.
        gap: How many comparisons more than `best` another pose could at most meet; None if that was not asked.
        diagnostics: What else the method found out about its own work.
    """

    z: FloatArray
    theta_rad: float | None
    satisfied_relaxed: int
    satisfied: int
    total: int
    region_m: FloatArray
    theta_interval_rad: tuple[float, float] | None
    covariance: FloatArray | None
    outliers: IntArray
    epsilon: float = 0.0
    gap: int | None = None
    diagnostics: Mapping[str, DiagnosticValue] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "z", read_only(self.z, "PoseFit.z", (None,)))
        object.__setattr__(self, "region_m", read_only(self.region_m, "PoseFit.region_m", (None, 2)))
        object.__setattr__(self, "outliers", read_only(self.outliers, "PoseFit.outliers", (None,), np.int64))
        object.__setattr__(self, "diagnostics", frozen_mapping(self.diagnostics))

    @property
    def orientation_norm(self) -> float | None:
        """|(c, s)|: 1 if the orientation is firmly held, towards 0 if it is not; None without θ."""
        return float(np.hypot(*self.z[2:])) if self.theta_rad is not None else None

    def to_estimate(self, observations: Sequence[Observation], method: str) -> PartEstimate:
        """Turn the fit into the estimate of the newest of the observations that it used."""
        newest = observations[-1]
        height_m = float((newest.part_tag_heights_m - newest.part.points_m[:, 2]).mean())
        own = {
            "epsilon": self.epsilon,
            "orientation_norm": self.orientation_norm,
            "satisfied_relaxed": self.satisfied_relaxed,
            "satisfied": self.satisfied,
            "total": self.total,
            "gap": self.gap,
        }
        return PartEstimate(
            newest.part.body, self.z[:2], self.theta_rad, method, len(observations), height_m, self.covariance,
            self.region_m, None, outliers=self.outliers, diagnostics={**own, **self.diagnostics},
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Verdict:
    """Which comparisons hold, over all stops in order.

    Attributes:
        relaxed: Number of rows that z meets.
        met: Number of comparisons that the pose of unit norm meets.
        broken: Indices of the comparisons that it does not meet, shape (R,).
        total: Number of comparisons.
    """

    relaxed: int
    met: int
    broken: IntArray
    total: int


def judge(stops: Sequence[ComparedStop], z: FloatArray, theta_rad: float | None) -> Verdict:
    """Count what [x0, y0, c, s] and what the pose (x0, y0, θ) meet.

    Args:
        stops: Stops, newest last.
        z: [x0, y0] or [x0, y0, c, s] in the newest base frame.
        theta_rad: Orientation [rad]; None to take all part tags as lying at the centre.
    """
    if theta_rad is None:
        stops = [stop.as_object() for stop in stops]
    rows = comparison_rows(stops, as_object=z.size == 2)
    length = np.maximum(np.linalg.norm(rows.A, axis=1), 1e-12)
    relaxed = (rows.A @ z - rows.b) / length <= 1e-9
    pose = Pose2(float(z[0]), float(z[1]), theta_rad or 0.0)
    met = np.concatenate([stop.satisfied(pose, MET_WITHIN_M) for stop in stops])
    return Verdict(int(relaxed.sum()), int(met.sum()), np.flatnonzero(~met), int(met.size))
