"""From the maps of several part tags to the pose of the part: branch and bound over (x, y, θ), compiled.

The part is rigid, so with the log density M_k of the place of tag k, a point of the part, the hub, at p, and the tags
at levers l_k from it,

    log density(p, θ) = Σ_k M_k(p + R(θ) l_k).

A cell of poses moves tag k by at most ρ_k = √2 h + |l_k| h_θ from where its middle puts it. All cells of one size share
these ρ_k, so that each map is widened once, to the largest value within ρ_k, and then judges a cell with one look.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.localization.tag_kernels import effective_count

OUTSIDE = float(np.log(1e-6))  # log density [1/m²] beyond a map: the floor of `tag_maps`
FIRST_CELLS = 16  # along x and y at most, and over the circle
LEAST_LEVER_M = 1e-6


class MapStack(NamedTuple):
    """Maps of K tags in one array.

    Attributes:
        values: All maps, one after the other.
        shapes: [offset, X, Y] of each map, shape (K, 3).
        first_m: Place of each map's first point [m], shape (K, 2).
        pitch_m: Pitch of each map [m], shape (K,).
        top: Largest value of each map, shape (K,).
        levers_m: Place of each tag in the part frame, from the hub [m], shape (K, 2).
        hub_m: The hub in the part frame [m], shape (2,).
    """

    values: FloatArray
    shapes: IntArray
    first_m: FloatArray
    pitch_m: FloatArray
    top: FloatArray
    levers_m: FloatArray
    hub_m: FloatArray


def stack_maps(
    maps: Sequence[FloatArray], first_m: Sequence[FloatArray], pitch_m: Sequence[float], points_m: FloatArray
) -> MapStack:
    """Put the maps of all tags together.

    Args:
        maps: Log density of each tag's place, shapes (X_k, Y_k).
        first_m: Place of each map's first point [m].
        pitch_m: Pitch of each map [m].
        points_m: Tags in the part frame [m], shape (K, 2); the hub is their mean.
    """
    offsets = np.cumsum([0, *(one.size for one in maps)])
    shapes = np.array([(offset, *one.shape) for offset, one in zip(offsets, maps, strict=False)], dtype=np.int64)
    hub_m = points_m.mean(axis=0)
    return MapStack(
        np.concatenate([one.ravel() for one in maps]), shapes, np.array(first_m), np.array(pitch_m),
        np.array([one.max() for one in maps]), points_m - hub_m, hub_m,
    )  # fmt: skip


@numba.njit(cache=True, error_model="numpy")
def map_value(stack: MapStack, k: int, x: float, y: float) -> float:
    """Log density of tag k at a place, interpolated."""
    X, Y = stack.shapes[k, 1], stack.shapes[k, 2]
    u = (x - stack.first_m[k, 0]) / stack.pitch_m[k]
    v = (y - stack.first_m[k, 1]) / stack.pitch_m[k]
    i, j = int(np.floor(u)), int(np.floor(v))
    if i < 0 or j < 0 or i >= X - 1 or j >= Y - 1:
        return OUTSIDE
    at, fu, fv = stack.shapes[k, 0] + i * Y + j, u - i, v - j
    low = (1.0 - fv) * stack.values[at] + fv * stack.values[at + 1]
    high = (1.0 - fv) * stack.values[at + Y] + fv * stack.values[at + Y + 1]
    return (1.0 - fu) * low + fu * high


@numba.njit(cache=True, error_model="numpy")
def _trailing_maximum(rows: FloatArray, length: int) -> None:
    """Replace each row by the maximum of itself and the length - 1 rows before it, in place."""
    width = 1
    while width < length:
        step = min(width, length - width)
        for a in range(rows.shape[0] - 1, step - 1, -1):
            for b in range(rows.shape[1]):
                rows[a, b] = max(rows[a, b], rows[a - step, b])
        width += step


@numba.njit(cache=True, error_model="numpy")
def widened(level: FloatArray, reach: int) -> FloatArray:
    """Largest value of a map near each of its squares, and of those beyond its border.

    Args:
        level: The map, shape (X, Y).
        reach: R, how far "near" is, in steps of the map.

    Returns:
        In row i + R + 1 the largest value of rows i - R to i + R + 1, and likewise along y; shape
        (X + 2 R + 1, Y + 2 R + 1).
    """
    pad = 2 * reach + 1
    turned = np.full((level.shape[1] + pad, level.shape[0]), OUTSIDE)
    turned[: level.shape[1]] = level.T
    _trailing_maximum(turned, pad + 1)
    out = np.full((level.shape[0] + pad, turned.shape[0]), OUTSIDE)
    out[: level.shape[0]] = turned.T
    _trailing_maximum(out, pad + 1)
    return out


@numba.njit(cache=True, error_model="numpy")
def _widened_stack(stack: MapStack, half: FloatArray) -> tuple[FloatArray, IntArray]:
    """All maps, widened by how far a cell moves their tags; and [offset, X, Y, R] of each."""
    K = stack.levers_m.shape[0]
    table = np.empty((K, 4), dtype=np.int64)
    size = 0
    for k in range(K):
        rho = np.sqrt(2.0) * half[0] + np.hypot(stack.levers_m[k, 0], stack.levers_m[k, 1]) * half[1]
        reach = int(np.ceil(rho / stack.pitch_m[k] + 1e-9))
        table[k] = size, stack.shapes[k, 1] + 2 * reach + 1, stack.shapes[k, 2] + 2 * reach + 1, reach
        size += table[k, 1] * table[k, 2]
    flat = np.empty(size)
    for k in range(K):
        offset, X, Y = stack.shapes[k]
        level = stack.values[offset : offset + X * Y].reshape(X, Y)
        flat[table[k, 0] : table[k, 0] + table[k, 1] * table[k, 2]] = widened(level, table[k, 3]).ravel()
    return flat, table


@numba.njit(cache=True, error_model="numpy")
def pose_log_density(stack: MapStack, x: float, y: float, theta: float) -> float:
    """Log density where the hub lies at (x, y) and the part is turned by θ."""
    c, s = np.cos(theta), np.sin(theta)
    total = 0.0
    for k in range(stack.levers_m.shape[0]):
        lx, ly = stack.levers_m[k, 0], stack.levers_m[k, 1]
        total += map_value(stack, k, x + c * lx - s * ly, y + s * lx + c * ly)
    return total


@numba.njit(cache=True, error_model="numpy")
def _outside(stack: MapStack, cell: FloatArray, bounds_m: FloatArray, slack: float) -> bool:
    """Whether the part's centre lies out of bounds by more than a slack."""
    c, s = np.cos(cell[2]), np.sin(cell[2])
    x = cell[0] - c * stack.hub_m[0] + s * stack.hub_m[1]
    y = cell[1] - s * stack.hub_m[0] - c * stack.hub_m[1]
    return (
        x < bounds_m[0, 0] - slack or x > bounds_m[0, 1] + slack
        or y < bounds_m[1, 0] - slack or y > bounds_m[1, 1] + slack
    )  # fmt: skip


