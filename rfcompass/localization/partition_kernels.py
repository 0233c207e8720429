"""Numerical kernels of the partition: a small linear program and the analytic centre, compiled.

Both work on rows G y <= h of unit length, stored by column: G has shape (n, M), with n = 2 to 5 unknowns and M
rows. The linear program is solved by the primal-dual method of [Mehrotra1992]. A primal barrier method must not
look for the first feasible point here: it stalls on the border of the unit disc, where the true pose always lies.
"""

import numba
import numpy as np

from rfcompass.arrays import FloatArray

SOLVED, STALLED = 0, 1

_SUMS = {"reassoc", "contract"}  # lets sums run in vector registers; NaN keep their meaning
_RIDGE = 1e-15  # of the trace; keeps the factor of a nearly singular normal matrix from turning into NaN
_FULL_STEPS = 0.05  # squared Newton decrement below which full steps converge (a barrier is self-concordant)
_S, _DUAL, _TARGET, _DS, _D_DUAL, _WORK, _INVERSE = range(7)  # rows of the work array W, shape (7, M)


@numba.njit(cache=True, fastmath=_SUMS, error_model="numpy")
def _gram(G: FloatArray, w: FloatArray) -> FloatArray:
    """G diag(w) Gᵀ, shape (n, n)."""
    n, M = G.shape
    H = np.empty((n, n))
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for m in range(M):
                total += G[i, m] * G[j, m] * w[m]
            H[i, j] = total
            H[j, i] = total
    return H


@numba.njit(cache=True, fastmath=_SUMS, error_model="numpy")
def _dot(a: FloatArray, b: FloatArray) -> float:
    total = 0.0
    for m in range(a.size):
        total += a[m] * b[m]
    return total


@numba.njit(cache=True, error_model="numpy")
def _combine(G: FloatArray, w: FloatArray) -> FloatArray:
    """G w, shape (n,)."""
    out = np.empty(G.shape[0])
    for i in range(G.shape[0]):
        out[i] = _dot(G[i], w)
    return out


@numba.njit(cache=True, fastmath=_SUMS, error_model="numpy")
def _slacks(G: FloatArray, h: FloatArray, y: FloatArray, s: FloatArray) -> None:
    """Slacks s = h - Gᵀ y."""
    n, M = G.shape
    for m in range(M):
        s[m] = h[m]
    for i in range(n):
        y_i = y[i]
        for m in range(M):
            s[m] -= G[i, m] * y_i


@numba.njit(cache=True, error_model="numpy")
def _factor(H: FloatArray) -> FloatArray:
    """Cholesky factor of H plus a ridge, in place."""
    n, ridge = H.shape[0], _RIDGE * np.trace(H)
    for j in range(n):
        pivot = H[j, j] + ridge - _dot(H[j, :j], H[j, :j])
        H[j, j] = np.sqrt(max(pivot, ridge))
        for i in range(j + 1, n):
            H[i, j] = (H[i, j] - _dot(H[i, :j], H[j, :j])) / H[j, j]
    return H


@numba.njit(cache=True, error_model="numpy")
def _solve(L: FloatArray, rhs: FloatArray) -> FloatArray:
    """Solve L Lᵀ x = rhs."""
    n, x = L.shape[0], rhs.copy()
    for i in range(n):
        x[i] = (x[i] - _dot(L[i, :i], x[:i])) / L[i, i]
    for i in range(n - 1, -1, -1):
        x[i] = (x[i] - _dot(L[i + 1 :, i], x[i + 1 :])) / L[i, i]
    return x


@numba.njit(cache=True, fastmath=_SUMS, error_model="numpy")
def _newton_step(G: FloatArray, L: FloatArray, residual: FloatArray, W: FloatArray) -> FloatArray:
    """Step dy, ds, d_dual with Gᵀ dy + ds = 0, G d_dual = residual and s d_dual + dual ds = target."""
    dual, target, ds, d_dual, work, inverse = W[_DUAL], W[_TARGET], W[_DS], W[_D_DUAL], W[_WORK], W[_INVERSE]
    M = dual.size
    for m in range(M):
        work[m] = target[m] * inverse[m]
        ds[m] = 0.0
    dy = _solve(L, residual - _combine(G, work))
    _slacks(G, ds, dy, ds)
    for m in range(M):
        d_dual[m] = work[m] - dual[m] * ds[m] * inverse[m]
    return dy


