"""Voxels as coloured points: which are worth showing, and in which colour."""

from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.types.piles import VoxelGrid
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class VoxelPoints(Record):
    """Some voxels of a map.

    Attributes:
        points_m: Their centres [m], shape (P, 3).
        values: Their values, shape (P,).
        rgb: Their colours in [0, 1], shape (P, 3).
        count: How many there are, with those that were left out because they were too many.
    """

    points_m: FloatArray
    values: FloatArray
    rgb: FloatArray
    count: int

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "points_m", read_only(self.points_m, "VoxelPoints.points_m", (None, 3)))
        object.__setattr__(self, "values", read_only(self.values, "VoxelPoints.values", (None,)))
        object.__setattr__(self, "rgb", read_only(self.rgb, "VoxelPoints.rgb", (None, 3)))


def voxel_points(grid: VoxelGrid, share: float = 0.05, most: int | None = None) -> VoxelPoints:
    """Choose the voxels whose size is at least a share of the largest, in the order of the grid.

    Args:
        grid: The map; zeros are never shown.
        share: Least size, as a share of the largest, in [0, 1].
        most: Keep only so many, the largest; all if None.

    Raises:
        InputError: If the share is none, or `most` is below 1.
    """
    if not 0.0 <= share <= 1.0 or (most is not None and most < 1):
        raise InputError(f"share {share}, most {most}: out of range", share=share, most=most)
    sizes = np.abs(grid.values)
    top = float(sizes.max())
    chosen = np.flatnonzero((sizes > 0) & (sizes >= share * top))
    count = chosen.size
    if most is not None and count > most:
        chosen = np.sort(chosen[np.argsort(-sizes.ravel()[chosen], kind="stable")[:most]])
    voxels = np.column_stack(np.unravel_index(chosen, grid.values.shape))
    values = grid.values.ravel()[chosen]
    return VoxelPoints(grid.origin_m + grid.spacing_m * voxels, values, value_rgb(values, top), count)


def value_rgb(values: FloatArray, top: float) -> FloatArray:
    """Colours of values between -top and top: blue below zero, white at zero, red above, as in the paper's figures.

    Args:
        values: Shape (P,).
        top: Size of the strongest colour.

    Returns:
        Red, green, blue in [0, 1], shape (P, 3).
    """
    place = 0.5 + 0.5 * values / top if top > 0 else np.full(values.shape, 0.5)
    return np.asarray(colormaps["RdBu_r"](place)[:, :3])
