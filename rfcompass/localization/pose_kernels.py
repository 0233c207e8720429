"""Compiled half-plane intersections: the positions that rows allow at one orientation, or over a range of them."""

import numba
import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray


@numba.njit(cache=True, error_model="numpy")
def clip(polygon: FloatArray, count: int, A: FloatArray, m: int, room: float, scratch: FloatArray) -> int:
    """Cut the first `count` vertices with A[m, :2] · p <= room, in place; returns the new count.

    Element by element, since slices of a few numbers cost more than the numbers. A polygon without area has fewer
    than three vertices.
    """
    outside = False
    for v in range(count):
        excess = A[m, 0] * polygon[v, 0] + A[m, 1] * polygon[v, 1] - room
        scratch[v, 2] = excess
        outside |= excess > 0.0
    if not outside:
        return count
    kept = 0
    for v in range(count):
        w = v + 1 if v + 1 < count else 0
        here, there = scratch[v, 2], scratch[w, 2]
        if here <= 0.0:
            scratch[kept, 0], scratch[kept, 1] = polygon[v, 0], polygon[v, 1]
            kept += 1
        if here * there < 0.0:
            share = here / (here - there)
            scratch[kept, 0] = polygon[v, 0] + share * (polygon[w, 0] - polygon[v, 0])
            scratch[kept, 1] = polygon[v, 1] + share * (polygon[w, 1] - polygon[v, 1])
            kept += 1
    copy_vertices(scratch, kept, polygon)
    return kept


@numba.njit(cache=True, error_model="numpy")
def copy_vertices(source: FloatArray, count: int, target: FloatArray) -> None:
    """Copy the first `count` vertices."""
    for v in range(count):
        target[v, 0], target[v, 1] = source[v, 0], source[v, 1]


@numba.njit(cache=True, error_model="numpy")
def fill_rectangle(bounds: FloatArray, polygon: FloatArray) -> int:
    """Fill in the corners of [[xmin, xmax], [ymin, ymax]], counter-clockwise; returns their number."""
    for corner in range(4):
        polygon[corner, 0] = bounds[0, 1 if corner in (1, 2) else 0]
        polygon[corner, 1] = bounds[1, 1 if corner >= 2 else 0]
    return 4


@numba.njit(cache=True, error_model="numpy")
def _cut_box(A: FloatArray, room: FloatArray, bounds: FloatArray, polygon: FloatArray, scratch: FloatArray) -> int:
    """Intersect the bounds with all rows A[:, :2] · p <= room; returns the number of vertices."""
    count = fill_rectangle(bounds, polygon)
    for m in range(A.shape[0]):
        count = clip(polygon, count, A, m, room[m], scratch)
        if count < 3:
            return 0
    return count


@numba.njit(cache=True, error_model="numpy")
def slices(A: FloatArray, b: FloatArray, bounds: FloatArray, theta: FloatArray) -> tuple[FloatArray, IntArray]:
    """Positions that meet A [x, y, cos θ, sin θ] <= b, for each θ.

    Returns:
        Vertices, counter-clockwise, shape (T, V, 2), and how many of them count, shape (T,).
    """
    size = A.shape[0] + 5
    vertices, counts = np.zeros((theta.size, size, 2)), np.zeros(theta.size, dtype=np.int64)
    scratch = np.empty((size, 3))
    for t in range(theta.size):
        room = b - A[:, 2] * np.cos(theta[t]) - A[:, 3] * np.sin(theta[t])
        counts[t] = _cut_box(A, room, bounds, vertices[t], scratch)
    return vertices, counts


