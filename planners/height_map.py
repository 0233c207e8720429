"""Heights of what a depth view shows, on a grid over the table: what a hand from straight above can run into."""

from dataclasses import dataclass

import numba
import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView
from rfcompass.types.record import Record

# Ours. A pixel covers this much more than its own square, so that rounding leaves no seams; how far a cell looks for
# neighbours that were seen, and how many it needs; what the map reaches beyond the points that stand on the table [m].
_SEAM, _REACH_M, _NEIGHBOURS, _MARGIN_M = 1.1, 0.06, 2, 0.08
_MOST_CELLS = 25_000_000  # ours: such a map takes 0.4 GB


@dataclass(frozen=True, slots=True)
class HeightMap(Record):
    """Height of the highest surface seen over each cell of the table.

    Attributes:
        corner_m: Middle of the first cell, x and y in the world [m], shape (2,).
        cell_m: Edge of a cell [m].
        heights_m: Height in the world [m], infinite where nothing is known, shape (X, Y).
        seen: Whether a pixel showed it; the other heights are guesses, shape (X, Y).
    """

    corner_m: FloatArray
    cell_m: float
    heights_m: FloatArray
    seen: BoolArray

    def __post_init__(self) -> None:
        """Freeze the arrays; a height is a number or infinite, never NaN."""
        object.__setattr__(self, "corner_m", read_only(self.corner_m, "HeightMap.corner_m", (2,)))
        heights_m = read_only(self.heights_m, "HeightMap.heights_m", (None, None), finite=False)
        object.__setattr__(self, "heights_m", heights_m)
        object.__setattr__(self, "seen", read_only(self.seen, "HeightMap.seen", heights_m.shape, np.bool_))
        if not self.cell_m > 0:
            raise ShapeError(f"HeightMap.cell_m: {self.cell_m} is not positive", name="cell_m")
        if np.isnan(heights_m).any():
            raise ShapeError("HeightMap.heights_m: holds NaN", name="heights_m")


def height_map(view: DepthView, standing: BoolArray, cell_m: float = 0.0025) -> HeightMap | None:
    """Map what a view shows about what stands on the table.

    1. Each pixel raises the cells that its own square covers to the height that it shows.
    2. A cell that no pixel covers lies behind an edge, or its pixel was lost. Along both axes the nearest cells that
       were seen are looked for, 6 cm to each side; with two or more of them it takes the lowest. Behind an edge that is
       the ground, as if sides were upright; within a surface it is the surface. With fewer it is unknown.

    Args:
        view: A depth image.
        standing: Pixels above the table, shape (H, W).
        cell_m: Edge of a cell; ours [m].

    Returns:
        The map of 8 cm about them; None if there are none.

    Raises:
        InputError: If there would be too many cells.
    """
    points_m = points_image(view)
    if not standing.any():
        return None
    low_m = points_m[standing, :2].min(axis=0) - _MARGIN_M
    high_m = points_m[standing, :2].max(axis=0) + _MARGIN_M
    counts = np.ceil((high_m - low_m) / cell_m) + 1
    if (cells := float(counts.prod())) > _MOST_CELLS:
        across_m = (high_m - low_m).round(2).tolist()
        message = f"a height map of {across_m} m in cells of {cell_m} m has {cells:.3g}; more than {_MOST_CELLS:.3g}"
        raise InputError(f"{message} are refused", cells=cells, most=_MOST_CELLS, cell_m=cell_m)
    raw_m = np.full(counts.astype(int), -np.inf)
    K = view.intrinsics
    half = _SEAM * 0.5 / min(K[0, 0], K[1, 1])
    _raise_cells(raw_m, points_m, view.depth_m * half, low_m, cell_m)
    return HeightMap(low_m, cell_m, _filled(raw_m, round(_REACH_M / cell_m), _NEIGHBOURS), raw_m > -np.inf)


@numba.njit(cache=True)
def _raise_cells(
    heights_m: FloatArray, points_m: FloatArray, half_m: FloatArray, corner_m: FloatArray, cell_m: float
) -> None:
    """Raise the cells that each point's square covers; heights (X, Y), points (H, W, 3), half edges (H, W) [m]."""
    X, Y = heights_m.shape
    for v in range(points_m.shape[0]):
        for u in range(points_m.shape[1]):
            x, y, z = points_m[v, u]
            if np.isnan(z):
                continue
            half, i, j = half_m[v, u] / cell_m, (x - corner_m[0]) / cell_m, (y - corner_m[1]) / cell_m
            # At least the cell that holds the point.
            first_i, last_i = min(np.ceil(i - half), np.floor(i + 0.5)), max(np.floor(i + half), np.floor(i + 0.5))
            first_j, last_j = min(np.ceil(j - half), np.floor(j + 0.5)), max(np.floor(j + half), np.floor(j + 0.5))
            for a in range(max(0, int(first_i)), min(X - 1, int(last_i)) + 1):
                for b in range(max(0, int(first_j)), min(Y - 1, int(last_j)) + 1):
                    heights_m[a, b] = max(heights_m[a, b], z)


@numba.njit(cache=True)
def _filled(raw_m: FloatArray, reach: int, needed: int) -> FloatArray:
    """Give cells of -inf the lowest of their nearest neighbours along the axes, or inf; shape (X, Y)."""
    X, Y = raw_m.shape
    heights_m = raw_m.copy()
    for i in range(X):
        for j in range(Y):
            if raw_m[i, j] != -np.inf:
                continue
            lowest, found = np.inf, 0
            for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                seen = _next_seen(raw_m, i, j, (di, dj), reach)
                if seen != -np.inf:
                    lowest, found = min(lowest, seen), found + 1
            heights_m[i, j] = lowest if found >= needed else np.inf
    return heights_m


@numba.njit(cache=True)
def _next_seen(raw_m: FloatArray, i: int, j: int, step: tuple[int, int], reach: int) -> float:
    """Height of the next cell that was seen in a direction, -inf if there is none within reach."""
    for n in range(1, reach + 1):
        a, b = i + n * step[0], j + n * step[1]
        if not (0 <= a < raw_m.shape[0] and 0 <= b < raw_m.shape[1]):
            break
        if raw_m[a, b] != -np.inf:
            return float(raw_m[a, b])
    return -np.inf
