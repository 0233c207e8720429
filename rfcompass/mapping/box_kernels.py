"""A box that lies on a side, in each of its orientations, as shares of voxels."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import fft

from rfcompass.arrays import FloatArray, read_only
from rfcompass.types.record import Record

_FINE_M = 0.25  # of a voxel, between the points that stand for the box
_LEAST = 4  # points along an edge


@dataclass(frozen=True, slots=True)
class BoxKernel(Record):
    """One orientation of a box; the share of a voxel is that of its column times that of its layer.

    Attributes:
        footprint: Share of the box in each column of voxels about its middle, shape (2a + 1, 2b + 1); sums to 1.
        profile: Share of the box in each layer about its middle, shape (2c + 1,); sums to 1.
        half_height_m: From its middle down to its lowest point [m].
    """

    footprint: FloatArray
    profile: FloatArray
    half_height_m: float

    def __post_init__(self) -> None:
        """Freeze the shares."""
        object.__setattr__(self, "footprint", read_only(self.footprint, "BoxKernel.footprint", (None, None)))
        object.__setattr__(self, "profile", read_only(self.profile, "BoxKernel.profile", (None,)))

    @property
    def values(self) -> FloatArray:
        """Share of the box in each voxel, shape (2a + 1, 2b + 1, 2c + 1); sums to 1."""
        return self.footprint[:, :, None] * self.profile


def box_kernels(size_m: FloatArray, spacing_m: float, yaws: int) -> tuple[BoxKernel, ...]:
    """All orientations of a box: each edge upright, with yaws over half a turn.

    Args:
        size_m: Its edges [m], shape (3,).
        spacing_m: Edge of a voxel [m].
        yaws: Yaws for each edge upright.
    """
    kernels = []
    for up in range(3):
        height_m, level_m = float(size_m[up]), size_m[[(up + 1) % 3, (up + 2) % 3]]
        profile = _shares(size_m[[up]], np.eye(1), spacing_m)
        for yaw_rad in np.pi * np.arange(yaws) / yaws:
            c, s = np.cos(yaw_rad), np.sin(yaw_rad)
            footprint = _shares(level_m, np.array([[c, -s], [s, c]]), spacing_m)
            kernels.append(BoxKernel(footprint, profile, height_m / 2))
    return tuple(kernels)


def convolve_boxes(values: FloatArray, kernels: Sequence[BoxKernel]) -> Iterator[FloatArray]:
    """Convolve with one box after the other, with zeros around, shape of the values each.

    Layers by a product of matrices, columns by FFT, in single precision: good to about 1e-6 of the largest sum.

    Args:
        values: Shape (X, Y, Z).
        kernels: What `box_kernels` gives: those with the same profile one after the other.
    """
    columns = values.shape[:2]
    widest = np.max([kernel.footprint.shape for kernel in kernels], axis=0)
    sizes = [fft.next_fast_len(int(a + b - 1), real=True) for a, b in zip(columns, widest, strict=True)]
    single, profile, spectrum = values.astype(np.float32), None, np.empty(0)
    for kernel in kernels:
        if kernel.profile is not profile:
            profile = kernel.profile
            spectrum = fft.rfft2(single @ _layers(profile, values.shape[2]), sizes, axes=(0, 1))
        shares = fft.rfft2(kernel.footprint.astype(np.float32), sizes)
        spread = fft.irfft2(spectrum * shares[:, :, None], sizes, axes=(0, 1), overwrite_x=True)
        a, b = np.array(kernel.footprint.shape) // 2
        yield spread[a : a + columns[0], b : b + columns[1]]


def _layers(profile: FloatArray, count: int) -> FloatArray:
    """The matrix that convolves `count` layers with a profile, zeros around, from the right, shape (count, count)."""
    apart = np.arange(count) - np.arange(count)[:, None] + len(profile) // 2
    inside = (apart >= 0) & (apart < len(profile))
    return np.where(inside, profile[np.where(inside, apart, 0)], 0.0).astype(np.float32)


def _shares(size_m: FloatArray, R: FloatArray, spacing_m: float) -> FloatArray:
    """Share of a turned interval or rectangle in each cell about its middle, by points spread evenly in it."""
    counts = np.maximum(np.ceil(size_m / (_FINE_M * spacing_m)).astype(int), _LEAST)
    axes = [(np.arange(n) + 0.5) / n * edge - edge / 2 for n, edge in zip(counts, size_m, strict=True)]
    points_m = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(size_m)) @ R.T
    reach = np.ceil(np.abs(R) @ size_m / 2 / spacing_m + 0.5).astype(int)
    cells = np.floor(points_m / spacing_m + 0.5).astype(int) + reach
    shape = tuple(2 * reach + 1)
    flat = np.ravel_multi_index(tuple(cells.T), shape)
    return np.bincount(flat, minlength=int(np.prod(shape))).reshape(shape) / len(points_m)
