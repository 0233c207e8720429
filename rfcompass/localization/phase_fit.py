"""Local fits of a tag's place to its phases, and to the strength it would have there.

The loss of N phase residuals r and of the deviation of the tag's strength S from the common one C is

    L(p, C) = w Σ ρ(r / τ) + ρ((S(p) - C) / σ),        ρ(z) = √(1 + z²) - 1,        w = (n / N) (τ / s)²,

with ρ the soft-L1 loss (up to a factor), σ the spread of strengths, n the number of phases that are independent of each
other (`PhaseModel.independent_share`) and s the error of a phase, so that L is the negative logarithm of a likelihood.
What the weight w is does not matter for the phases alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from rfcompass.arrays import FloatArray
from rfcompass.localization.phase_model import PhaseModel
from rfcompass.localization.tag_strength import TagStrength
from rfcompass.types.volumes import SearchVolume

SAME_PLACE_M = 0.005  # fits that end this near to each other are one


@dataclass(frozen=True, slots=True)
class Fit:
    """One local optimum.

    Attributes:
        point_m: Where it is [m], shape (3,).
        lags: The phases as they were unwrapped for it, see `PhaseModel.lags`.
        loss: L, without its second term if strength was left out.
    """

    point_m: FloatArray
    lags: tuple[FloatArray, ...]
    loss: float


@dataclass(frozen=True, slots=True)
class Pull:
    """The second term of L: a strength [dB], the common one, and how far tags spread about it."""

    strength: TagStrength
    common_db: float
    spread_db: float

    def deviation(self, point_m: FloatArray) -> float:
        """(S - C) / σ at a point."""
        return (self.strength.at(point_m) - self.common_db) / self.spread_db


@dataclass(frozen=True)
class PhaseFitter:
    """Fits one tag inside a volume.

    Attributes:
        model: The tag's phases.
        volume: Where the tag may be.
        soft_rad: τ [rad].
        weight: w.
    """

    model: PhaseModel
    volume: SearchVolume
    soft_rad: float
    weight: float

    def fit(self, start_m: FloatArray, lags: tuple[FloatArray, ...], pull: Pull | None = None) -> Fit:
        """Local optimum from one start [m], shape (3,); axes of zero extent stay as they are."""
        free = self.volume.free_axes

        def at(free_m: FloatArray) -> FloatArray:
            point_m = start_m.copy()
            point_m[free] = free_m
            return point_m

        result = least_squares(
            lambda free_m: self._deviations(at(free_m), lags, pull),
            start_m[free],
            jac=lambda free_m: self._slopes(at(free_m), pull)[:, free],
            bounds=(self.volume.lower_m[free], self.volume.upper_m[free]),
            loss=_weighted_soft_l1(self.weight, pull is not None),
        )
        return Fit(at(result.x), lags, float(result.cost))

    def best(self, fits: Sequence[Fit]) -> Fit:
        """The fit of least loss inside the volume; of all if every one has run into its border."""
        inside = [fit for fit in fits if not self.volume.at_border(fit.point_m)]
        return min(inside or fits, key=lambda fit: fit.loss)

    def _deviations(self, point_m: FloatArray, lags: tuple[FloatArray, ...], pull: Pull | None) -> FloatArray:
        phases = self.model.residuals(point_m, lags) / self.soft_rad
        return phases if pull is None else np.append(phases, pull.deviation(point_m))

    def _slopes(self, point_m: FloatArray, pull: Pull | None) -> FloatArray:
        phases = self.model.jacobian(point_m) / self.soft_rad
        return phases if pull is None else np.vstack([phases, pull.strength.gradient(point_m) / pull.spread_db])


def distinct(fits: Sequence[Fit]) -> list[Fit]:
    """Fits that ended at different places, best first."""
    kept: list[Fit] = []
    for fit in sorted(fits, key=lambda fit: fit.loss):
        if all(np.linalg.norm(fit.point_m - other.point_m) > SAME_PLACE_M for other in kept):
            kept.append(fit)
    return kept


def _weighted_soft_l1(weight: float, pulled: bool) -> Callable[[FloatArray], FloatArray]:
    """ρ with its first two derivatives with respect to z², as SciPy takes them; phases weigh w, a pull 1."""

    def loss(squares: FloatArray) -> FloatArray:
        root = np.sqrt(1.0 + squares)
        weights = np.full(squares.size, weight)
        if pulled:
            weights[-1] = 1.0
        return np.asarray(weights * np.stack([2.0 * (root - 1.0), 1.0 / root, -0.5 / root**3]))

    return loss
