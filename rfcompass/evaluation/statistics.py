"""Statistics of trials, each with an interval: nothing is reported without one.

A *statistic* is named by a word: `"median"`, `"mean"`, `"sd"` for the standard deviation (that of the samples, not
corrected), `"p90"` for the 90 % quantile (any number after the p), or `"max10"` for the median of the largest of ten
samples (any number after it), drawn from all with replacement: the quantile 2^(-1/10), since P(max <= x) = F(x)^10.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import InputError, ShapeError

RESAMPLES = 2000  # enough for the second digit of a 95 % limit
_BLOCK = 500_000  # elements handled at once, so that memory does not grow with the number of trials


@dataclass(frozen=True, slots=True)
class Interval:
    """Lower and upper confidence limit."""

    low: float
    high: float

    def hull(self, other: "Interval") -> "Interval":
        """Return the smallest interval that holds both."""
        return Interval(min(self.low, other.low), max(self.high, other.high))


def sample_statistic(samples: FloatArray, statistic: str) -> float:
    """Compute a statistic of samples, shape (n,), as numpy does (linear interpolation between ranks).

    Raises:
        InputError: If there is no such statistic.
        ShapeError: If there is no sample.
    """
    x = _samples(samples)
    quantile = quantile_of(statistic)
    if quantile is not None:
        return float(np.quantile(x, quantile))
    return float(x.std() if statistic == "sd" else x.mean())


def bootstrap_interval(
    samples: FloatArray,
    statistic: str,
    rng: np.random.Generator,
    *,
    clusters: IntArray | None = None,
    resamples: int = RESAMPLES,
    level: float = 0.95,
) -> Interval:
    """Percentile-bootstrap interval of a statistic, after Efron (1979).

    Whole clusters are drawn with replacement, each with all its samples: tags of one sweep share their errors,
    so that treating them as independent would give an interval that is too narrow.

    Args:
        samples: Values, shape (n,).
        statistic: Name of the statistic.
        rng: Source of the resamples; the same generator state gives the same interval.
        clusters: Number of the cluster of each sample, shape (n,); each sample on its own if None.
        resamples: Number of resamples.
        level: Nominal coverage.

    Raises:
        InputError: If there is no such statistic.
        ShapeError: If there is no sample, or the arrays do not fit.
    """
    x = _samples(samples)
    cluster = np.arange(len(x)) if clusters is None else read_only(clusters, "clusters", (len(x),), np.int64)
    return _limits(np.concatenate([_resampled(x, statistic, c) for c in _counts(cluster, resamples, rng)]), level)


def paired_difference_interval(
    first: FloatArray,
    second: FloatArray,
    statistic: str,
    rng: np.random.Generator,
    *,
    resamples: int = RESAMPLES,
    level: float = 0.95,
) -> Interval:
    """Percentile-bootstrap interval of statistic(first) - statistic(second), both drawn by the same pairs.

    Pairs share a seed, so what makes a trial hard for both methods cancels.

    Args:
        first: Values of one method, shape (n,).
        second: Values of the other for the same seeds, shape (n,).
        statistic: Name of the statistic.
        rng: Source of the resamples.
        resamples: Number of resamples.
        level: Nominal coverage.

    Raises:
        InputError: If there is no such statistic.
        ShapeError: If there is no pair, or the arrays do not fit.
    """
    a = _samples(first)
    b = read_only(second, "second", (len(a),))
    differences = [
        _resampled(a, statistic, counts) - _resampled(b, statistic, counts)
        for counts in _counts(np.arange(len(a)), resamples, rng)
    ]
    return _limits(np.concatenate(differences), level)


def wilson_interval(successes: int, trials: int, level: float = 0.95) -> Interval:
    """Score interval of a share, after Wilson (1927); its limits stay within 0 and 1 and apart, even for 0 or all.

    With z the normal quantile, s successes in n trials:
    (s + z²/2 ± z √(s (n - s) / n + z²/4)) / (n + z²).

    Raises:
        InputError: If there is no trial, or more successes than trials.
    """
    _check_share(successes, trials)
    z = NormalDist().inv_cdf((1.0 + level) / 2.0)
    half = z * np.sqrt(successes * (trials - successes) / trials + z * z / 4.0)
    centre = successes + z * z / 2.0
    low, high = (centre - half) / (trials + z * z), (centre + half) / (trials + z * z)
    return Interval(max(0.0, float(low)), min(1.0, float(high)))


def exact_interval(successes: int, trials: int, level: float = 0.95) -> Interval:
    """Interval of a share that covers it with at least the level [ClopperPearson1934].

    Its limits are the shares at which so many successes, or more, and so many, or fewer, have a probability of
    (1 - level) / 2 each: quantiles of Beta(s, n - s + 1) and Beta(s + 1, n - s). Wider than `wilson_interval`, whose
    coverage is right on the average only; so this one is for verdicts.

    Raises:
        InputError: If there is no trial, or more successes than trials.
    """
    from scipy.special import betaincinv  # noqa: PLC0415 - workers of a study import this module, and need no scipy

    _check_share(successes, trials)
    tail, failures = (1.0 - level) / 2.0, trials - successes
    low = betaincinv(successes, failures + 1, tail) if successes else 0.0
    high = betaincinv(successes + 1, failures, 1.0 - tail) if failures else 1.0
    return Interval(float(low), float(high))


def quantile_of(statistic: str) -> float | None:
    """Return the quantile that a statistic's name stands for, None for the mean and the standard deviation.

    Raises:
        InputError: If there is no such statistic.
    """
    if statistic in ("mean", "sd"):
        return None
    if statistic == "median":
        return 0.5
    if (percent := re.fullmatch(r"p(\d{1,2})", statistic)) is not None:
        return int(percent[1]) / 100.0
    if (largest_of := re.fullmatch(r"max([1-9]\d{0,2})", statistic)) is not None:
        return float(0.5 ** (1.0 / int(largest_of[1])))
    message = f"no statistic {statistic!r}; known: median, mean, sd, p01 .. p99, max1 .. max999"
    raise InputError(message, statistic=statistic)


def _check_share(successes: int, trials: int) -> None:
    if trials < 1 or not 0 <= successes <= trials:
        raise InputError(f"{successes} successes in {trials} trials make no share", successes=successes, trials=trials)


def _samples(samples: FloatArray) -> FloatArray:
    x = read_only(samples, "samples", (None,))
    if x.size == 0:
        raise ShapeError("a statistic needs at least one sample", name="samples")
    return x


def _counts(cluster: IntArray, resamples: int, rng: np.random.Generator) -> Iterator[IntArray]:
    """Count how often each sample occurs in each resample: blocks of shape (B, n)."""
    names, cluster = np.unique(cluster, return_inverse=True)
    C = len(names)
    block = max(1, _BLOCK // len(cluster))
    for start in range(0, resamples, block):
        B = min(block, resamples - start)
        drawn = rng.integers(C, size=(B, C)) + C * np.arange(B)[:, None]
        yield np.bincount(drawn.ravel(), minlength=B * C).reshape(B, C)[:, cluster]


def _resampled(x: FloatArray, statistic: str, counts: IntArray) -> FloatArray:
    """Statistic of each resample, shape (B,), from how often each sample occurs in it, shape (B, n)."""
    quantile = quantile_of(statistic)
    totals = counts.sum(axis=1)
    if quantile is None:
        mean = (counts * x).sum(axis=1) / totals
        if statistic == "mean":
            return np.asarray(mean)
        return np.sqrt((counts * (x - mean[:, None]) ** 2).sum(axis=1) / totals)
    order = np.argsort(x, kind="stable")
    last = np.cumsum(counts[:, order], axis=1)  # rank after the last copy of each sample
    position = quantile * (totals - 1)
    below = np.floor(position).astype(np.int64)
    above = np.minimum(below + 1, totals - 1)
    at_below, at_above = (x[order][(last <= rank[:, None]).sum(axis=1)] for rank in (below, above))
    return np.asarray(at_below + (position - below) * (at_above - at_below))


def _limits(values: FloatArray, level: float) -> Interval:
    low, high = np.quantile(values, [(1.0 - level) / 2.0, (1.0 + level) / 2.0])
    return Interval(float(low), float(high))