@numba.njit(cache=True, fastmath=_SUMS | {"nnan", "nsz"}, error_model="numpy")
def _longest_step(value: FloatArray, change: FloatArray) -> float:
    """Longest step in [0, 1] that keeps value + step · change >= 0."""
    steepest = 1.0
    for m in range(value.size):
        steepest = max(steepest, -change[m] / value[m])
    return 1.0 / steepest


@numba.njit(cache=True, fastmath=_SUMS, error_model="numpy")
def _first_target(W: FloatArray) -> None:
    """Aim at s · dual = 0; also stores 1 / s, and the weights dual / s of the normal matrix."""
    s, dual, target, work, inverse = W[_S], W[_DUAL], W[_TARGET], W[_WORK], W[_INVERSE]
    for m in range(s.size):
        inverse[m] = 1.0 / s[m]
        work[m] = dual[m] * inverse[m]
        target[m] = -s[m] * dual[m]


@numba.njit(cache=True, fastmath=_SUMS, error_model="numpy")
def _second_target(W: FloatArray, gap: float) -> None:
    """Mehrotra's corrector: how far to centre is judged by how far the pure Newton step would come.

    The second-order term is damped where that step is short; undamped, the iteration can cycle.
    """
    s, dual, ds, d_dual, target = W[_S], W[_DUAL], W[_DS], W[_D_DUAL], W[_TARGET]
    primal, against = _longest_step(s, ds), _longest_step(dual, d_dual)
    left = 0.0
    for m in range(s.size):
        left += (s[m] + primal * ds[m]) * (dual[m] + against * d_dual[m])
    aim, damped = (left / gap) ** 3 * gap / s.size, primal * against
    for m in range(s.size):
        target[m] = aim - s[m] * dual[m] - damped * ds[m] * d_dual[m]


@numba.njit(cache=True, fastmath=_SUMS, error_model="numpy")
def _advance(W: FloatArray, shorten: float) -> float:
    """Take the step as far as s and dual stay positive; returns its length for y."""
    s, dual, ds, d_dual = W[_S], W[_DUAL], W[_DS], W[_D_DUAL]
    primal, against = shorten * _longest_step(s, ds), shorten * _longest_step(dual, d_dual)
    for m in range(s.size):
        s[m] += primal * ds[m]
        dual[m] += against * d_dual[m]
    return primal


@numba.njit(cache=True, error_model="numpy")
def maximise(
    G: FloatArray, h: FloatArray, c: FloatArray, start: FloatArray, tolerance: float
) -> tuple[FloatArray, int]:
    """Maximise c · y over Gᵀ y <= h, from a point strictly inside.

    With y* the optimum, c · (y* - y) <= gap + residual · (y* - y). Rounding keeps the residual of the dual from
    reaching zero in thin cells, but its product with what y still has to go, judged by the last step, does.

    Returns:
        The optimum to within `tolerance` of c · y, and SOLVED, or STALLED where it was not reached.
    """
    W, y = np.empty((7, h.size)), start.copy()
    s, dual = W[_S], W[_DUAL]
    _slacks(G, h, y, s)
    dual[:] = 1.0 / s
    dual /= dual.sum()
    last_step = np.inf
    for _ in range(60):
        residual, gap = c - _combine(G, dual), _dot(s, dual)
        if gap <= tolerance and np.abs(residual).sum() * last_step <= tolerance:
            return y, SOLVED
        _first_target(W)
        L = _factor(_gram(G, W[_WORK]))
        _newton_step(G, L, residual, W)
        _second_target(W, gap)
        dy = _newton_step(G, L, residual, W)
        y += _advance(W, min(max(0.9, 1.0 - gap), 0.9999)) * dy
        last_step = np.abs(dy).max()
    return y, STALLED


