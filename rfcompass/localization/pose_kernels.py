"""Compiled half-plane intersections: the positions that rows allow at one orientation, or over a range of them."""

import numba
import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray


@numba.njit(cache=True, error_model="numpy")
def _clip(polygon: FloatArray, count: int, normal: FloatArray, room: float, scratch: FloatArray) -> int:
    """Cut the first `count` vertices with normal · p <= room, in place; returns the new count."""
    outside = False
    for v in range(count):
        excess = normal[0] * polygon[v, 0] + normal[1] * polygon[v, 1] - room
        scratch[v, 2] = excess
        outside |= excess > 0.0
    if not outside:
        return count
    kept = 0
    for v in range(count):
        w = v + 1 if v + 1 < count else 0
        here, there = scratch[v, 2], scratch[w, 2]
        if here <= 0.0:
            scratch[kept, :2] = polygon[v]
            kept += 1
        if here * there < 0.0:
            scratch[kept, :2] = polygon[v] + here / (here - there) * (polygon[w] - polygon[v])
            kept += 1
    polygon[:kept] = scratch[:kept, :2]
    return kept


@numba.njit(cache=True, error_model="numpy")
def _cut_box(A: FloatArray, room: FloatArray, bounds: FloatArray, polygon: FloatArray, scratch: FloatArray) -> int:
    """Intersect the bounds with all rows A[:, :2] · p <= room; returns the number of vertices."""
    for corner in range(4):
        polygon[corner, 0] = bounds[0, 1 if corner in (1, 2) else 0]
        polygon[corner, 1] = bounds[1, 1 if corner >= 2 else 0]
    count = 4
    for m in range(A.shape[0]):
        count = _clip(polygon, count, A[m], room[m], scratch)
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
def ranges_alive(A: FloatArray, b: FloatArray, bounds: FloatArray, middle: FloatArray, half: float) -> BoolArray:
    """Tell for which ranges middle ± half of θ some position might meet the rows; False is certain.

    Over a range, a row's term g(θ) = A₃ cos θ + A₄ sin θ is at least g - |g'| half - |A₃, A₄| half² / 2.
    """
    alive = np.zeros(middle.size, dtype=np.bool_)
    polygon, scratch = np.empty((A.shape[0] + 5, 2)), np.empty((A.shape[0] + 5, 3))
    swing = np.hypot(A[:, 2], A[:, 3]) * half * half / 2.0
    for t in range(middle.size):
        c, s = np.cos(middle[t]), np.sin(middle[t])
        least = A[:, 2] * c + A[:, 3] * s - np.abs(A[:, 3] * c - A[:, 2] * s) * half - swing
        alive[t] = _cut_box(A, b - least, bounds, polygon, scratch) > 0
    return alive


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
