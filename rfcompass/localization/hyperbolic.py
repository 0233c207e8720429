"""Locate tags by fitting the unwrapped phase along the antenna path, and the strength that tags have in common.

Equal differences of distance lie on hyperbolae, hence the name. All runs and channels are fitted together,

    p = argmin w Σ ρ( [φ - k d(p) - constant] / τ ) + ρ( [S(p) - C] / σ ),        ρ(z) = √(1 + z²) - 1,

with φ the phase lag, d the round trip, a constant for each run and channel, ρ the soft-L1 loss and w the weight of a
phase (`phase_fit`). The last term is there if several tags are located together: S(p) is the strength of a tag of this
received level at p, C the strength that the tags have in common (`tag_strength`, `common_strength`). The fit starts
from the best peaks of the hologram; one that runs into the border of the search volume loses to any that does not.
Phases are unwrapped about the phase that a tag at the start would have, so that gaps in the path do no harm.

Reflections are correlated along the path (`phase_model`). Weighting the fit by that correlation was tried: it is better
on two families of measured sweeps and worse on two others. So the fit is plain; its box knows of it, and
the weight of phases against strength.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.localization.common_strength import Candidate, SharedStrength, common_strength
from rfcompass.localization.confidence_box import MAX_BOX_M, ConfidenceBox, is_confident
from rfcompass.localization.phase_fit import Fit, PhaseFitter, distinct
from rfcompass.localization.phase_model import PathCovariance, PhaseModel, build_phase_model
from rfcompass.localization.reads_needed import require_reads
from rfcompass.localization.tag_strength import tag_strength
from rfcompass.rf.hologram import Matching, build_hologram
from rfcompass.rf.peak_search import coarse_peaks
from rfcompass.types.fixes import TagFix
from rfcompass.types.reads import ReadTrace
from rfcompass.types.volumes import SearchVolume

STARTS = 8  # ours; medians on measured sweeps are the same with 4
# Ours; a typical phase residual of a reflection. From 0.1 to 1 rad the answers on measured sweeps hardly differ.
SOFT_RAD = 0.3
# Ours: the model of reflections is too kind. On measured development sweeps ± 2 standard deviations hold 40 to 90 % of
# the errors along the path instead of 95 %, and 30 to 80 % across it; ± 4 hold 90 to 100 % and 70 to 95 %, and with
# tags located together 93 to 100 % and 96 to 100 %.
BOX_SIGMAS = 4.0
# Ours: a tag's phases are off by twice what the fit leaves of them, as for the box; but not by more than τ, since
# larger residuals count linearly, nor by less than a reader's noise of about a degree.
HIDDEN = 2.0
NOISE_RAD = 0.02


@dataclass(frozen=True, kw_only=True)
class HyperbolicSurveyor:
    """Fit the tag's position to the unwrapped phases of all runs and channels.

    A fix is confident if its box, ± 4 standard deviations of the fit to the phases alone, is smaller than `max_box_m`
    along every axis and lies inside the search volume. Axes that the path does not observe have boxes as large as the
    volume.

    Attributes:
        covariance: How reflections are correlated along the path; decides the size of the box.
        soft_rad: τ, the residual beyond which the loss grows linearly [rad].
        max_box_m: Largest box of a confident fix along x, y, z [m].
        shared: What tags that are located together have in common; None fits each on its own. Choose None if tags of
            different kinds, or on different materials, are in one scan.
    """

    method: ClassVar[str] = "hyperbolic"
    covariance: PathCovariance = field(default_factory=PathCovariance)
    soft_rad: float = SOFT_RAD
    max_box_m: tuple[float, float, float] = MAX_BOX_M
    shared: SharedStrength | None = field(default_factory=SharedStrength)

    def locate(self, trace: ReadTrace, volume: SearchVolume) -> TagFix:
        """Find the tag inside a volume from its phases alone; see `Surveyor.locate`."""
        one = self._candidate(trace, volume)
        return self._fix(one, one.alone())

    def locate_together(self, traces: Sequence[ReadTrace], volume: SearchVolume) -> tuple[TagFix, ...]:
        """Find the tags of one scan, which share the reader and so their strength, up to a spread.

        Args:
            traces: Reads of the tags, one trace each.
            volume: Where they may be, in the frame of the antenna path.

        Returns:
            One fix for each trace, in the same order.

        Raises:
            TooFewReads: If one of the tags was heard at too few antenna positions.
        """
        every = [self._candidate(trace, volume) for trace in traces]
        if self.shared is None or len(every) < self.shared.least_tags:
            return tuple(self._fix(one, one.alone()) for one in every)
        common_db = common_strength(every, self.shared.spread_db)
        return tuple(self._fix(one, one.pulled(common_db, self.shared.spread_db)) for one in every)

    def _candidate(self, trace: ReadTrace, volume: SearchVolume) -> Candidate:
        """Optima of the phases alone, from the best peaks of the hologram."""
        require_reads(trace)
        hologram = build_hologram(trace, volume, Matching())
        starts = coarse_peaks(hologram.power, volume, hologram.wavelength_m, keep=STARTS)
        model = build_phase_model(trace)
        fitter = PhaseFitter(model, volume, self.soft_rad, 1.0)
        optima = distinct([fitter.fit(start.point_m, model.lags(start.point_m)) for start in starts])
        error_rad = float(np.clip(HIDDEN * _rms(model, fitter.best(optima)), NOISE_RAD, self.soft_rad))
        weight = model.independent_share(self.covariance) * (self.soft_rad / error_rad) ** 2
        return Candidate(replace(fitter, weight=weight), tuple(optima), tag_strength(trace))

    def _fix(self, one: Candidate, fit: Fit) -> TagFix:
        model, volume = one.fitter.model, one.fitter.volume
        rms_rad = _rms(model, fit)
        covariance_m2 = model.fit_covariance(fit.point_m, rms_rad**2, self.covariance, volume)
        box = _box(covariance_m2, volume, fit.point_m)
        return TagFix(
            epc=model.trace.epc,
            point_m=fit.point_m,
            box_m=box.extent_m,
            confident=is_confident(box, self.max_box_m),
            clipped=box.clipped,
            method=self.method,
            residual_rad=rms_rad,
        )


def _rms(model: PhaseModel, fit: Fit) -> float:
    """What a fit leaves of the phases [rad]."""
    return float(np.sqrt(np.mean(model.residuals(fit.point_m, fit.lags) ** 2)))


def _box(covariance_m2: FloatArray, volume: SearchVolume, point_m: FloatArray) -> ConfidenceBox:
    """± BOX_SIGMAS standard deviations along the free axes about the fit, cut at the border of the volume."""
    free, half_m = volume.free_axes, np.zeros(3)
    half_m[free] = BOX_SIGMAS * np.sqrt(np.diag(covariance_m2))
    low_m, high_m = np.maximum(point_m - half_m, volume.lower_m), np.minimum(point_m + half_m, volume.upper_m)
    clipped = ((low_m <= volume.lower_m) | (high_m >= volume.upper_m))[free].any()
    return ConfidenceBox(high_m - low_m, bool(clipped))
