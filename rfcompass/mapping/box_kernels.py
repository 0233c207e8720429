"""A box that lies on a side, in each of its orientations, as shares of voxels."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.mapping.item_occupancy import lying_rotations
from rfcompass.types.record import Record

_FINE_M = 0.25  # of a voxel, between the points that stand for the box
_LEAST = 4  # points along an edge


@dataclass(frozen=True, slots=True)
class BoxKernel(Record):
    """One orientation of a box.

    Attributes:
        values: Share of the box in each voxel; its middle is the middle of the middle voxel; sums to 1.
        half_height_m: From its middle down to its lowest point [m].
    """

    values: FloatArray
    half_height_m: float

    def __post_init__(self) -> None:
        """Freeze the values."""
        object.__setattr__(self, "values", read_only(self.values, "BoxKernel.values", (None, None, None)))


def box_kernels(size_m: FloatArray, spacing_m: float, yaws: int) -> tuple[BoxKernel, ...]:
    """All orientations of a box: each edge upright, with yaws over half a turn.

    Args:
        size_m: Its edges [m], shape (3,).
        spacing_m: Edge of a voxel [m].
        yaws: Yaws for each edge upright.
    """
    upright = np.repeat(np.arange(3), yaws)
    rotations = lying_rotations(np.pi * np.tile(np.arange(yaws) / yaws, 3), upright)
    return tuple(BoxKernel(_shares(size_m, R, spacing_m), float(np.abs(R[2]) @ size_m / 2)) for R in rotations)


def _shares(size_m: FloatArray, R: FloatArray, spacing_m: float) -> FloatArray:
    """Share of a turned box in each voxel, by points spread evenly in it, shape (2a + 1, 2b + 1, 2c + 1)."""
    counts = np.maximum(np.ceil(size_m / (_FINE_M * spacing_m)).astype(int), _LEAST)
    axes = [(np.arange(n) + 0.5) / n * edge - edge / 2 for n, edge in zip(counts, size_m, strict=True)]
    points_m = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3) @ R.T
    reach = np.ceil(np.abs(R) @ size_m / 2 / spacing_m + 0.5).astype(int)
    voxels = np.floor(points_m / spacing_m + 0.5).astype(int) + reach
    shape = tuple(2 * reach + 1)
    flat = np.ravel_multi_index(tuple(voxels.T), shape)
    return np.bincount(flat, minlength=int(np.prod(shape))).reshape(shape) / len(points_m)
