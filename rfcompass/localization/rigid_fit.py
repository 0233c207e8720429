"""The pose of a rigid part from a place for each of its tags, and how well the places fit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.geometry.pose2 import Pose2
from rfcompass.geometry.registration import fit_pose2
from rfcompass.types.estimate import DiagnosticValue, PartEstimate
from rfcompass.types.observation import Observation
from rfcompass.types.record import Record

# All ours.
LEAST_SD_M = 0.01  # no place is known better than that: reflections shift every tag
SHORTEST_LEVER_M = 0.01  # tags, or places, nearer to each other than this tell no orientation
_REFITS = 5
_MEDIAN_STEPS = 30
_CLOSE_M = 1e-4
_CORNERS = 48


@dataclass(frozen=True, slots=True)
class RigidFit(Record):
    """A part laid through the places of its tags.

    Attributes:
        centre_m: Centre of the part [m], shape (2,).
        theta_rad: Its orientation [rad]; None where one tag, or tags that all seem to be in one place, cannot tell.
        sd_m: Standard deviation of a place along one axis [m].
        levers_m: Places of the tags in the part frame [m], shape (K, 2).
    """

    centre_m: FloatArray
    theta_rad: float | None
    sd_m: float
    levers_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "centre_m", read_only(self.centre_m, "RigidFit.centre_m", (2,)))
        object.__setattr__(self, "levers_m", read_only(self.levers_m, "RigidFit.levers_m", (None, 2)))

    @property
    def covariance(self) -> FloatArray:
        """Covariance of (x, y, θ) for places that err independently; NaN for θ if it is None, shape (3, 3).

        With σ the standard deviation of a place, l_k the levers from the tags' mean l, and K tags,
        Var(θ) = σ² / Σ |l_k - l|² and Cov(p) = σ² / K I + Var(θ) n nᵀ, n = R(θ) (l_y, -l_x) being how the centre
        moves when the part turns about the tags' mean. Without θ the centre lies anywhere on a circle about it.
        """
        K, mean_m = len(self.levers_m), self.levers_m.mean(axis=0)
        covariance = np.diag([self.sd_m**2 / K, self.sd_m**2 / K, np.nan])
        if self.theta_rad is None:
            covariance[:2, :2] += np.eye(2) * (mean_m @ mean_m) / 2.0
            covariance[2] = covariance[:, 2] = np.nan
            return covariance
        turn = self.sd_m**2 / float(((self.levers_m - mean_m) ** 2).sum())
        n = Pose2(0.0, 0.0, self.theta_rad).apply(np.array([mean_m[1], -mean_m[0]]))
        covariance[:2, :2] += turn * np.outer(n, n)
        covariance[:2, 2] = covariance[2, :2] = turn * n
        covariance[2, 2] = turn
        return covariance

    def to_estimate(
        self, observations: Sequence[Observation], method: str, diagnostics: dict[str, DiagnosticValue]
    ) -> PartEstimate:
        """Turn the fit into an estimate; its region is the 90 % ellipse of the covariance, and claims nothing."""
        newest = observations[-1]
        height_m = float((newest.part_tag_heights_m - newest.part.points_m[:, 2]).mean())
        region_m = normal_ellipse(self.centre_m, self.covariance[:2, :2], 0.9)
        return PartEstimate(
            newest.part.body, self.centre_m, self.theta_rad, method, len(observations), height_m, self.covariance,
            region_m, diagnostics={"place_sd_m": self.sd_m, "tags": len(self.levers_m), **diagnostics},
        )  # fmt: skip


def fit_rigid_part(points_m: FloatArray, places_m: FloatArray, sd_m: float = LEAST_SD_M) -> RigidFit:
    """Lay a part through the places of its tags: least squares, reweighted with w = 5 / (4 + u²) (Student-4).

    Args:
        points_m: Tags in the part frame [m], shape (K, 2).
        places_m: Where they seem to be [m], shape (K, 2).
        sd_m: How well a place is known at best, standard deviation along one axis [m].
    """
    if min(_extent_m(points_m), _extent_m(places_m)) < SHORTEST_LEVER_M:
        return RigidFit(places_m.mean(axis=0), None, sd_m, points_m)
    weight = np.ones(len(points_m))
    for _ in range(_REFITS):
        pose = fit_pose2(points_m, places_m, weight)
        miss2 = ((pose.apply(points_m) - places_m) ** 2).sum(axis=1)
        scale2 = max(sd_m**2, float(np.median(miss2)) / 1.39)  # the median of χ² with two degrees of freedom
        weight = 5.0 / (4.0 + miss2 / scale2)
    return RigidFit(pose.translation_m, pose.theta_rad, float(np.sqrt(scale2)), points_m)


def spatial_median(points_m: FloatArray) -> FloatArray:
    """Point with the smallest sum of distances to all others [Weiszfeld1937]; turns with the frame, shape (2,).

    Args:
        points_m: Points [m], shape (P, 2); with two it is their middle.
    """
    middle_m: FloatArray = points_m.mean(axis=0)
    for _ in range(_MEDIAN_STEPS):
        weight = 1.0 / np.maximum(np.hypot(*(points_m - middle_m).T), _CLOSE_M)
        middle_m = weight @ points_m / weight.sum()
    return middle_m


def normal_ellipse(mean_m: FloatArray, covariance_m2: FloatArray, probability: float) -> FloatArray:
    """Polygon about the ellipse that holds a share of a normal density, counter-clockwise, shape (V, 2).

    Args:
        mean_m: Mean [m], shape (2,).
        covariance_m2: Covariance [m²], shape (2, 2).
        probability: Share, between 0 and 1.
    """
    radius = np.sqrt(-2.0 * np.log(1.0 - probability)) / np.cos(np.pi / _CORNERS)
    turn = np.arange(_CORNERS) * (2.0 * np.pi / _CORNERS)
    circle = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.asarray(mean_m + circle @ np.linalg.cholesky(covariance_m2).T)


def _extent_m(points_m: FloatArray) -> float:
    return float(np.ptp(points_m, axis=0).max())