@numba.njit(cache=True, error_model="numpy")
def _values(stack: MapStack, cells: FloatArray, bounds_m: FloatArray) -> FloatArray:
    """Log density in the middle of each cell, -inf where the centre is out of bounds, shape (C,)."""
    value = np.empty(cells.shape[0])
    for n in range(cells.shape[0]):
        outside = _outside(stack, cells[n], bounds_m, 0.0)
        value[n] = -np.inf if outside else pose_log_density(stack, cells[n, 0], cells[n, 1], cells[n, 2])
    return value


@numba.njit(cache=True, error_model="numpy")
def _alive(stack: MapStack, cells: FloatArray, half: FloatArray, bounds_m: FloatArray, least: float) -> FloatArray:
    """Cells in which the log density may reach a value within the bounds; tags not yet looked at count as best."""
    flat, table = _widened_stack(stack, half)
    slack = np.sqrt(2.0) * half[0] + np.hypot(stack.hub_m[0], stack.hub_m[1]) * half[1]
    kept, n, every = np.empty_like(cells), 0, stack.top.sum()
    for cell in cells:
        if _outside(stack, cell, bounds_m, slack):
            continue
        c, s, bound = np.cos(cell[2]), np.sin(cell[2]), every
        for k in range(table.shape[0]):
            lx, ly = stack.levers_m[k, 0], stack.levers_m[k, 1]
            u = (cell[0] + c * lx - s * ly - stack.first_m[k, 0]) / stack.pitch_m[k]
            v = (cell[1] + s * lx + c * ly - stack.first_m[k, 1]) / stack.pitch_m[k]
            i, j = int(np.floor(u)) + table[k, 3] + 1, int(np.floor(v)) + table[k, 3] + 1
            inside = 0 <= i < table[k, 1] and 0 <= j < table[k, 2]
            bound += (flat[table[k, 0] + i * table[k, 2] + j] if inside else OUTSIDE) - stack.top[k]
            if bound < least:
                break
        if bound >= least:
            kept[n] = cell
            n += 1
    return kept[:n]