@numba.njit(cache=True, error_model="numpy")
def chebyshev(G: FloatArray, h: FloatArray, tolerance: float) -> tuple[FloatArray, float, int]:
    """Centre and radius of the largest ball in {Gᵀ y <= h}; the radius is negative if that set is empty.

    Maximise r, subject to Gᵀ y + r <= h: right because all columns of G have unit length. One row more keeps r
    above what it starts from; without it the program is open downwards, and open cells lead the solver astray.
    """
    n, M = G.shape
    with_radius = np.ones((n + 1, M + 1))
    with_radius[:n, :M] = G
    with_radius[:n, M] = 0.0
    with_radius[n, M] = -1.0
    start, c = np.zeros(n + 1), np.zeros(n + 1)
    start[n] = h.min() - 1.0
    c[n] = 1.0
    y, status = maximise(with_radius, np.append(h, 2.0 - h.min()), c, start, tolerance)
    return y[:n], float(y[n]), status


@numba.njit(cache=True, error_model="numpy")
def _barrier(s: FloatArray, y: FloatArray, disc: float) -> float:
    """-Σ log s - log(disc² - y₂² - y₃²), infinite outside; without the disc if its radius is 0."""
    room = disc * disc - y[2] * y[2] - y[3] * y[3] if disc > 0.0 else 1.0
    if s.min() <= 0.0 or room <= 0.0:
        return np.inf
    return -np.log(s).sum() - np.log(room)


@numba.njit(cache=True, error_model="numpy")
def _derivatives(G: FloatArray, s: FloatArray, y: FloatArray, disc: float) -> tuple[FloatArray, FloatArray]:
    """Gradient and Hessian of the barrier."""
    inverse = 1.0 / s
    gradient, H = _combine(G, inverse), _gram(G, inverse * inverse)
    if disc > 0.0:
        cs = y[2:4]
        room = disc * disc - _dot(cs, cs)
        gradient[2:4] += 2.0 * cs / room
        H[2:4, 2:4] += 4.0 * np.outer(cs, cs) / room**2 + 2.0 * np.eye(2) / room
    return gradient, H


@numba.njit(cache=True, error_model="numpy")
def _downhill(G: FloatArray, h: FloatArray, y: FloatArray, dy: FloatArray, slope: float, disc: float) -> float:
    """Step 1, 1/2, 1/4, ... that lowers the barrier by a tenth of what its slope promises; 0 if there is none."""
    s, step = np.empty(h.size), 1.0
    _slacks(G, h, y, s)
    value = _barrier(s, y, disc)
    while step > 1e-12:
        trial = y + step * dy
        _slacks(G, h, trial, s)
        if _barrier(s, trial, disc) <= value + 0.1 * step * slope:
            return step
        step *= 0.5
    return 0.0


@numba.njit(cache=True, error_model="numpy")
def analytic_centre(G: FloatArray, h: FloatArray, start: FloatArray, disc: float) -> tuple[FloatArray, int]:
    """Minimise -Σ log(h - Gᵀ y) - log(disc² - y₂² - y₃²) by Newton's method, from a point strictly inside.

    Args:
        G: Rows, shape (n, M).
        h: Right-hand sides, shape (M,).
        start: Point strictly inside rows and disc, shape (n,).
        disc: Radius of the disc of the last two of four unknowns, 0 for none.

    Returns:
        The centre, and SOLVED or STALLED.
    """
    y, s = start.copy(), np.empty(h.size)
    _slacks(G, h, y, s)
    last = np.inf
    for _ in range(200):
        gradient, H = _derivatives(G, s, y, disc)
        dy = -_solve(_factor(H), gradient)
        decrement = -_dot(gradient, dy)
        if decrement <= 1e-18 or (decrement < 1e-6 and decrement > 0.25 * last):
            return y, SOLVED
        step = 1.0 if decrement < _FULL_STEPS else _downhill(G, h, y, dy, -decrement, disc)
        if step == 0.0:
            return y, STALLED
        y += step * dy
        _slacks(G, h, y, s)
        last = decrement
    return y, STALLED
