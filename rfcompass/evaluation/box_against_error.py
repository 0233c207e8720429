"""Does the size of a box that a method gives tell how wrong it is? Asked over many trials."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.stats import rankdata

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.evaluation.statistics import RESAMPLES, Interval

LEAST_TRIALS = 4  # two for each half


@dataclass(frozen=True, slots=True)
class BoxAgainstError:
    """How errors differ between small boxes and large ones.

    Attributes:
        trials: Number of trials.
        smaller_m: Median error of the half with the smaller boxes [m].
        larger_m: Median error of the other half [m].
        rank_correlation: Spearman's ρ of box and error: 1 if the larger box always has the larger error.
        interval: 95 % bootstrap interval of ρ, over trials.
    """

    trials: int
    smaller_m: float
    larger_m: float
    rank_correlation: float
    interval: Interval


def box_against_error(
    boxes: npt.ArrayLike, errors_m: npt.ArrayLike, rng: np.random.Generator, *, resamples: int = RESAMPLES
) -> BoxAgainstError:
    """Compare errors with the sizes of boxes.

    With an odd number of trials the one in the middle belongs to the larger half.

    Args:
        boxes: Size of the box of each trial, in any unit, shape (n,).
        errors_m: Error of each trial [m], shape (n,).
        rng: Source of the resamples.
        resamples: Number of bootstrap resamples.

    Raises:
        ShapeError: If the arrays do not fit, or there are fewer than four trials.
    """
    size = read_only(boxes, "boxes", (None,))
    error_m = read_only(errors_m, "errors_m", size.shape)
    n = size.size
    if n < LEAST_TRIALS:
        raise ShapeError(f"{n} trials, {LEAST_TRIALS} needed to halve them", name="boxes", trials=n)
    order = np.argsort(size, kind="stable")
    draws = rng.integers(0, n, (resamples, n))
    low, high = np.quantile([rank_correlation(size[draw], error_m[draw]) for draw in draws], (0.025, 0.975))
    return BoxAgainstError(
        trials=n,
        smaller_m=float(np.median(error_m[order[: n // 2]])),
        larger_m=float(np.median(error_m[order[n // 2 :]])),
        rank_correlation=rank_correlation(size, error_m),
        interval=Interval(float(low), float(high)),
    )


def rank_correlation(a: FloatArray, b: FloatArray) -> float:
    """Spearman's ρ of two samples, shape (n,); 0 if all values of one are equal."""
    rank_a, rank_b = rankdata(a) - (len(a) + 1) / 2, rankdata(b) - (len(b) + 1) / 2
    scale = float(np.sqrt((rank_a @ rank_a) * (rank_b @ rank_b)))
    return float(rank_a @ rank_b) / scale if scale > 0 else 0.0