@numba.njit(cache=True, error_model="numpy")
def split_cells(cells: FloatArray, half: FloatArray, turn: bool) -> FloatArray:
    """Halve the range of θ of each cell, or quarter its square."""
    ways = 2 if turn else 4
    out = np.empty((ways * cells.shape[0], 3))
    for n in range(cells.shape[0]):
        for way in range(ways):
            out[ways * n + way] = cells[n]
            if turn:
                out[ways * n + way, 2] += (way - 0.5) * half[1]
            else:
                out[ways * n + way, 0] += ((way & 1) - 0.5) * half[0]
                out[ways * n + way, 1] += ((way >> 1) - 0.5) * half[0]
    return out


@numba.njit(cache=True, error_model="numpy")
def _hub_box(stack: MapStack, bounds_m: FloatArray) -> FloatArray:
    """Rectangle of all places of the hub that the map of any tag and the bounds allow, shape (2, 2).

    Of any, not of all: a tag whose fix is altogether wrong must not hide where the others agree.
    """
    box = np.array([[np.inf, -np.inf], [np.inf, -np.inf]])
    lever = np.hypot(stack.hub_m[0], stack.hub_m[1])
    for k in range(stack.levers_m.shape[0]):
        reach = np.hypot(stack.levers_m[k, 0], stack.levers_m[k, 1])
        for axis in range(2):
            last = stack.first_m[k, axis] + (stack.shapes[k, 1 + axis] - 1) * stack.pitch_m[k]
            box[axis, 0] = min(box[axis, 0], stack.first_m[k, axis] - reach)
            box[axis, 1] = max(box[axis, 1], last + reach)
    for axis in range(2):
        box[axis, 0] = max(box[axis, 0], bounds_m[axis, 0] - lever)
        box[axis, 1] = min(box[axis, 1], bounds_m[axis, 1] + lever)
    return box


