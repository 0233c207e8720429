"""Errors of estimates, and how often two things are ordered as they truly are."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rfcompass.arrays import BoolArray, FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.geometry.angles import angle_difference

TIE_M = 1e-6  # true distances closer than this are equal: on an even grid they differ by rounding only


@dataclass(frozen=True, slots=True)
class JudgedComparisons:
    """Questions "which of the two?" that have been answered.

    Attributes:
        correct: True where the answer is the true one; a tie is no answer and counts as wrong, shape (M,).
        gap_m: How far apart the two truly are in what was asked: small gaps are hard [m], shape (M,).
    """

    correct: BoolArray
    gap_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze and check the arrays."""
        object.__setattr__(self, "correct", read_only(self.correct, "JudgedComparisons.correct", (None,), np.bool_))
        object.__setattr__(self, "gap_m", read_only(self.gap_m, "JudgedComparisons.gap_m", self.correct.shape))

    @property
    def share(self) -> float | None:
        """Share of right answers; None if nothing was asked."""
        return float(self.correct.mean()) if self.correct.size else None

    def within(self, low_m: float, high_m: float = np.inf) -> "JudgedComparisons":
        """Return those whose gap lies in [low, high) [m]."""
        inside = (self.gap_m >= low_m) & (self.gap_m < high_m)
        return JudgedComparisons(self.correct[inside], self.gap_m[inside])


def position_error_m(estimates_m: npt.ArrayLike, truth_m: npt.ArrayLike) -> FloatArray:
    """Distance between estimate and truth [m], shape (...).

    Args:
        estimates_m: Estimated positions [m], shape (..., D).
        truth_m: True positions in the same frame [m], broadcast against the estimates.
    """
    difference = np.asarray(estimates_m, dtype=np.float64) - np.asarray(truth_m, dtype=np.float64)
    return np.asarray(np.linalg.norm(difference, axis=-1))


def angle_error_rad(estimates_rad: npt.ArrayLike, truth_rad: npt.ArrayLike, symmetry: int = 1) -> FloatArray:
    """Size of the smallest turn between estimate and truth [rad], in [0, π / symmetry].

    Args:
        estimates_rad: Estimated angles [rad], any shape.
        truth_rad: True angles [rad], broadcast against the estimates.
        symmetry: Number of turns by which the part looks the same: 1 for none, 2 for half a turn.

    Raises:
        ShapeError: If `symmetry` is below 1.
    """
    if symmetry < 1:
        raise ShapeError(f"a part looks the same after {symmetry} turns? At least 1", symmetry=symmetry)
    return np.abs(angle_difference(estimates_rad, truth_rad, 2.0 * np.pi / symmetry))


def order_comparisons(estimates_m: npt.ArrayLike, truth_m: npt.ArrayLike) -> JudgedComparisons:
    """Ask of every pair of tags which one comes first along an axis; true ties are not asked.

    Args:
        estimates_m: Estimated coordinates along the axis [m], shape (N,).
        truth_m: True coordinates [m], shape (N,).

    Raises:
        ShapeError: If the arrays do not fit.
    """
    estimates = read_only(estimates_m, "estimates_m", (None,))
    truth = read_only(truth_m, "truth_m", estimates.shape)
    i, j = np.triu_indices(len(truth), 1)
    return _judge(estimates[i] - estimates[j], truth[i] - truth[j])


def triplet_comparisons(
    epcs: Sequence[str], m: npt.ArrayLike, positions_m: Mapping[str, npt.ArrayLike]
) -> JudgedComparisons:
    """Ask of every tag a and every pair i, j which one is nearer to a: is m[a, i] < m[a, j]?

    The gap is | |a - i| - |a - j| |. Pairs with a missing m, true ties and tags without a true position are
    not asked.

    Args:
        epcs: Tags of the matrix (N).
        m: Proximity of each tag to each other one, NaN where missing, shape (N, N).
        positions_m: True position of each tag [m], shape (D,) each.

    Raises:
        ShapeError: If matrix, EPCs and positions do not fit.
    """
    proximity = read_only(m, "m", (len(epcs), len(epcs)), finite=False)
    known = [k for k, epc in enumerate(epcs) if epc in positions_m]
    if len(known) < 3:
        return JudgedComparisons(np.zeros(0, dtype=np.bool_), np.zeros(0))
    proximity = proximity[np.ix_(known, known)]
    p = np.array([positions_m[epcs[k]] for k in known], dtype=np.float64)
    distance = position_error_m(p[:, None, :], p[None, :, :])
    i, j = np.triu_indices(len(known), 1)
    a = np.arange(len(known))[:, None]
    return _judge(proximity[:, i] - proximity[:, j], distance[:, i] - distance[:, j], asked=(a != i) & (a != j))


def _judge(answers: FloatArray, truth: FloatArray, asked: BoolArray | None = None) -> JudgedComparisons:
    """Compare the signs of two differences of one shape, where both exist and the true one is no tie."""
    keep = (np.abs(truth) > TIE_M) & ~np.isnan(answers)
    if asked is not None:
        keep &= asked
    return JudgedComparisons(np.sign(answers[keep]) == np.sign(truth[keep]), np.abs(truth[keep]))
