"""Where one part tag can be, by its own distances or comparisons: branch and bound over the plane, compiled.

A square cell with middle p and half diagonal ρ is judged by the log likelihood in its middle and by a bound on the
log likelihood anywhere in it. A distance r to an anchor adds, with d = |p - a|, u² = (r - d)² / s² and
s² = α² + β² d² + v (Student-4, without constants),

    log L = -5/2 log(1 + u² / 4) - 1/2 log s² = -5/2 log(s² + (r - d)² / 4) + 2 log s².

In the cell d moves by at most ρ, the first term falls with s² and the second rises, so that the smallest |r - d|,
the smallest s² in the first and the largest in the second term bound it. A comparison "nearer to i than to j" adds
γ log(λ/2 + (1 - λ) / (1 + exp(-(d_j - d_i) / s))), and in the cell d_j - d_i moves by at most
ρ min(2, 2 |a_i - a_j| / (d_i + d_j - 2ρ)), because directions to two points differ by at most twice their distance
over the sum of their ranges [DunklWilliams1964].

Tables: a distance is [a_x, a_y, a_z - z, r, α², β², v, w, c_x, c_y], where the variance that odometry adds is
v + w |p - c|²; a comparison is [i_x, i_y, i_z - z, j_x, j_y, j_z - z, |a_i - a_j|, s², λ, γ, v, w, c_x, c_y], where
odometry adds (v + w |p - c|²) |û_i - û_j|² to s², û being the directions to the anchors.
"""

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray

RANGE_COLUMNS = 10
COMPARISON_COLUMNS = 14
_BATCH = 16  # factors multiplied before a logarithm is taken


@numba.njit(cache=True, error_model="numpy")
def range_log_likelihood(rows: FloatArray, x: float, y: float, rho: float) -> tuple[float, float]:
    """Log likelihood of distances in the middle of a cell, and its bound over the cell."""
    value, bound = 0.0, 0.0
    near, scale, near_bound, scale_bound = 1.0, 1.0, 1.0, 1.0
    for n in range(rows.shape[0]):
        dx, dy = x - rows[n, 0], y - rows[n, 1]
        d = np.sqrt(dx * dx + dy * dy + rows[n, 2] ** 2)
        lever = np.sqrt((x - rows[n, 8]) ** 2 + (y - rows[n, 9]) ** 2)
        miss = abs(rows[n, 3] - d)
        s2 = rows[n, 4] + rows[n, 5] * d * d + rows[n, 6] + rows[n, 7] * lever * lever
        near *= s2 + 0.25 * miss * miss
        scale *= s2
        if rho > 0.0:
            least, least_d, least_l = max(miss - rho, 0.0), max(d - rho, 0.0), max(lever - rho, 0.0)
            fixed = rows[n, 4] + rows[n, 6]
            low = fixed + rows[n, 5] * least_d * least_d + rows[n, 7] * least_l * least_l
            high = fixed + rows[n, 5] * (d + rho) ** 2 + rows[n, 7] * (lever + rho) ** 2
            near_bound *= low + 0.25 * least * least
            scale_bound *= high
        if n % _BATCH == _BATCH - 1 or n == rows.shape[0] - 1:
            value += 2.0 * np.log(scale) - 2.5 * np.log(near)
            bound += 2.0 * np.log(scale_bound) - 2.5 * np.log(near_bound)
            near, scale, near_bound, scale_bound = 1.0, 1.0, 1.0, 1.0
    return value, bound


@numba.njit(cache=True, error_model="numpy")
def comparison_log_likelihood(rows: FloatArray, x: float, y: float, rho: float) -> tuple[float, float]:
    """Log likelihood of comparisons in the middle of a cell, and its bound over the cell; γ is the same in all rows."""
    value, bound, wins, may_win = 0.0, 0.0, 1.0, 1.0
    for n in range(rows.shape[0]):
        ix, iy, jx, jy = x - rows[n, 0], y - rows[n, 1], x - rows[n, 3], y - rows[n, 4]
        di = np.sqrt(ix * ix + iy * iy + rows[n, 2] ** 2) + 1e-9
        dj = np.sqrt(jx * jx + jy * jy + rows[n, 5] ** 2) + 1e-9
        s2, lapse = rows[n, 7], rows[n, 8]
        odometry = rows[n, 10] + rows[n, 11] * ((x - rows[n, 12]) ** 2 + (y - rows[n, 13]) ** 2)
        if odometry > 0.0:
            s2 += odometry * ((ix / di - jx / dj) ** 2 + (iy / di - jy / dj) ** 2)
        s = np.sqrt(s2)
        wins *= 0.5 * lapse + (1.0 - lapse) / (1.0 + np.exp((di - dj) / s))
        if rho > 0.0:
            slope = min(2.0, 2.0 * rows[n, 6] / max(di + dj - 2.0 * rho, 1e-9))
            best = (dj - di + rho * slope) / (s if dj - di + rho * slope < 0.0 else np.sqrt(rows[n, 7]))
            may_win *= 0.5 * lapse + (1.0 - lapse) / (1.0 + np.exp(-best))
        if n % _BATCH == _BATCH - 1 or n == rows.shape[0] - 1:
            value += rows[n, 9] * np.log(wins)
            bound += rows[n, 9] * np.log(may_win)
            wins, may_win = 1.0, 1.0
    return value, bound


