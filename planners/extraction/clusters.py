"""Which part of the map to move above [Boroushaki2023], section 5.

The paper clusters the occupancy distribution and selects "the area with the highest average probability", without
saying how. Ours: columns whose sum over z is above a share of the largest one; those that touch are one cluster.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from rfcompass.arrays import BoolArray, FloatArray, read_only
from rfcompass.errors import InputError, NothingHidden
from rfcompass.types import VoxelGrid
from rfcompass.types.record import Record

THRESHOLD = 0.3  # ours


@dataclass(frozen=True, slots=True)
class Cluster(Record):
    """A connected part of the map, seen from above.

    Attributes:
        point_m: Above the middle of its mass, at the height of its top, in the world [m], shape (3,).
        columns: Its columns, shape (X, Y).
        mass: Sum of the map over them.
    """

    point_m: FloatArray
    columns: BoolArray
    mass: float

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "point_m", read_only(self.point_m, "Cluster.point_m", (3,)))
        object.__setattr__(self, "columns", read_only(self.columns, "Cluster.columns", (None, None), np.bool_))

    @property
    def mean(self) -> float:
        """Mean of the columns' sums: the paper's "average probability"."""
        return self.mass / float(self.columns.sum())


def best_cluster(grid: VoxelGrid, threshold: float = THRESHOLD) -> Cluster:
    """Find the cluster with the highest mean, as the paper does.

    Args:
        grid: How likely the target is in each voxel.
        threshold: Columns count from this share of the largest column on.

    Raises:
        NothingHidden: If the map is nowhere above 0.
        InputError: If the threshold is not in [0, 1).
    """
    return max(clusters_of(grid, threshold), key=lambda cluster: cluster.mean)


def highest_voxel_m(grid: VoxelGrid) -> FloatArray:
    """Middle of the likeliest voxel, the first of equals, in the world [m], shape (3,)."""
    at = np.unravel_index(int(grid.values.argmax()), grid.values.shape)
    return grid.origin_m + grid.spacing_m * np.array(at)


def clusters_of(grid: VoxelGrid, threshold: float = THRESHOLD) -> tuple[Cluster, ...]:
    """Cut a map into clusters; arguments and errors as for `best_cluster`."""
    if not 0 <= threshold < 1:
        raise InputError(f"threshold {threshold} is not in [0, 1)", got=threshold)
    sums = grid.values.sum(axis=2)
    if not sums.max(initial=0.0) > 0:
        voxels = grid.values.size
        raise NothingHidden(f"none of the {voxels} voxels of the map can hold the target", voxels=voxels)
    parts, count = ndimage.label(sums > threshold * sums.max(), structure=np.ones((3, 3)))
    return tuple(_clusters(grid, sums, parts, count, threshold))


def _clusters(grid: VoxelGrid, sums: FloatArray, parts: FloatArray, count: int, threshold: float) -> Iterator[Cluster]:
    for number in range(1, count + 1):
        columns = parts == number
        where, weights = np.argwhere(columns), sums[columns]
        layers = grid.values[columns].max(axis=0)
        top = int(np.flatnonzero(layers >= threshold * layers.max())[-1])
        at = np.append(weights @ where / weights.sum(), top + 0.5)
        yield Cluster(grid.origin_m + grid.spacing_m * at, columns, float(weights.sum()))
