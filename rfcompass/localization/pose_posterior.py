"""The posterior over the part's pose as a set of equal cells, and what is asked of it."""

from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.geometry.angles import angle_difference, wrap_to_pi
from rfcompass.geometry.pose2 import Pose2
from rfcompass.localization.credible_region import component_weights, credible_polygon, spread_on_grid
from rfcompass.localization.pose_search import centred
from rfcompass.types.record import Record

FIRM = 0.5  # ours: mean resultant length below which θ is reported as not observable
_BULK = 0.99  # modes are sets that hang together within so much of the probability


@dataclass(frozen=True, slots=True)
class PosePosterior(Record):
    """Probability of each cell of poses. Cells tile (p, θ), p being the place of one tag of the part, the hub.

    Attributes:
        cells: Place of the hub and θ in the middle of each cell, newest base frame [m, m, rad], shape (C, 3).
        weight: Probability of each cell, shape (C,).
        half: Half a cell's side and half its range of θ [m, rad], shape (2,).
        hub_m: The hub in the part frame [m], shape (2,).
        lift_m: How much higher than stated the part lies in each cell [m], shape (C,).
        log_evidence: Log of the mean likelihood over all poses that were allowed, without constants.
        rigid: Place of the hub and θ that best fit the likeliest place of each tag, as a cross-check, shape (3,).
        poses: Pose (x, y, θ) of the part in the middle of each cell, from the others [m, m, rad], shape (C, 3).
    """

    cells: FloatArray
    weight: FloatArray
    half: FloatArray
    hub_m: FloatArray
    lift_m: FloatArray = field(default_factory=lambda: np.zeros(0))
    log_evidence: float = 0.0
    rigid: FloatArray = field(default_factory=lambda: np.zeros(3))
    poses: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        C, set_ = len(self.weight), object.__setattr__
        set_(self, "cells", read_only(self.cells, "PosePosterior.cells", (C, 3)))
        set_(self, "weight", read_only(self.weight, "PosePosterior.weight", (C,)))
        set_(self, "half", read_only(self.half, "PosePosterior.half", (2,)))
        set_(self, "hub_m", read_only(self.hub_m, "PosePosterior.hub_m", (2,)))
        lift_m = self.lift_m if len(self.lift_m) else np.zeros(C)
        set_(self, "lift_m", read_only(lift_m, "PosePosterior.lift_m", (C,)))
        set_(self, "rigid", read_only(self.rigid, "PosePosterior.rigid", (3,)))
        set_(self, "poses", read_only(centred(self.cells, self.hub_m), "PosePosterior.poses", (C, 3)))

    @property
    def theta_mean(self) -> complex:
        """Mean of exp(jθ): its angle is the circular mean, its length 1 for one orientation and 0 for all."""
        theta = self.cells[:, 2]
        mean = complex(self.weight @ np.cos(theta), self.weight @ np.sin(theta))
        return mean * float(np.sinc(self.half[1] / np.pi))

    @property
    def theta_rad(self) -> float | None:
        """Circular mean of θ [rad]; None if its resultant is shorter than a half."""
        mean = self.theta_mean
        return float(np.angle(mean)) if abs(mean) >= FIRM else None

    @property
    def mean_m(self) -> FloatArray:
        """Mean centre of the part [m], shape (2,)."""
        return np.asarray(self.weight @ self.poses[:, :2])

    @property
    def mode(self) -> FloatArray:
        """Middle of the likeliest cell, (x, y, θ) [m, m, rad], shape (3,)."""
        return self.poses[self.weight.argmax()]

    @property
    def covariance(self) -> FloatArray:
        """Covariance of (x, y, θ), θ about its circular mean; NaN for θ where it is not observable, shape (3, 3)."""
        turned = angle_difference(self.poses[:, 2], np.angle(self.theta_mean))
        deviation = np.column_stack([self.poses[:, :2] - self.mean_m, turned])
        within = np.diag(self._cell_variance)
        covariance = (deviation * self.weight[:, None]).T @ deviation + within
        if self.theta_rad is None:
            covariance[2] = covariance[:, 2] = np.nan
        return covariance

    @property
    def mean_lift_m(self) -> float:
        """How much higher than stated the part lies, on average [m]."""
        return float(self.weight @ self.lift_m)

    @property
    def lift_sd_m(self) -> float:
        """Standard deviation of that [m]; 0 where the height is taken as known."""
        return float(np.sqrt(self.weight @ (self.lift_m - self.mean_lift_m) ** 2))

    @property
    def rigid_distance_sd(self) -> float:
        """How far the rigid fit lies from the mean centre, in standard deviations (Mahalanobis). Above 3: a warning."""
        off_m = centred(self.rigid[None], self.hub_m)[0, :2] - self.mean_m
        return float(np.sqrt(off_m @ np.linalg.solve(self.covariance[:2, :2], off_m)))

    @property
    def theta_information(self) -> float:
        """How much is known about θ: Kullback-Leibler divergence from a uniform θ [nat]; 0 if nothing is."""
        share = self._theta_shares()
        share = share[share > 0.0]
        return float(share @ np.log(share * round(np.pi / self.half[1])))

    @property
    def modes(self) -> FloatArray:
        """Probability of each set of centres that hangs together, largest first, within the likeliest 99 %."""
        grid, _, _ = self._marginal()
        return component_weights(grid, _level_of(grid, _BULK))

    def region(self, share: float) -> FloatArray:
        """Convex polygon that holds the centre with this probability, and the mean.

        Returns:
            Corners in the newest base frame [m], counter-clockwise, shape (V, 2).
        """
        grid, first_m, pitch_m = self._marginal()
        polygon = credible_polygon(grid, share, (self.mean_m - first_m) / pitch_m)
        return np.asarray(first_m + pitch_m * polygon)

    def border_share(self, bounds_m: FloatArray) -> float:
        """Probability that the centre lies along the border of the bounds, nearer than a tenth of their side.

        It is 0.36 where nothing is known. Much more than that says that the part may well lie outside.
        """
        border_m, places_m = 0.1 * np.ptp(bounds_m, axis=1), self.poses[:, :2]
        outside = (places_m < bounds_m[:, 0] + border_m) | (places_m > bounds_m[:, 1] - border_m)
        return float(self.weight[outside.any(axis=1)].sum())

    def theta_interval(self, share: float) -> tuple[float, float] | None:
        """Smallest interval [low, high] of θ with this probability [rad], low in [-π, π); None without θ."""
        if self.theta_rad is None:
            return None
        shares = self._theta_shares()
        turns, width = shares.size, 2.0 * float(self.half[1])
        held = np.cumsum(np.concatenate([[0.0], shares, shares]))
        ends = np.searchsorted(held, held[:turns] + share - 1e-12)
        first = int((ends - np.arange(turns)).argmin())
        low = -np.pi + width * first
        return low, low + width * int(ends[first] - first)

    def level(self, pose: Pose2) -> float:
        """Probability of the smallest set of poses (x, y, θ) of highest density that holds a pose.

        If it is at most 0.9, the 90 % region holds the pose. 1 for a pose outside all cells.
        """
        hub_m = pose.apply(self.hub_m)
        off = np.column_stack([self.cells[:, :2] - hub_m, angle_difference(self.cells[:, 2], pose.theta_rad)])
        holds = (np.abs(off) <= self.half[[0, 0, 1]] * (1 + 1e-9)).all(axis=1)
        if not holds.any():
            return 1.0
        at = self.weight[holds].max()
        return float(self.weight[self.weight > at].sum() + at / 2.0)

    def samples(self, count: int) -> FloatArray:
        """Poses (x, y, θ) that stand for the posterior [m, m, rad], shape (count, 3), always the same ones.

        Systematic over the cells; inside a cell at the points of an additive sequence [Roberts2018].
        """
        edges = np.cumsum(self.weight) / self.weight.sum()
        chosen = np.minimum(np.searchsorted(edges, (np.arange(count) + 0.5) / count), len(edges) - 1)
        steps = 1.0 / 1.2207440846057596 ** np.arange(1, 4)
        inside = (np.arange(count)[:, None] * steps) % 1.0 - 0.5
        return centred(self.cells[chosen] + 2.0 * self.half[[0, 0, 1]] * inside, self.hub_m)

    @property
    def _cell_variance(self) -> FloatArray:
        """Variance of x, y and θ inside a cell, the hub's lever included, shape (3,)."""
        side, turn = (2.0 * self.half) ** 2 / 12.0
        across = side + min(turn, 1.0) * float(self.hub_m @ self.hub_m) / 2.0
        return np.array([across, across, turn])

    def _marginal(self) -> tuple[FloatArray, FloatArray, float]:
        """Probability of the centre on a grid, place of its first point [m], and its pitch [m]."""
        pitch_m = 2.0 * float(self.half[0])
        grid, first_m = spread_on_grid(self.poses[:, :2].copy(), self.weight, pitch_m)
        return grid, first_m, pitch_m

    def _theta_shares(self) -> FloatArray:
        turns = round(np.pi / self.half[1])
        which = np.floor((wrap_to_pi(self.cells[:, 2]) + np.pi) / (2.0 * self.half[1])).astype(np.int64)
        return np.asarray(np.bincount(np.clip(which, 0, turns - 1), self.weight, minlength=turns), dtype=np.float64)


def _level_of(grid: FloatArray, share: float) -> float:
    """Weight of the last grid point that the likeliest ones need to hold a share."""
    weights = np.sort(grid.ravel())[::-1]
    return float(weights[min(int(np.searchsorted(np.cumsum(weights), share)), weights.size - 1)])
