"""The smallest convex region of highest density that holds a given share of the probability, compiled."""

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray

_BISECTIONS = 16
_EDGE = 1e-9


@numba.njit(cache=True, error_model="numpy")
def spread_on_grid(points_m: FloatArray, weight: FloatArray, pitch_m: float) -> tuple[FloatArray, FloatArray]:
    """Share the weight of each point among the four nearest points of a grid.

    Args:
        points_m: Points [m], shape (C, 2).
        weight: Their weights, shape (C,).
        pitch_m: Pitch of the grid [m].

    Returns:
        Weight on the grid, shape (X, Y), with an empty margin, and the place of its first point [m], shape (2,).
    """
    first = np.array([points_m[:, 0].min() - 2.0 * pitch_m, points_m[:, 1].min() - 2.0 * pitch_m])
    X = int((points_m[:, 0].max() - first[0]) / pitch_m) + 3
    Y = int((points_m[:, 1].max() - first[1]) / pitch_m) + 3
    grid = np.zeros((X, Y))
    for n in range(weight.size):
        u, v = (points_m[n, 0] - first[0]) / pitch_m, (points_m[n, 1] - first[1]) / pitch_m
        i, j = int(u), int(v)
        fu, fv = u - i, v - j
        grid[i, j] += weight[n] * (1.0 - fu) * (1.0 - fv)
        grid[i + 1, j] += weight[n] * fu * (1.0 - fv)
        grid[i, j + 1] += weight[n] * (1.0 - fu) * fv
        grid[i + 1, j + 1] += weight[n] * fu * fv
    return grid, first


@numba.njit(cache=True, error_model="numpy")
def _cross(a: FloatArray, b: FloatArray, p: FloatArray) -> float:
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


@numba.njit(cache=True, error_model="numpy")
def _hull(points: FloatArray) -> FloatArray:
    """Convex hull of points sorted by x, then y [Andrew1979], counter-clockwise."""
    chain, n = np.empty((2 * len(points) + 1, 2)), 0
    for start, step in ((0, 1), (len(points) - 1, -1)):
        floor = n + 1
        for count in range(len(points)):
            p = points[start + step * count]
            while n > floor and _cross(chain[n - 2], chain[n - 1], p) <= 0.0:
                n -= 1
            chain[n] = p
            n += 1
        n -= 1
    return chain[:n].copy()


@numba.njit(cache=True, error_model="numpy")
def _hull_of_top(grid: FloatArray, level: float, extra: FloatArray) -> FloatArray:
    """Hull of all grid squares with at least this weight and of one more point, in grid units."""
    points, n = np.empty((4 * grid.shape[0] + 1, 2)), 0
    for i in range(grid.shape[0]):
        top = np.flatnonzero(grid[i] >= level)
        if top.size == 0:
            continue
        for side in (-0.5, 0.5):
            points[n] = i + side, top[0] - 0.5
            points[n + 1] = i + side, top[-1] + 0.5
            n += 2
    points[n] = extra
    found = points[: n + 1]
    order = np.argsort(found[:, 1], kind="mergesort")
    found = found[order]
    return _hull(found[np.argsort(found[:, 0], kind="mergesort")])


@numba.njit(cache=True, error_model="numpy")
def _weight_inside(grid: FloatArray, hull: FloatArray) -> float:
    """Weight of all grid points inside a convex hull; those on its border do not count."""
    total = 0.0
    for i in range(grid.shape[0]):
        low, high = -1.0, float(grid.shape[1])
        for e in range(len(hull)):
            a, b = hull[e], hull[(e + 1) % len(hull)]
            dx, offset = b[0] - a[0], (b[1] - a[1]) * (i - a[0])
            if dx > 0.0:
                low = max(low, a[1] + offset / dx)
            elif dx < 0.0:
                high = min(high, a[1] + offset / dx)
            elif (b[1] - a[1]) * (i - a[0]) > 0.0:
                high = -1.0
        if low <= high:
            for j in range(int(np.floor(low + _EDGE)) + 1, int(np.ceil(high - _EDGE))):
                total += grid[i, j]
    return total


@numba.njit(cache=True, error_model="numpy")
def credible_polygon(grid: FloatArray, share: float, extra: FloatArray) -> FloatArray:
    """Hull of the squares of highest weight, just so many that it holds the share.

    Args:
        grid: Weight on a grid, shape (X, Y).
        share: Share of the weight to hold.
        extra: A point that must lie in it too, in grid units, shape (2,).

    Returns:
        Corners in grid units, counter-clockwise, shape (V, 2).
    """
    weights = np.sort(grid.ravel())[::-1]
    weights = weights[weights > 0.0]
    low, high = 0, weights.size - 1
    held = share * weights.sum()
    for _ in range(_BISECTIONS):
        middle = (low + high) // 2
        if _weight_inside(grid, _hull_of_top(grid, weights[middle], extra)) >= held:
            high = middle
        else:
            low = middle + 1
        if low >= high:
            break
    return _hull_of_top(grid, weights[high], extra)


@numba.njit(cache=True, error_model="numpy")
def component_weights(grid: FloatArray, level: float) -> FloatArray:
    """Weight of each connected set of grid points above a level, largest first, shape (C,)."""
    open_: IntArray = (grid >= level).astype(np.int64)
    stack = np.empty((grid.size, 2), dtype=np.int64)
    weights = []
    for i in range(grid.shape[0]):
        for j in range(grid.shape[1]):
            if open_[i, j] == 0:
                continue
            weights.append(_flood(grid, open_, stack, i, j))
    return np.sort(np.array(weights))[::-1]


@numba.njit(cache=True, error_model="numpy")
def _flood(grid: FloatArray, open_: IntArray, stack: IntArray, i: int, j: int) -> float:
    """Weight of one connected set, which is closed on the way."""
    total, n = 0.0, 1
    stack[0], open_[i, j] = (i, j), 0
    while n > 0:
        n -= 1
        x, y = stack[n]
        total += grid[x, y]
        for step in range(9):
            a, b = x + step // 3 - 1, y + step % 3 - 1
            if 0 <= a < grid.shape[0] and 0 <= b < grid.shape[1] and open_[a, b]:
                open_[a, b] = 0
                stack[n] = a, b
                n += 1
    return total