@numba.njit(cache=True, error_model="numpy")
def ranges_alive(
    A: FloatArray, b: FloatArray, bounds: FloatArray, middle: FloatArray, half: float
) -> tuple[BoolArray, FloatArray]:
    """Tell for which ranges middle ± half of θ some position might meet the rows; False is certain.

    Over a range, a row's term g(θ) = A₃ cos θ + A₄ sin θ is at least g - |g'| half - |A₃, A₄| half² / 2.

    Returns:
        Whether each range is alive, shape (T,), and a rectangle that holds the positions of all that are.
    """
    alive, size = np.zeros(middle.size, dtype=np.bool_), A.shape[0] + 5
    polygon, scratch, swing = np.empty((size, 2)), np.empty((size, 3)), np.hypot(A[:, 2], A[:, 3]) * half * half / 2.0
    box = bounds[:, ::-1].copy()
    for t in range(middle.size):
        c, s = np.cos(middle[t]), np.sin(middle[t])
        count = fill_rectangle(bounds, polygon)
        for m in range(A.shape[0]):
            turn = abs(A[m, 3] * c - A[m, 2] * s) * half + swing[m]
            count = clip(polygon, count, A, m, b[m] - A[m, 2] * c - A[m, 3] * s + turn, scratch)
            if count < 3:
                break
        if count >= 3:
            alive[t] = True
            _grow(box, polygon, count)
    return alive, box


@numba.njit(cache=True, error_model="numpy")
def _grow(box: FloatArray, polygon: FloatArray, count: int) -> None:
    """Let a rectangle hold the first `count` vertices as well."""
    for v in range(count):
        for axis in range(2):
            box[axis, 0] = min(box[axis, 0], polygon[v, axis])
            box[axis, 1] = max(box[axis, 1], polygon[v, axis])


@numba.njit(cache=True, error_model="numpy")
def can_break(A: FloatArray, b: FloatArray, bounds: FloatArray, middle: FloatArray, half: float) -> BoolArray:
    """Tell which rows some pose in the bounds and the ranges middle ± half of θ might break; False is certain."""
    out, c, s = np.zeros(b.size, dtype=np.bool_), np.cos(middle), np.sin(middle)
    for m in range(b.size):
        most = max(A[m, 0] * bounds[0, 0], A[m, 0] * bounds[0, 1]) + max(A[m, 1] * bounds[1, 0], A[m, 1] * bounds[1, 1])
        swing = np.hypot(A[m, 2], A[m, 3]) * half * half / 2.0
        for t in range(middle.size):
            turn = A[m, 2] * c[t] + A[m, 3] * s[t] + abs(A[m, 3] * c[t] - A[m, 2] * s[t]) * half + swing
            if most + turn > b[m]:
                out[m] = True
                break
    return out


@numba.njit(cache=True, error_model="numpy")
def moments(vertices: FloatArray, counts: IntArray) -> FloatArray:
    """Integrals of 1, x, y, x², x y, y² over each polygon, as a fan of triangles; shape (T, 6)."""
    out = np.zeros((counts.size, 6))
    for t in range(counts.size):
        p = vertices[t, : counts[t]]
        for v in range(1, counts[t] - 1):
            twice = (p[v, 0] - p[0, 0]) * (p[v + 1, 1] - p[0, 1]) - (p[v + 1, 0] - p[0, 0]) * (p[v, 1] - p[0, 1])
            x, y = p[0, 0] + p[v, 0] + p[v + 1, 0], p[0, 1] + p[v, 1] + p[v + 1, 1]
            xx = p[0, 0] ** 2 + p[v, 0] ** 2 + p[v + 1, 0] ** 2 + x * x
            yy = p[0, 1] ** 2 + p[v, 1] ** 2 + p[v + 1, 1] ** 2 + y * y
            xy = p[0, 0] * p[0, 1] + p[v, 0] * p[v, 1] + p[v + 1, 0] * p[v + 1, 1] + x * y
            out[t] += twice * np.array([0.5, x / 6.0, y / 6.0, xx / 24.0, xy / 24.0, yy / 24.0])
    return out


@numba.njit(cache=True, error_model="numpy")
def lower_chain(points: FloatArray) -> IntArray:
    """Which points form the lower side of the convex hull, of points in ascending order of x, then y."""
    chain, size = np.empty(len(points), dtype=np.int64), 0
    for p in range(len(points)):
        while size > 1 and _turn(points, chain[size - 2], chain[size - 1], p) <= 0.0:
            size -= 1
        chain[size] = p
        size += 1
    return chain[:size]


@numba.njit(cache=True, error_model="numpy")
def _turn(points: FloatArray, a: int, b: int, c: int) -> float:
    x, y = points[a, 0], points[a, 1]
    return (points[b, 0] - x) * (points[c, 1] - y) - (points[b, 1] - y) * (points[c, 0] - x)
