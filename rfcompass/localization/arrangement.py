"""The deepest cells of half-planes: all sets of comparisons that one position meets and no position outnumbers.

For one part tag at the part's centre each comparison is a half-plane n · p <= β, and their borders cut the plane
into cells, each of which meets one set of them. A cell that meets the most touches at least one border from
inside, unless no border crosses the bounds at all. So it is enough to walk along every border: between two
crossings with others the cells beside it meet the same half-planes all the way. That takes O(M² log M) steps and
is exact; cells thinner than some nanometres do not count, nor do crossings of borders without a cell.

Few borders come near the best cells. Before the walk the rectangle is narrowed: cut it into tiles, drop those in
which even all half-planes that are not broken everywhere are fewer than some tile's middle meets, go on with the
rectangle about the rest.
"""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray

_TILES = 12  # along each side (this and the next three are ours)
_MAX_ROUNDS = 20
_SHRINK = 0.5  # go on while the area falls below this share
_THIN_M = 1e-9  # pieces of border below this length, and distances between borders, are rounding


class DeepestCells(NamedTuple):
    """What an arrangement holds at most.

    Attributes:
        met: Largest number of half-planes that any position meets.
        sets: Which ones, for each cell that reaches `met`, shape (C, M).
        complete: Whether these are all such cells; there may be more than were asked for.
    """

    met: int
    sets: BoolArray
    complete: bool


class _Cells(NamedTuple):
    """The deepest cells so far."""

    facts: IntArray  # largest number met, number of cells, number of cells that found no room; shape (3,)
    keys: IntArray  # fingerprint of each cell's set, shape (C,)
    sets: BoolArray  # shape (C, m)


def deepest_cells(normals: FloatArray, beta_m: FloatArray, bounds_m: FloatArray, max_cells: int = 64) -> DeepestCells:
    """Find all cells of an arrangement of half-planes that meet the most of them.

    Args:
        normals: Unit normals n, or zero for a half-plane that is everything (β >= 0) or nothing, shape (M, 2).
        beta_m: Right-hand sides β of n · p <= β [m], shape (M,).
        bounds_m: Rectangle [m], [[xmin, xmax], [ymin, ymax]].
        max_cells: How many cells to keep.
    """
    bounds_m = _narrow(normals, beta_m, bounds_m)
    middle_m, half_m = bounds_m.mean(axis=1), np.ptp(bounds_m, axis=1) / 2.0
    value, reach = normals @ middle_m - beta_m, np.abs(normals) @ half_m
    crossing = np.flatnonzero((np.abs(value) < reach) & (reach > 0.0))
    everywhere = value <= -reach
    facts, keys = np.zeros(3, dtype=np.int64), np.zeros(max_cells, dtype=np.int64)
    cells = _Cells(facts, keys, np.zeros((max_cells, crossing.size), dtype=np.bool_))
    prints = np.random.default_rng(0).integers(-(2**62), 2**62, crossing.size)
    _walk(np.ascontiguousarray(normals[crossing]), beta_m[crossing], bounds_m, prints, cells)
    count = max(int(facts[1]), 1)  # where no border crosses, the one cell meets what is met everywhere
    sets = np.repeat(everywhere[None], count, axis=0)
    sets[:, crossing] = cells.sets[:count]
    return DeepestCells(int(sets[0].sum()), sets, not facts[2])


def _narrow(normals: FloatArray, beta_m: FloatArray, bounds_m: FloatArray) -> FloatArray:
    """Shrink the rectangle about all positions that may meet the most half-planes."""
    for _ in range(_MAX_ROUNDS):
        smaller = _shrink(normals, beta_m, bounds_m)
        done = np.prod(np.ptp(smaller, axis=1)) > _SHRINK * np.prod(np.ptp(bounds_m, axis=1))
        bounds_m = smaller
        if done:
            break
    return bounds_m


@numba.njit(cache=True, error_model="numpy")
def _shrink(normals: FloatArray, beta: FloatArray, bounds: FloatArray) -> FloatArray:
    """Rectangle about the tiles whose bound reaches the best tile middle."""
    met, bound = np.zeros((_TILES, _TILES), dtype=np.int64), np.zeros((_TILES, _TILES), dtype=np.int64)
    side = (bounds[:, 1] - bounds[:, 0]) / _TILES
    for m in range(beta.size):
        reach = (abs(normals[m, 0]) * side[0] + abs(normals[m, 1]) * side[1]) / 2.0
        for i in range(_TILES):
            x_part = normals[m, 0] * (bounds[0, 0] + (i + 0.5) * side[0]) - beta[m]
            for j in range(_TILES):
                value = x_part + normals[m, 1] * (bounds[1, 0] + (j + 0.5) * side[1])
                met[i, j] += value < -_THIN_M
                bound[i, j] += value <= reach + _THIN_M
    alive, most = np.zeros((2, _TILES), dtype=np.bool_), met.max()
    for i in range(_TILES):
        for j in range(_TILES):
            alive[0, i] |= bound[i, j] >= most
            alive[1, j] |= bound[i, j] >= most
    smaller = bounds.copy()
    for axis in range(2):
        kept = np.flatnonzero(alive[axis])
        smaller[axis, 0] = bounds[axis, 0] + kept[0] * side[axis]
        smaller[axis, 1] = bounds[axis, 0] + (kept[-1] + 1) * side[axis]
    return smaller


