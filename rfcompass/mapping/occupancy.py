"""From the two maps to where the target can be [Boroushaki2023], sections 4.3 and 4.4."""

import numpy as np
from scipy import fft

from rfcompass.arrays import FloatArray
from rfcompass.errors import ShapeError, TargetTooLarge
from rfcompass.mapping.target_kernels import TargetKernel
from rfcompass.types.piles import VoxelGrid


def fuse_maps(visual: VoxelGrid, radio: VoxelGrid, *, clip: bool = True) -> VoxelGrid:
    """Add the visual and the RF map, C + R.

    Args:
        visual: The map C.
        radio: The map R, zero or negative, over the same voxels.
        clip: Keep the sum from falling below 0. The paper does not; a tag in free space would then make its
            neighbourhood less likely than space that is known to be empty.

    Raises:
        ShapeError: If the maps are not over the same voxels.
    """
    _check_same_voxels(visual, radio)
    total = visual.values + radio.values
    return VoxelGrid(visual.origin_m, visual.spacing_m, np.maximum(total, 0.0) if clip else total)


def occupancy_map(fused: VoxelGrid, target: TargetKernel) -> VoxelGrid:
    """Convolve C + R with the target's kernel: the likelier, the more of the target fits in more ways.

    Space outside the workspace counts as known to be empty. With a kernel that sums to 1 and no tags, a value is the
    share of the target, in the mean over its orientations, that would lie in unobserved space with its middle there.

    Args:
        fused: The map C + R.
        target: Kernel with the same spacing.

    Raises:
        ShapeError: If the spacings differ.
        TargetTooLarge: If the target is longer than the workspace's diagonal.
    """
    if not np.isclose(fused.spacing_m, target.spacing_m, rtol=1e-9):
        message = f"the kernel's voxels have {target.spacing_m} m, the map's {fused.spacing_m} m"
        raise ShapeError(message, name="spacing_m", expected=fused.spacing_m, got=target.spacing_m)
    diagonal_m = fused.spacing_m * float(np.linalg.norm(fused.values.shape))
    if target.longest_m > diagonal_m:
        message = f"a target of {target.longest_m} m cannot lie in a workspace with a diagonal of {diagonal_m:.3f} m"
        raise TargetTooLarge(message, longest_m=target.longest_m, diagonal_m=diagonal_m)
    return VoxelGrid(fused.origin_m, fused.spacing_m, convolve_same(fused.values, target.values))


def convolve_same(values: FloatArray, kernel: FloatArray) -> FloatArray:
    """Convolve in three dimensions, with zeros around; the answer has the shape of `values`.

    By FFT in single precision, good to about 1e-6 of the largest sum, over the box that holds everything that is not
    zero: a pile fills a fraction of its workspace.

    Args:
        values: Shape (X, Y, Z).
        kernel: Odd along every axis, shape (A, B, C).
    """
    out, half = np.zeros(values.shape), np.array(kernel.shape) // 2
    filled = _filled_box(values)
    if filled is None:
        return out
    low, high = filled
    part = values[tuple(slice(a, b) for a, b in zip(low, high, strict=True))]
    spread = _full_convolution(part, kernel)
    start, end = np.maximum(low - half, 0), np.minimum(high + half, values.shape)
    inside = tuple(slice(a, b) for a, b in zip(start - (low - half), end - (low - half), strict=True))
    out[tuple(slice(a, b) for a, b in zip(start, end, strict=True))] = spread[inside]
    if values.min() >= 0 and kernel.min() >= 0:
        np.maximum(out, 0.0, out=out)  # rounding of the FFT
    return out


def _full_convolution(part: FloatArray, kernel: FloatArray) -> FloatArray:
    full = [a + b - 1 for a, b in zip(part.shape, kernel.shape, strict=True)]
    sizes = [fft.next_fast_len(length, real=True) for length in full]
    spectrum = fft.rfftn(part.astype(np.float32), sizes)
    spectrum *= fft.rfftn(kernel.astype(np.float32), sizes)
    spread = fft.irfftn(spectrum, sizes, overwrite_x=True)
    return spread[: full[0], : full[1], : full[2]]


def _filled_box(values: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """First voxel and the one past the last that are not zero along each axis, shapes (3,); None if all are zero."""
    filled = values != 0
    ends = []
    for axis in range(3):
        along = np.flatnonzero(filled.any(axis=tuple(other for other in range(3) if other != axis)))
        if not along.size:
            return None
        ends.append((along[0], along[-1] + 1))
    low, high = np.array(ends).T
    return low, high


def _check_same_voxels(one: VoxelGrid, other: VoxelGrid) -> None:
    same = (
        one.values.shape == other.values.shape
        and np.isclose(one.spacing_m, other.spacing_m, rtol=1e-9)
        and np.allclose(one.origin_m, other.origin_m, rtol=0, atol=1e-6 * one.spacing_m)
    )
    if not same:
        message = f"the maps are over different voxels: {_voxels(one)}, {_voxels(other)}"
        raise ShapeError(message, name="radio", expected=one.values.shape, got=other.values.shape)


def _voxels(grid: VoxelGrid) -> str:
    return f"{grid.values.shape} of {grid.spacing_m} m from {grid.origin_m.tolist()}"
