"""Dynamic time warping: how far apart two profiles are if one may be stretched along its axis.

D(i, j) = |a_i - b_j|^q + min( D(i-1, j-1),  D(i-1, j) + p,  D(i, j-1) + p ),      DTW(a, b) = D(n-1, m-1),

with q = 1 or 2 and a penalty p for each step off the diagonal. A Sakoe-Chiba band of w samples [Sakoe1978] admits only
cells with |i - j| <= w (wider by the difference in length where n ≠ m). Without band and penalty the warp is free: DTW
then forgives any shift of a peak, however large.

Each cell depends on its neighbours, but the cells of different pairs of profiles do not, so several pairs are computed
side by side (`LANES`), in step. The compiler turns the innermost loop over lanes into vector instructions.
"""

from typing import Literal

import numba
import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError

LANES = 64  # ours: enough to hide the wait for the neighbouring cell; more gain nothing
Cost = Literal["absolute", "squared"]


def dtw(
    a: FloatArray,
    b: FloatArray,
    *,
    band: int | None = None,
    cost: Cost = "absolute",
    step_penalty: float = 0.0,
    per_step: bool = False,
) -> float:
    """DTW distance of two profiles.

    Args:
        a: First profile, shape (n,).
        b: Second profile, shape (m,).
        band: Half-width w of the Sakoe-Chiba band [samples]; None warps freely.
        cost: `"absolute"` (q = 1) or `"squared"` (q = 2; no square root is taken of the sum).
        step_penalty: p, cost of each step off the diagonal.
        per_step: Divide by the number of cells on the best path (the shortest of equally good ones); takes far longer.

    Raises:
        InputError: If a profile is empty or not one-dimensional, or an option is out of range.
    """
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    if a.ndim != 1 or b.ndim != 1:
        raise InputError(f"dtw: profiles must have one axis, got {a.ndim} and {b.ndim}", axes=(a.ndim, b.ndim))
    distances = dtw_matrix(a[None], b[None], band=band, cost=cost, step_penalty=step_penalty, per_step=per_step)
    return float(distances[0, 0])


def dtw_matrix(
    profiles_a: FloatArray,
    profiles_b: FloatArray | None = None,
    *,
    band: int | None = None,
    cost: Cost = "absolute",
    step_penalty: float = 0.0,
    per_step: bool = False,
) -> FloatArray:
    """DTW distance of every profile in A to every profile in B; options as in `dtw`.

    Args:
        profiles_a: One profile per row, shape (P, n).
        profiles_b: One profile per row, shape (Q, m); None compares A with itself, at half the work.
        band: See `dtw`.
        cost: See `dtw`.
        step_penalty: See `dtw`.
        per_step: See `dtw`.

    Returns:
        Distances, shape (P, Q); NaN for profiles that hold NaN.

    Raises:
        InputError: If profiles are empty or an option is out of range.
    """
    A = np.asarray(profiles_a, dtype=np.float64)
    B = A if profiles_b is None else np.asarray(profiles_b, dtype=np.float64)
    _check(A, B, band, cost, step_penalty)
    wanted = np.outer(np.isfinite(A).all(axis=1), np.isfinite(B).all(axis=1))
    pairs = np.argwhere(wanted if profiles_b is not None else np.triu(wanted))
    width = max(A.shape[1], B.shape[1]) if band is None else int(band)
    values = np.empty(len(pairs))
    for first in range(0, len(pairs), LANES):
        a, b = (np.ascontiguousarray(X[pairs[first : first + LANES, k]].T) for k, X in enumerate((A, B)))
        values[first : first + LANES] = _warp(a, b, width, cost == "squared", float(step_penalty), bool(per_step))
    distances = np.full((A.shape[0], B.shape[0]), np.nan)
    distances[pairs[:, 0], pairs[:, 1]] = values
    if profiles_b is None:
        distances[pairs[:, 1], pairs[:, 0]] = values
    return distances


def _check(A: FloatArray, B: FloatArray, band: int | None, cost: str, step_penalty: float) -> None:
    if A.ndim != 2 or B.ndim != 2 or A.shape[1] == 0 or B.shape[1] == 0:
        raise InputError(f"dtw: need profiles of shape (P, n > 0), got {A.shape} and {B.shape}", got=(A.shape, B.shape))
    if cost not in ("absolute", "squared"):
        raise InputError(f"dtw: unknown cost {cost!r} (known: absolute, squared)", cost=cost)
    if band is not None and band < 0:
        raise InputError(f"dtw: the band is {band} samples wide, must be >= 0", band=band)
    if not step_penalty >= 0.0:
        raise InputError(f"dtw: the step penalty is {step_penalty}, must be >= 0", step_penalty=step_penalty)


@numba.njit(cache=True)
def _warp(a: FloatArray, b: FloatArray, band: int, squared: bool, penalty: float, per_step: bool) -> FloatArray:
    """DTW of a[:, l] and b[:, l] for each lane l; D[j + 1] holds D(i, j) of the current row i, replaced in place."""
    n, m, lanes = a.shape[0], b.shape[0], a.shape[1]
    below, above = band + max(0, n - m), band + max(0, m - n)
    D, steps = np.full((m + 1, lanes), np.inf), np.zeros((m + 1, lanes))
    D[0] = 0.0  # the empty path, D(-1, -1)
    for i in range(n):
        span = max(0, i - below), min(m, i + above + 1)
        if per_step:
            _fill_row_counted(a[i], b, D, steps, span, squared, penalty)
        else:
            _fill_row(a[i], b, D, span, squared, penalty)
    return D[m] / steps[m] if per_step else D[m]


@numba.njit(cache=True)
def _fill_row(
    a: FloatArray, b: FloatArray, D: FloatArray, span: tuple[int, int], squared: bool, penalty: float
) -> None:
    """Replace D(i-1, j) by D(i, j) for j in the span; `a` is sample i of each lane."""
    lo, end = span
    diagonal = D[lo].copy()
    D[lo] = np.inf
    for j in range(lo, end):
        for lane in range(a.size):
            gap = a[lane] - b[j, lane]
            local = gap * gap if squared else abs(gap)
            above = D[j + 1, lane]
            D[j + 1, lane] = local + min(diagonal[lane], min(above, D[j, lane]) + penalty)
            diagonal[lane] = above


@numba.njit(cache=True)
def _fill_row_counted(
    a: FloatArray,
    b: FloatArray,
    D: FloatArray,
    steps: FloatArray,
    span: tuple[int, int],
    squared: bool,
    penalty: float,
) -> None:
    """The same, with the cells on the best path to each cell; the fewest where several paths are equally good."""
    lo, end = span
    diagonal, diagonal_steps = D[lo].copy(), steps[lo].copy()
    D[lo] = np.inf
    for j in range(lo, end):
        for lane in range(a.size):
            gap = a[lane] - b[j, lane]
            local = gap * gap if squared else abs(gap)
            left, above, corner = D[j, lane] + penalty, D[j + 1, lane] + penalty, diagonal[lane]
            best = min(corner, left, above)
            count = diagonal_steps[lane] if corner == best else np.inf
            count = min(count, steps[j, lane] if left == best else np.inf)
            count = min(count, steps[j + 1, lane] if above == best else np.inf)
            diagonal[lane], diagonal_steps[lane] = D[j + 1, lane], steps[j + 1, lane]
            D[j + 1, lane], steps[j + 1, lane] = local + best, 1.0 + count
