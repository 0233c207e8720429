"""Self-check of a meter at run time, against the one thing a robot knows for sure: how far its own tags are apart.

The anchor block of a proximity matrix holds m of every pair of anchors, forward kinematics their distance d. How well
m tells d is fitted as

    log m = a + b log d + e,        σ = sd(e) / b,

with Theil and Sen's slope b (median of the slopes of all pairs of points) and a robust sd (1.4826 times the median of
absolute deviations). σ is the noise of log d that would disorder distances as much as the meter does: a dimensionless
figure that compares meters of any unit. The bisectors of [Wang2013] need about 0.1 or less for centimetres.

It judges the robot's tags. Those of a part that lies lower, further away or behind something may fare worse.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.optimize import isotonic_regression

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError, TooFewPairs
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.record import Record
from rfcompass.types.tags import TagPositions

LEAST_PAIRS = 4  # ours: two for the line, and two beside them to see how far points lie off it
TIE_M = 1e-6  # distances closer than this are equal: on a symmetric robot they differ by rounding only
MAD_TO_SD = 1.4826  # of normal noise

Verdict: TypeAlias = Literal["good", "fair", "poor", "useless"]
# Ours, read off a simulated study of what comparisons need: σ = 0.1 gives 1 to 3 cm with four tags on the part, 0.3
# gives 3 to 4 cm at the median and 15 cm at the 90 % quantile; beyond 1, order is hardly better than chance.
VERDICTS: tuple[tuple[float, Verdict], ...] = ((0.1, "good"), (0.3, "fair"), (1.0, "poor"))


# Meters whose m is a distance in metres, so that its scale is known to be 1.
METRIC_KINDS = frozenset({"sar_nearfield"})


@dataclass(frozen=True, slots=True)
class ComparatorQuality(Record):
    """How well one scan's proximities tell the known distances of the robot's own tags.

    Attributes:
        kind: Meter that was used.
        pairs: Pairs of anchors with a proximity.
        rank_correlation: Spearman's ρ of m and d, 1 if their order is the same.
        slope: b: m grows as d to the power b.
        intercept: a: log m at one metre.
        log_distance_noise: σ; infinite if m does not grow with d.
        triplets: How many times one anchor was asked which of two others is nearer; true ties are not asked.
        wrong_share: Share of wrong answers, ties of m included; None if nothing could be asked.
    """

    kind: str
    pairs: int
    rank_correlation: float
    slope: float
    intercept: float
    log_distance_noise: float
    triplets: int
    wrong_share: float | None

    @property
    def verdict(self) -> Verdict:
        """`good`, `fair`, `poor` or `useless`, by the equivalent noise."""
        return next((word for limit, word in VERDICTS if self.log_distance_noise <= limit), "useless")


@dataclass(frozen=True, slots=True)
class DistanceCalibration(Record):
    """Distance as a growing function of m, straight between knots, made by `calibrate_distances`.

    Attributes:
        m: Knots in the units of the meter, ascending, shape (P,).
        distances_m: Fitted distance at each knot, never falling [m], shape (P,).
    """

    m: FloatArray
    distances_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they ascend."""
        object.__setattr__(self, "m", read_only(self.m, "DistanceCalibration.m", (None,)))
        distances_m = read_only(self.distances_m, "DistanceCalibration.distances_m", self.m.shape)
        object.__setattr__(self, "distances_m", distances_m)
        if not self.m.size or (np.diff(self.m) <= 0).any() or (np.diff(distances_m) < 0).any():
            raise InputError("DistanceCalibration: knots must ascend, and distances must not fall")

    def distance_m(self, m: npt.ArrayLike) -> FloatArray:
        """Distance for values of m [m], same shape; NaN stays NaN, and beyond the knots the last value holds."""
        return np.asarray(np.interp(np.asarray(m, dtype=np.float64), self.m, self.distances_m))


def check_comparator(matrix: ProximityMatrix, anchors: TagPositions) -> ComparatorQuality:
    """Judge a meter by the robot's own tags.

    Pairs with m = 0 count for ranks and triplets, but not for the fit of logarithms.

    Args:
        matrix: Proximities of one stop.
        anchors: Where its anchors were, in any frame.

    Raises:
        InputError: If the place of an anchor is not among those given.
        TooFewPairs: If fewer than four pairs have a proximity above 0 and different distances.
    """
    d = _distances_m(matrix, anchors)
    m_pairs, d_pairs = _pairs(matrix.anchor_m, d)
    usable = (m_pairs > 0) & (d_pairs > 0)
    log_m, log_d = np.log(m_pairs[usable]), np.log(d_pairs[usable])
    _require_pairs(matrix.kind, log_d)
    slope, intercept = _theil_sen(log_d, log_m)
    rest = log_m - intercept - slope * log_d
    spread = MAD_TO_SD * float(np.median(np.abs(rest)))
    wrong = _wrong_triplets(matrix.anchor_m, d)
    return ComparatorQuality(
        kind=matrix.kind,
        pairs=len(m_pairs),
        rank_correlation=_spearman(m_pairs, d_pairs),
        slope=slope,
        intercept=intercept,
        log_distance_noise=spread / slope if slope > 0 else float("inf"),
        triplets=len(wrong),
        wrong_share=float(wrong.mean()) if len(wrong) else None,
    )