@numba.njit(cache=True, error_model="numpy")
def _inside(normal: FloatArray, foot: FloatArray, bounds: FloatArray) -> tuple[float, float]:
    """Between which t the border foot + t (-n_y, n_x) lies inside the rectangle; first above second if nowhere."""
    low, high = -np.inf, np.inf
    for axis in range(2):
        along = -normal[1] if axis == 0 else normal[0]
        if abs(along) < 1e-15:
            if not bounds[axis, 0] <= foot[axis] <= bounds[axis, 1]:
                return 1.0, 0.0
            continue
        first, last = (bounds[axis, 0] - foot[axis]) / along, (bounds[axis, 1] - foot[axis]) / along
        low, high = max(low, min(first, last)), min(high, max(first, last))
    return low, high


@numba.njit(cache=True, error_model="numpy")
def _cross(normals: FloatArray, beta: FloatArray, i: int, foot: FloatArray, at: FloatArray, turn: IntArray) -> None:
    """Where border i crosses each other one, and what changes there.

    Fills in the place t of each crossing and 1 if the other half-plane is entered with growing t, -1 if it is left.
    Parallel half-planes are crossed at -∞: entered if the inner side of border i is met by them, else left.
    """
    for j in range(beta.size):
        slope = normals[j, 1] * normals[i, 0] - normals[j, 0] * normals[i, 1]
        value = normals[j, 0] * foot[0] + normals[j, 1] * foot[1] - beta[j]
        if abs(slope) > 1e-9:
            at[j], turn[j] = -value / slope, (1 if slope < 0.0 else -1)
            continue
        same_way = normals[j, 0] * normals[i, 0] + normals[j, 1] * normals[i, 1] > 0.0
        at[j] = -np.inf
        turn[j] = 1 if value <= (_THIN_M if same_way else -_THIN_M) else -1


@numba.njit(cache=True, error_model="numpy")
def _keep(cells: _Cells, at: FloatArray, turn: IntArray, t: float, depth: int, prints: IntArray) -> None:
    """Keep the cell beside a border at t, if none that is known meets more or the same half-planes."""
    if depth > cells.facts[0]:
        cells.facts[0], cells.facts[1], cells.facts[2] = depth, 0, 0
    key = 0
    for j in range(at.size):
        if (at[j] < t) == (turn[j] > 0):
            key += prints[j]
    for known in range(cells.facts[1]):
        if cells.keys[known] == key:
            return
    if cells.facts[1] == cells.keys.size:
        cells.facts[2] += 1
        return
    for j in range(at.size):
        cells.sets[cells.facts[1], j] = (at[j] < t) == (turn[j] > 0)
    cells.keys[cells.facts[1]] = key
    cells.facts[1] += 1


@numba.njit(cache=True, error_model="numpy")
def _walk_border(at: FloatArray, turn: IntArray, low: float, high: float, prints: IntArray, cells: _Cells) -> None:
    """Walk along one border from t = low to high, and keep the deepest cells on its inner side."""
    depth, here = 0, low
    for j in range(at.size):
        depth += (at[j] <= low) == (turn[j] > 0)
    for j in np.argsort(at):
        if at[j] <= low:
            continue
        there = min(at[j], high)
        if there - here > _THIN_M and depth >= cells.facts[0]:
            _keep(cells, at, turn, (here + there) / 2.0, depth, prints)
        if at[j] >= high:
            return
        depth += turn[j]
        here = there
    if high - here > _THIN_M and depth >= cells.facts[0]:
        _keep(cells, at, turn, (here + high) / 2.0, depth, prints)


@numba.njit(cache=True, error_model="numpy")
def _walk(normals: FloatArray, beta: FloatArray, bounds: FloatArray, prints: IntArray, cells: _Cells) -> None:
    """Walk along every border."""
    count, foot = beta.size, np.empty(2)
    at, turn = np.empty(count), np.empty(count, dtype=np.int64)
    x, y = bounds[0].mean(), bounds[1].mean()
    for i in range(count):
        away = normals[i, 0] * x + normals[i, 1] * y - beta[i]
        foot[0], foot[1] = x - away * normals[i, 0], y - away * normals[i, 1]
        low, high = _inside(normals[i], foot, bounds)
        if high - low > _THIN_M:
            _cross(normals, beta, i, foot, at, turn)
            _walk_border(at, turn, low, high, prints, cells)
