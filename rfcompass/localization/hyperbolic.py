"""Locate a tag by fitting the unwrapped phase along the antenna path.

Equal differences of distance lie on hyperbolae, hence the name. All runs and channels are fitted together,

    p = argmin Σ ρ( [φ - k d(p) - constant]² ),        ρ(s) = 2 τ² (√(1 + s / τ²) - 1),

with φ the phase lag, d the round trip, a constant for each run and channel, and ρ the soft-L1 loss. The fit starts from
the best peaks of the hologram; one that runs into the border of the search volume loses to any that does not. Phases
are unwrapped about the phase that a tag at the start would have, so that gaps in the path do no harm.

Reflections are correlated along the path (`phase_model`). Weighting the fit by that correlation was tried: it is better
on two families of measured sweeps and worse on two others, so the fit stays plain and only its box knows of it.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from scipy.optimize import least_squares

from rfcompass.arrays import FloatArray
from rfcompass.localization.confidence_box import MAX_BOX_M, ConfidenceBox, is_confident
from rfcompass.localization.phase_model import PathCovariance, PhaseModel, build_phase_model
from rfcompass.localization.reads_needed import require_reads
from rfcompass.rf.hologram import Matching, build_hologram
from rfcompass.rf.peak_search import coarse_peaks
from rfcompass.types.fixes import TagFix
from rfcompass.types.reads import ReadTrace
from rfcompass.types.volumes import SearchVolume

STARTS = 8  # ours; medians on measured sweeps are the same with 4
# Ours; a typical phase residual of a reflection. From 0.1 to 1 rad the answers on measured sweeps hardly differ.
SOFT_RAD = 0.3
# Ours: the model of reflections is too kind. On measured development sweeps ± 2 standard deviations hold 40 to 90 % of
# the errors along the path instead of 95 %, and 30 to 80 % across it; ± 4 hold 90 to 100 % and 70 to 95 %.
BOX_SIGMAS = 4.0


@dataclass(frozen=True, slots=True)
class _Fit:
    point_m: FloatArray
    lags: tuple[FloatArray, ...]
    cost: float


@dataclass(frozen=True, kw_only=True)
class HyperbolicSurveyor:
    """Fit the tag's position to the unwrapped phases of all runs and channels.

    A fix is confident if its box, ± 4 standard deviations of the fit, is smaller than `max_box_m` along every axis and
    lies inside the search volume. Axes that the path does not observe have boxes as large as the volume.

    Attributes:
        covariance: How reflections are correlated along the path; decides the size of the box.
        soft_rad: τ, the residual beyond which the loss grows linearly [rad].
        max_box_m: Largest box of a confident fix along x, y, z [m].
    """

    method: ClassVar[str] = "hyperbolic"
    covariance: PathCovariance = field(default_factory=PathCovariance)
    soft_rad: float = SOFT_RAD
    max_box_m: tuple[float, float, float] = MAX_BOX_M

    def locate(self, trace: ReadTrace, volume: SearchVolume) -> TagFix:
        """Find the tag inside a volume; see `Surveyor.locate`."""
        require_reads(trace)
        hologram = build_hologram(trace, volume, Matching())
        starts = coarse_peaks(hologram.power, volume, hologram.wavelength_m, keep=STARTS)
        model = build_phase_model(trace)
        fit = _best([self._fit(model, volume, start.point_m) for start in starts], volume)
        residuals = model.residuals(fit.point_m, fit.lags)
        rms_rad = float(np.sqrt(np.mean(residuals**2)))
        covariance_m2 = model.fit_covariance(fit.point_m, rms_rad**2, self.covariance, volume)
        box = _box(covariance_m2, volume, fit.point_m)
        return TagFix(
            epc=trace.epc,
            point_m=fit.point_m,
            box_m=box.extent_m,
            confident=is_confident(box, self.max_box_m),
            clipped=box.clipped,
            method=self.method,
            residual_rad=rms_rad,
        )

    def _fit(self, model: PhaseModel, volume: SearchVolume, start_m: FloatArray) -> _Fit:
        """Local optimum from one start; axes of zero extent stay as they are."""
        free = volume.free_axes
        lower_m, upper_m = volume.lower_m[free], volume.upper_m[free]
        lags = model.lags(start_m)

        def at(free_m: FloatArray) -> FloatArray:
            point_m = start_m.copy()
            point_m[free] = free_m
            return point_m

        result = least_squares(
            lambda free_m: model.residuals(at(free_m), lags),
            start_m[free],
            jac=lambda free_m: model.jacobian(at(free_m))[:, free],
            bounds=(lower_m, upper_m),
            loss="soft_l1",
            f_scale=self.soft_rad,
        )
        return _Fit(at(result.x), lags, float(result.cost))


def _best(fits: list[_Fit], volume: SearchVolume) -> _Fit:
    """Cheapest fit inside the volume; the cheapest of all if every one has run into its border."""
    inside = [fit for fit in fits if not volume.at_border(fit.point_m)]
    return min(inside or fits, key=lambda fit: fit.cost)


def _box(covariance_m2: FloatArray, volume: SearchVolume, point_m: FloatArray) -> ConfidenceBox:
    """± BOX_SIGMAS standard deviations along the free axes about the fit, cut at the border of the volume."""
    free, half_m = volume.free_axes, np.zeros(3)
    half_m[free] = BOX_SIGMAS * np.sqrt(np.diag(covariance_m2))
    low_m, high_m = np.maximum(point_m - half_m, volume.lower_m), np.minimum(point_m + half_m, volume.upper_m)
    clipped = ((low_m <= volume.lower_m) | (high_m >= volume.upper_m))[free].any()
    return ConfidenceBox(high_m - low_m, bool(clipped))
