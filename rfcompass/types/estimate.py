"""Where a localizer says the part is."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.record import Record, frozen_mapping

DiagnosticValue = float | int | str | bool | None


@dataclass(frozen=True, slots=True)
class PartEstimate(Record):
    """Pose of the part in the newest base frame.

    Attributes:
        part_id: Which part this is about.
        centre_m: Centre of the part [m], shape (2,).
        height_m: Height of the part's centre above the base frame's origin [m].
        theta_rad: Orientation of the part [rad]; None where it cannot be observed.
        covariance: Covariance of (x, y, θ) [m², m rad, rad²], shape (3, 3); θ's row and column NaN when
            `theta_rad` is None; None where a method has none.
        region_m: Polygon that holds the centre [m], counter-clockwise, shape (V, 2); V = 0 if there is none.
        probability: Probability that the region claims; None for a region of constraints.
        samples: Draws of (x, y, θ) [m, m, rad], shape (S, 3); S = 0 if the method draws none.
        outliers: Indices of the comparisons the method rejected, over all stops, shape (R,).
        method: Name of the method.
        stops: Number of stops that were used.
        diagnostics: What the method found out about its own work, by name.
    """

    part_id: str
    centre_m: FloatArray
    theta_rad: float | None
    method: str
    stops: int
    height_m: float = 0.0
    covariance: FloatArray | None = None
    region_m: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    probability: float | None = None
    samples: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    outliers: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    diagnostics: Mapping[str, DiagnosticValue] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Freeze the arrays and check that orientation and covariance agree."""
        set_ = object.__setattr__
        set_(self, "centre_m", read_only(self.centre_m, "PartEstimate.centre_m", (2,)))
        set_(self, "region_m", read_only(self.region_m, "PartEstimate.region_m", (None, 2)))
        set_(self, "samples", read_only(self.samples, "PartEstimate.samples", (None, 3)))
        set_(self, "outliers", read_only(self.outliers, "PartEstimate.outliers", (None,), np.int64))
        set_(self, "diagnostics", frozen_mapping(self.diagnostics))
        if self.theta_rad is not None and not np.isfinite(self.theta_rad):
            raise ShapeError("PartEstimate.theta_rad: not finite; use None for 'not observable'", name="theta_rad")
        if self.covariance is not None:
            observed = 2 if self.theta_rad is None else 3
            covariance = read_only(self.covariance, "PartEstimate.covariance", (3, 3), finite=False)
            if not np.isfinite(covariance[:observed, :observed]).all():
                raise ShapeError("PartEstimate.covariance: not finite where observed", name="covariance")
            set_(self, "covariance", covariance)

    @property
    def bearing_rad(self) -> float:
        """φ = atan2(y0, x0) [rad]: where to drive [Wang2013], Eq. 11 (arctan there loses the quadrant)."""
        return float(np.arctan2(self.centre_m[1], self.centre_m[0]))

    @property
    def distance_m(self) -> float:
        """D = √(x0² + y0²) [m]: how far the part is from the base frame's origin."""
        return float(np.hypot(*self.centre_m))

    def in_frame(self, T_new_base: Pose2) -> "PartEstimate":
        """Express the estimate in another frame of the floor plane, for example `odom`."""
        turn = np.eye(3)
        turn[:2, :2] = T_new_base.rotation
        samples = self.samples.copy()
        samples[:, :2] = T_new_base.apply(samples[:, :2])
        samples[:, 2] += T_new_base.theta_rad
        theta_rad = None if self.theta_rad is None else (T_new_base @ Pose2(0, 0, self.theta_rad)).theta_rad
        covariance = None if self.covariance is None else _turn_covariance(turn, self.covariance)
        return PartEstimate(
            self.part_id, T_new_base.apply(self.centre_m), theta_rad, self.method, self.stops, self.height_m,
            covariance, T_new_base.apply(self.region_m), self.probability, samples, self.outliers, self.diagnostics,
        )  # fmt: skip


def _turn_covariance(turn: FloatArray, covariance: FloatArray) -> FloatArray:
    if np.isfinite(covariance).all():
        return turn @ covariance @ turn.T
    turned = np.full((3, 3), np.nan)
    turned[:2, :2] = turn[:2, :2] @ covariance[:2, :2] @ turn[:2, :2].T
    return turned
