"""How much of the map comes to light when an object goes, by depth; ours.

Eq. 4 asks whether the middle of the target lies under an object. But one sees a target as soon as some of it is
uncovered, and a target under the border of two objects is found by taking either. So each column stands for a disc
as large as the target. The share w of the disc that lies under an object says whether taking it shows enough to
recognise the target: min(1, w / enough).
"""

import numba
import numpy as np

from planners.extraction.projection import MaskColumns, check_same_columns
from rfcompass.arrays import FloatArray, IntArray
from rfcompass.types import VoxelGrid


def mass_by_depth(
    grid: VoxelGrid, columns: MaskColumns, labels: IntArray, half_m: float, radius_m: float, enough: float
) -> FloatArray:
    """Share of the map that lies at each depth under each object and would show if the object went.

    Args:
        grid: Where the middle of the target may be; values below 0 count as 0.
        columns: The columns under each mask.
        labels: Which masks, shape (K,).
        half_m: From the target's middle up to its top [m].
        radius_m: Of the disc [m].
        enough: Share of the disc that has to be seen, in (0, 1].

    Returns:
        Mass at depths of 0, 1, ... voxels of the target's top under the surface. One row for each label; an object's
        row does not exceed the map's sum, 1; rows of neighbours share mass. All 0 for an empty map. Shape (K, D).

    Raises:
        ShapeError: If the columns are those of another map.
    """
    check_same_columns(grid, columns)
    positive = np.maximum(grid.values, 0.0)
    total = float(positive.sum())
    group = np.full(columns.owner.shape, -1, dtype=np.int64)
    for k, label in enumerate(labels):
        group[columns.owner == label] = k
    surface = (columns.surface_m - grid.origin_m[2] - half_m) / grid.spacing_m
    depths = grid.values.shape[2] + int(np.ceil(max(np.nanmax(surface, initial=0.0), 0.0))) + 1
    mass = np.zeros((len(labels), depths))
    values, disc = positive / max(total, 1e-300), _disc(radius_m / grid.spacing_m)
    _spread(mass, values, group, surface, disc, (enough, half_m / grid.spacing_m))
    return mass


def _disc(radius: float) -> IntArray:
    """Offsets of the columns whose middles lie within a radius [voxel], shape (N, 2)."""
    n = int(radius)
    offsets = np.argwhere(np.ones((2 * n + 1, 2 * n + 1), dtype=bool)) - n
    return np.asarray(offsets[(offsets**2).sum(axis=1) <= radius**2 + 1e-9])


@numba.njit(cache=True)
def _spread(
    mass: FloatArray,
    values: FloatArray,
    group: IntArray,
    surface: FloatArray,
    disc: IntArray,
    rules: tuple[float, float],
) -> None:
    """Give each voxel's value to all objects over its disc; surface in voxels, less the target's half height.

    The rules are the share that is enough, and the half height in voxels.
    """
    count, height = np.zeros(len(mass)), np.zeros(len(mass))
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            if values[i, j].max() <= 0.0:
                continue
            _look_around(count, height, group, surface, disc, i, j)
            for k in np.flatnonzero(count):
                seen = min(1.0, count[k] / len(disc) / rules[0])
                _drop(mass[k], values[i, j], seen, height[k] / count[k], rules[1])
                count[k], height[k] = 0.0, 0.0


@numba.njit(cache=True)
def _look_around(
    count: FloatArray, height: FloatArray, group: IntArray, surface: FloatArray, disc: IntArray, i: int, j: int
) -> None:
    """Count the columns of each object about a column, and add up their heights."""
    for n in range(len(disc)):
        a, b = i + disc[n, 0], j + disc[n, 1]
        if 0 <= a < group.shape[0] and 0 <= b < group.shape[1] and group[a, b] >= 0:
            count[group[a, b]] += 1.0
            height[group[a, b]] += surface[a, b]


@numba.njit(cache=True)
def _drop(row: FloatArray, values: FloatArray, seen: float, surface: float, half: float) -> None:
    """Add a column's values to a row, each at its depth under the surface; what is above that lies under nothing."""
    for z in range(len(values)):
        if values[z] > 0.0 and z <= surface + half:
            row[max(int(np.floor(surface - z + 0.5)), 0)] += seen * values[z]
