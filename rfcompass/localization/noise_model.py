"""How good a meter is right now: its noise on the robot's own tags, whose distances are known."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.localization.noise_kernels import comparison_fits, distance_noise, own_fix_errors
from rfcompass.localization.placed_stop import PlacedStop, place_labels
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.record import Record

# All ours.
LEAST_PAIRS = 6  # fewer pairs of anchors tell nothing about noise
LEAST_RANK_CORRELATION = 0.6  # below it proximities order the robot's own tags too badly to stand for distances
LEAST_NOISE_M = 0.005  # a tag's phase centre and the hand's place are no better known than that
LEAST_BIAS_M = 0.01  # floor of the static bias; without it regions are too small where nothing scatters
PRIOR_BIAS_M = 0.1  # how far a robot tag may seem from its place along one axis
UNKNOWN_SCALE_M, UNKNOWN_LAPSE = 0.025, 0.02  # comparisons whose quality nobody measured

_ALPHAS_M = LEAST_NOISE_M * np.geomspace(1.0, 80.0, 14)
_BETAS = np.array([0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3])
_SCALES_M = np.geomspace(0.005, 0.4, 12)
_LAPSES = np.array([0.01, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0])


@dataclass(frozen=True, slots=True)
class NoiseModel(Record):
    """What a meter's numbers are worth.

    Attributes:
        scale: c of m = c d [units of m per metre].
        alpha_m: Noise of a distance at d = 0 [m]: s(d)² = α² + β² d².
        beta: Its growth with distance.
        bias_m: σ of the bias of a tag's place along one axis, the same in every scan [m].
        comparison_m: s of P(nearer wins) = λ/2 + (1 - λ) / (1 + exp(-Δd / s)) [m].
        lapse: λ.
        pairs: Pairs of anchors behind it.
        rank_correlation: Spearman's, between proximity and distance of these pairs; 0 without pairs.
        right_share: Share of right answers among all comparisons of the anchors with each other; NaN without any.
    """

    scale: float = 1.0
    alpha_m: float = UNKNOWN_SCALE_M
    beta: float = 0.0
    bias_m: float = LEAST_BIAS_M
    comparison_m: float = UNKNOWN_SCALE_M
    lapse: float = UNKNOWN_LAPSE
    pairs: int = 0
    rank_correlation: float = 0.0
    right_share: float = float("nan")

    @property
    def measures_distance(self) -> bool:
        """Whether m / c may stand for a distance."""
        return self.pairs >= LEAST_PAIRS and self.rank_correlation >= LEAST_RANK_CORRELATION


def fit_noise(stops: Sequence[PlacedStop], least_bias_m: float = LEAST_BIAS_M) -> NoiseModel:
    """Fit scale, noise and bias of one meter on the pairs of anchors of all stops.

    m_ij = c (d_ij + s(d_ij) t), t Student-4, and P(nearer wins), by maximum likelihood over a grid. A pair that
    did not move between stops counts once, with its mean. The bias is the root mean square of how far each anchor
    seems from its place by its distances to the others, but no less than the floor.

    Args:
        stops: Stops of one meter.
        least_bias_m: Floor of the bias [m].

    Returns:
        The model; with fewer than six pairs one of nothing but defaults.
    """
    d, m = _pairs(stops)
    if d.size < LEAST_PAIRS:
        return NoiseModel(pairs=int(d.size))
    scale, alpha_m, beta = distance_noise(d, m, _ALPHAS_M, _BETAS)
    fits = [comparison_fits(stop.distances_m, stop.anchor_m, _SCALES_M, _LAPSES) for stop in stops]
    best = np.sum([fit for fit, _, _ in fits], axis=0)
    a, b = np.unravel_index(best.argmax(), best.shape)
    count = sum(count for _, count, _ in fits)
    return NoiseModel(
        scale, alpha_m, beta, _bias_m(stops, scale, np.array([alpha_m, beta]), least_bias_m),
        float(_SCALES_M[a]), float(_LAPSES[b]), int(d.size), rank_correlation(d, m),
        sum(right for _, _, right in fits) / count if count else float("nan"),
    )  # fmt: skip


def noise_of(estimate: PartEstimate) -> NoiseModel | None:
    """The noise that the posterior's diagnostics tell of; None where an estimate says nothing about it.

    The noise of distances is that of the part's tags: raised by `noise_factor` where these fit worse than the robot's.
    """
    told = {name: value for name, value in estimate.diagnostics.items() if isinstance(value, int | float)}
    factor = float(told.get("noise_factor", 1.0))
    names = ("scale", "alpha_m", "beta", "bias_m", "comparison_m", "lapse", "rank_correlation")
    values = {name: float(told[name]) for name in names if name in told}
    if not {"alpha_m", "beta", "bias_m", "comparison_m"} <= set(values):
        return None
    values |= {"alpha_m": factor * values["alpha_m"], "beta": factor * values["beta"]}
    return NoiseModel(**values, pairs=int(told.get("anchor_pairs", 0)))


def rank_correlation(a: FloatArray, b: FloatArray) -> float:
    """Spearman's rank correlation of two samples without ties; 0 if one of them is constant."""
    if np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return 0.0
    return float(np.corrcoef(a.argsort().argsort(), b.argsort().argsort())[0, 1])


def _pairs(stops: Sequence[PlacedStop]) -> tuple[FloatArray, FloatArray]:
    """Distance and proximity of all pairs of anchors that were measured, each place once, shape (P,) each."""
    label = place_labels(np.vstack([stop.anchors_m for stop in stops]))
    start, size = 0, label.size
    keys, d, m = [], [], []
    for stop in stops:
        i, j = np.triu_indices(len(stop.anchors_m), 1)
        own = label[start : start + len(stop.anchors_m)]
        heard = np.isfinite(stop.anchor_m[i, j]) & (stop.distances_m[i, j] > 0.0)
        i, j = i[heard], j[heard]
        keys.append(np.minimum(own[i], own[j]) * size + np.maximum(own[i], own[j]))
        d.append(stop.distances_m[i, j])
        m.append(stop.anchor_m[i, j])
        start += len(stop.anchors_m)
    _, first, which, count = np.unique(np.concatenate(keys), return_index=True, return_inverse=True, return_counts=True)
    return np.concatenate(d)[first], np.bincount(which, np.concatenate(m)) / count


def _bias_m(stops: Sequence[PlacedStop], scale: float, noise: FloatArray, least_m: float) -> float:
    errors = [own_fix_errors(stop.anchors_m, stop.anchor_m / scale, noise, PRIOR_BIAS_M) for stop in stops]
    found = np.concatenate(errors)
    found = found[np.isfinite(found[:, 0])]
    if not len(found):
        return LEAST_BIAS_M
    return max(least_m, float(np.sqrt(np.mean(found**2))))