def calibrate_distances(matrix: ProximityMatrix, anchors: TagPositions) -> DistanceCalibration:
    """Fit distances to proximities without a model: the best growing function of m for log d, by least squares.

    It regresses d on m, so that a noisy meter gives distances near the middle of those on the robot.

    Args:
        matrix: Proximities of one stop.
        anchors: Where its anchors were, in any frame.

    Raises:
        InputError: If the place of an anchor is not among those given.
        TooFewPairs: If fewer than four pairs of different distances have a proximity.
    """
    m_pairs, d_pairs = _pairs(matrix.anchor_m, _distances_m(matrix, anchors))
    usable = d_pairs > 0
    m_pairs, log_d = m_pairs[usable], np.log(d_pairs[usable])
    _require_pairs(matrix.kind, log_d)
    knots, place, counts = np.unique(m_pairs, return_inverse=True, return_counts=True)
    means = np.bincount(place, log_d) / counts
    return DistanceCalibration(knots, np.exp(isotonic_regression(means, weights=counts.astype(np.float64)).x))


def _distances_m(matrix: ProximityMatrix, anchors: TagPositions) -> FloatArray:
    points_m = np.array([anchors.point_m(epc) for epc in matrix.anchor_epcs]).reshape(-1, 3)
    return np.asarray(np.linalg.norm(points_m[:, None] - points_m[None], axis=2))


def _pairs(m: FloatArray, d: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return m and d of each pair of anchors with a proximity."""
    upper = np.triu_indices(len(m), 1)
    known = np.isfinite(m[upper])
    return m[upper][known], d[upper][known]


def _require_pairs(kind: str, log_d: FloatArray) -> None:
    if len(log_d) < LEAST_PAIRS or np.ptp(log_d) < TIE_M:
        message = (
            f"{len(log_d)} pairs of anchors with a proximity from {kind}, {LEAST_PAIRS} of different distances needed"
        )
        raise TooFewPairs(message, pairs=len(log_d), needed=LEAST_PAIRS, meter=kind)


def _theil_sen(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Slope and intercept of a line through most points."""
    i, j = np.triu_indices(len(x), 1)
    run = x[j] - x[i]
    apart = np.abs(run) > TIE_M
    slope = float(np.median((y[j] - y[i])[apart] / run[apart]))
    return slope, float(np.median(y - slope * x))


def _spearman(a: FloatArray, b: FloatArray) -> float:
    """Rank correlation; 0 if all values of one are equal."""
    rank_a, rank_b = _ranks(a), _ranks(b)
    scale = float(np.sqrt((rank_a @ rank_a) * (rank_b @ rank_b)))
    return float(rank_a @ rank_b) / scale if scale > 0 else 0.0


def _ranks(values: FloatArray) -> FloatArray:
    """Place of each value in the order of all, less the mean; equal values share their mean place."""
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    ranks = (np.cumsum(counts) - (counts - 1) / 2.0)[place]
    return np.asarray(ranks - ranks.mean())


def _wrong_triplets(m: FloatArray, d: FloatArray) -> FloatArray:
    """1 where an anchor's answer to "which of the two is nearer?" is wrong, 0 where it is right, for all asked."""
    i, j = np.triu_indices(len(m), 1)
    asker = np.arange(len(m))[:, None]
    seems, truly = m[:, i] - m[:, j], d[:, i] - d[:, j]
    asked = (asker != i) & (asker != j) & np.isfinite(seems) & (np.abs(truly) > TIE_M)
    return np.asarray(np.sign(seems[asked]) != np.sign(truly[asked]), dtype=np.float64)


def own_scale(matrix: ProximityMatrix, anchors: TagPositions) -> float | None:
    """How many times too long the distances between the robot's own tags seem: the median of m / d.

    Far from 1, the images of these tags show something else than the tags, whatever their order.

    Args:
        matrix: Proximities of one scan.
        anchors: Where forward kinematics puts the robot's tags in that scan, in the order of the matrix.

    Returns:
        The ratio; None for a meter that does not measure in metres, or where no pair was measured.
    """
    if matrix.kind not in METRIC_KINDS:
        return None
    i, j = np.triu_indices(len(anchors.epcs), 1)
    d_m = np.linalg.norm(anchors.points_m[i] - anchors.points_m[j], axis=1)
    m = matrix.anchor_m[i, j]
    told = np.isfinite(m) & (d_m > TIE_M)
    return float(np.median(m[told] / d_m[told])) if told.any() else None
