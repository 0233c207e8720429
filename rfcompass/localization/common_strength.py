"""Fit the tags of a scan together, with one strength that they share.

    (p_1 ... p_T, C) = argmin Σ_t L_t(p_t, C),

L as in `phase_fit`. For a given C each tag is fitted on its own, from all its phase optima; C is found by a search over
one number. Nothing else is shared: where one tag is says nothing about where another is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from rfcompass.localization.phase_fit import Fit, PhaseFitter, Pull
from rfcompass.localization.tag_strength import TagStrength

STEP_DB = 2.0  # ours: small against how far one tag can be pulled, so that no optimum is stepped over
TOLERANCE_DB = 0.1


@dataclass(frozen=True, kw_only=True)
class SharedStrength:
    """How much tags have in common; both values are ours.

    Attributes:
        spread_db: σ, the spread of the tags' strengths [dB]: makers state sensitivities to a decibel or so, and
            reflections that do not average out along the path add as much.
        least_tags: With fewer tags that were heard, each is fitted on its own: two cannot tell which is the odd one.
    """

    spread_db: float = 1.5
    least_tags: int = 3


@dataclass(frozen=True)
class Candidate:
    """One tag: its fitter, the optima of its phases alone, and its strength."""

    fitter: PhaseFitter
    optima: tuple[Fit, ...]
    strength: TagStrength

    def alone(self) -> Fit:
        """Best fit of the phases alone."""
        return self.fitter.best(self.optima)

    def pulled(self, common_db: float, spread_db: float) -> Fit:
        """Best fit with a strength that is common to all tags [dB]."""
        pull = Pull(self.strength, common_db, spread_db)
        return self.fitter.best([self.fitter.fit(fit.point_m, fit.lags, pull) for fit in self.optima])


def common_strength(candidates: Sequence[Candidate], spread_db: float) -> float:
    """The strength C that leaves the least loss in all tags together [dB].

    Searched in steps of 2 dB between the strengths that tags have at the best fits of their phases alone, since there
    may be several optima, and then to a tenth of a decibel.
    """
    alone = [one.strength.at(one.alone().point_m) for one in candidates]
    low, high = min(alone), max(alone)

    def loss(common_db: float) -> float:
        return sum(one.pulled(common_db, spread_db).loss for one in candidates)

    steps = np.linspace(low, high, max(2, int(np.ceil((high - low) / STEP_DB)) + 1))
    best = int(np.argmin([loss(float(step)) for step in steps]))
    around = (float(steps[max(best - 1, 0)]), float(steps[min(best + 1, steps.size - 1)]))
    if around[1] - around[0] < TOLERANCE_DB:
        return float(steps[best])
    return float(minimize_scalar(loss, bounds=around, method="bounded", options={"xatol": TOLERANCE_DB}).x)