@numba.njit(cache=True, error_model="numpy")
def _judge(ranges: bool, rows: FloatArray, cells: FloatArray, half: float, scores: FloatArray) -> None:
    """Fill in log likelihood and bound of each cell, shape (C, 2)."""
    rho = half * np.sqrt(2.0)
    for c in range(cells.shape[0]):
        if ranges:
            scores[c, 0], scores[c, 1] = range_log_likelihood(rows, cells[c, 0], cells[c, 1], rho)
        else:
            scores[c, 0], scores[c, 1] = comparison_log_likelihood(rows, cells[c, 0], cells[c, 1], rho)


@numba.njit(cache=True, error_model="numpy")
def _split(cells: FloatArray, half: float) -> FloatArray:
    """Quarter each cell."""
    quarter = np.empty((4 * cells.shape[0], 2))
    for c in range(cells.shape[0]):
        for q in range(4):
            quarter[4 * c + q, 0] = cells[c, 0] + (half if q & 1 else -half) / 2.0
            quarter[4 * c + q, 1] = cells[c, 1] + (half if q & 2 else -half) / 2.0
    return quarter


@numba.njit(cache=True, error_model="numpy")
def effective_count(log_weight: FloatArray) -> float:
    """(Σ w)² / Σ w²: over how many cells the weight is spread."""
    total, squares, top = 0.0, 0.0, log_weight.max()
    for value in log_weight:
        w = np.exp(value - top)
        total += w
        squares += w * w
    return total * total / squares


@numba.njit(cache=True, error_model="numpy")
def _first_cells(bounds_m: FloatArray, half: float) -> FloatArray:
    nx = int(np.ceil((bounds_m[0, 1] - bounds_m[0, 0]) / (2.0 * half) - 1e-9))
    ny = int(np.ceil((bounds_m[1, 1] - bounds_m[1, 0]) / (2.0 * half) - 1e-9))
    cells = np.empty((nx * ny, 2))
    for i in range(nx):
        for j in range(ny):
            cells[i * ny + j, 0] = bounds_m[0, 0] + (2 * i + 1) * half
            cells[i * ny + j, 1] = bounds_m[1, 0] + (2 * j + 1) * half
    return cells


@numba.njit(cache=True, error_model="numpy")
def tag_cells(
    ranges: bool, rows: FloatArray, bounds_m: FloatArray, limits: FloatArray, max_cells: int
) -> tuple[FloatArray, FloatArray, float]:
    """Cells that hold all but a negligible share of a tag's likelihood.

    Args:
        ranges: Whether the rows are distances or comparisons.
        rows: Table of this tag, shape (M, RANGE_COLUMNS) or (M, COMPARISON_COLUMNS).
        bounds_m: Where the tag may be [m], [[xmin, xmax], [ymin, ymax]].
        limits: [side of the first cells, smallest side [m], how far below the best a bound may lie, least spread].
        max_cells: Do not split more cells than a quarter of this.

    Returns:
        Middles of the cells [m], shape (C, 2), the log likelihood there, shape (C,), and the side of a cell [m].
    """
    half = limits[0] / 2.0
    cells = _first_cells(bounds_m, half)
    scores = np.empty((cells.shape[0], 2))
    _judge(ranges, rows, cells, half, scores)
    while True:
        kept: IntArray = np.flatnonzero(scores[:, 1] >= scores[:, 0].max() - limits[2])
        cells, scores = cells[kept], scores[kept]
        enough = 2.0 * half <= limits[0] / 8.0 and effective_count(scores[:, 0]) >= limits[3]
        if half <= limits[1] or 4 * cells.shape[0] > max_cells or enough:
            return cells, scores[:, 0].copy(), 2.0 * half
        cells = _split(cells, half)
        half /= 2.0
        scores = np.empty((cells.shape[0], 2))
        _judge(ranges, rows, cells, half, scores)