@numba.njit(cache=True, error_model="numpy")
def _first_cells(stack: MapStack, bounds_m: FloatArray, lever: float) -> tuple[FloatArray, FloatArray]:
    """Squares wherever the hub may lie, times ranges of θ over the circle; and their half sizes.

    Sides are powers of two, so that cells of several searches can be brought to one size.
    """
    box = _hub_box(stack, bounds_m)
    extent_x, extent_y = max(box[0, 1] - box[0, 0], 0.0), max(box[1, 1] - box[1, 0], 0.0)
    side = 2.0 ** np.ceil(np.log2(max(extent_x, extent_y, 1e-9) / FIRST_CELLS))
    turns = FIRST_CELLS if lever > LEAST_LEVER_M else 1
    nx, ny = int(np.ceil(extent_x / side)), int(np.ceil(extent_y / side))
    half = np.array([side / 2.0, np.pi / turns])
    cells = np.empty((nx * ny * turns, 3))
    for n in range(cells.shape[0]):
        cells[n, 0] = box[0, 0] + side * (n // (ny * turns) + 0.5)
        cells[n, 1] = box[1, 0] + side * (n // turns % ny + 0.5)
        cells[n, 2] = -np.pi + (2.0 * (n % turns) + 1.0) * half[1]
    return cells, half


@numba.njit(cache=True, error_model="numpy")
def centred(hubs: FloatArray, hub_m: FloatArray) -> FloatArray:
    """Poses (x, y, θ) of the part, θ in [-π, π), from places of its hub and θ [m, m, rad], shape (C, 3)."""
    poses = np.empty_like(hubs)
    for n in range(hubs.shape[0]):
        c, s = np.cos(hubs[n, 2]), np.sin(hubs[n, 2])
        poses[n, 0] = hubs[n, 0] - c * hub_m[0] + s * hub_m[1]
        poses[n, 1] = hubs[n, 1] - s * hub_m[0] - c * hub_m[1]
        poses[n, 2] = (hubs[n, 2] + np.pi) % (2.0 * np.pi) - np.pi
    return poses


@numba.njit(cache=True, error_model="numpy")
def rigid_start(stack: MapStack, but: int = -1) -> FloatArray:
    """Pose of the hub that fits the best place of each tag, by least squares; see `geometry.registration`, shape (3,).

    Args:
        stack: Maps of the tags.
        but: A tag to leave out; -1 for none.
    """
    K, weight = stack.levers_m.shape[0], np.ones(stack.levers_m.shape[0])
    if but >= 0:
        weight[but] = 0.0
    weight /= weight.sum()
    tops = np.empty((K, 2))
    for k in range(K):
        offset, X, Y = stack.shapes[k, 0], stack.shapes[k, 1], stack.shapes[k, 2]
        at = stack.values[offset : offset + X * Y].argmax()
        tops[k, 0] = stack.first_m[k, 0] + stack.pitch_m[k] * (at // Y)
        tops[k, 1] = stack.first_m[k, 1] + stack.pitch_m[k] * (at % Y)
    x, y = (weight * tops[:, 0]).sum(), (weight * tops[:, 1]).sum()
    mx, my = (weight * stack.levers_m[:, 0]).sum(), (weight * stack.levers_m[:, 1]).sum()
    lx, ly = stack.levers_m[:, 0] - mx, stack.levers_m[:, 1] - my
    cross = (weight * (lx * (tops[:, 1] - y) - ly * (tops[:, 0] - x))).sum()
    dot = (weight * (lx * (tops[:, 0] - x) + ly * (tops[:, 1] - y))).sum()
    theta = np.arctan2(cross, dot)
    c, s = np.cos(theta), np.sin(theta)
    return np.array([x - c * mx + s * my, y - s * mx - c * my, theta])


@numba.njit(cache=True, error_model="numpy")
def _start_value(stack: MapStack, bounds_m: FloatArray) -> float:
    """Log density of a good pose: a rigid fit of all tags, or of all but one, whose fix may be altogether wrong.

    It only has to be good: a log density found early saves the search of all that lies far below it.
    """
    K = stack.levers_m.shape[0]
    starts = np.empty((K + 1 if K > 2 else 1, 3))
    for n in range(starts.shape[0]):
        starts[n] = rigid_start(stack, n - 1)
    return _values(stack, starts, bounds_m).max()


@numba.njit(cache=True, error_model="numpy")
def pose_cells(
    stack: MapStack, bounds_m: FloatArray, limits: FloatArray, max_cells: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Cells that hold all but a negligible share of the pose's probability.

    Args:
        stack: Maps of the tags.
        bounds_m: Where the part's centre may lie [m], [[xmin, xmax], [ymin, ymax]].
        limits: [how far below the best a log density may lie, over how many cells it must spread, smallest and largest
            side of a cell [m]].
        max_cells: Do not split into more cells than this.

    Returns:
        Cells (place of the hub and θ), shape (C, 3), log density there, shape (C,), and half sizes [m, rad], shape
        (2,). C = 0 if the maps and the bounds have nothing in common.
    """
    lever = np.hypot(stack.hub_m[0], stack.hub_m[1])
    for k in range(stack.levers_m.shape[0]):
        lever = max(lever, np.hypot(stack.levers_m[k, 0], stack.levers_m[k, 1]))
    cells, half = _first_cells(stack, bounds_m, lever)
    best = _start_value(stack, bounds_m)
    while True:
        # Middles of large cells say little: a good start prunes as well as they do.
        fine = half[0] <= 0.5 * limits[3]
        value = _values(stack, cells, bounds_m) if fine or best == -np.inf else np.full(cells.shape[0], -np.inf)
        best = max(best, value.max()) if value.size else best
        enough = fine and best > -np.inf and effective_count(value) >= limits[1]
        if enough or half[0] <= 0.5 * limits[2] or value.size == 0:
            break
        alive = _alive(stack, cells, half, bounds_m, best - limits[0])
        turn = lever > LEAST_LEVER_M and lever * half[1] > np.sqrt(2.0) * half[0]
        if (2 if turn else 4) * alive.shape[0] > max_cells:
            value = _values(stack, cells, bounds_m)
            break
        cells = split_cells(alive, half, turn)
        half[1 if turn else 0] /= 2.0
    top = value.max() if value.size else -np.inf
    kept: IntArray = np.flatnonzero((value >= top - limits[0]) & (value > -np.inf))
    return cells[kept], value[kept], half
