"""Tell objects apart by their shape alone: steps in depth and hollow creases part them, after [LCCP2014].

Beside the network of the paper (SD Mask R-CNN), whose weights cannot be shipped; for that, and for your own, see
`rfcompass.mapping.network_segmenter`.
"""

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from scipy import ndimage

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.errors import InputError
from rfcompass.mapping.camera import points_image
from rfcompass.types.piles import DepthView, InstanceMasks

_Window: TypeAlias = tuple[slice, slice]

_CROSS = ndimage.generate_binary_structure(2, 1)


@dataclass(frozen=True, kw_only=True)
class DepthSegmenter:
    """Split what stands on the table where the depth jumps or the surface bends inwards.

    1. Pixels nearer than `above_table_m` to the table top are background.
    2. Neighbours `reach` pixels apart are parted if their depths differ by more than `step_m` beyond what the slope
       explains, or if the surface between them is hollow: with points p, q and normals n, m, if (n - m)·(p - q) is
       below - |p - q| sin(`crease_rad`). An edge of one convex thing bends outwards and parts nothing.
    3. Connected patches of pixels that nothing parts are objects; smaller ones than `least_pixels` are none.
    4. Pixels of the borders go to the nearest object within `grow` pixels.

    All numbers are ours. Two boxes side by side with level tops are one object to it.

    Attributes:
        table_m: Height of the table top in the world frame [m].
        above_table_m: What is lower than this over the table is background [m].
        step_m: Least step in depth [m].
        crease_rad: Least angle of a hollow crease [rad].
        median: Edge of the median filter that calms the depth before all else [pixel]; it keeps steps. 1 for none.
        smooth: Standard deviation of the filter before normals are taken [pixel].
        reach: Distance of the neighbours that are compared [pixel].
        least_pixels: Least size of an object.
        grow: How far objects grow into their borders [pixel].
    """

    table_m: float = 0.0
    above_table_m: float = 0.006
    step_m: float = 0.008
    crease_rad: float = float(np.deg2rad(25.0))
    median: int = 3
    smooth: float = 1.0
    reach: int = 2
    least_pixels: int = 40
    grow: int = 6

    def segment(self, view: DepthView) -> InstanceMasks:
        """Label each pixel with its object, 0 for the background.

        Raises:
            InputError: If the image is smaller than the neighbourhood.
        """
        if min(view.depth_m.shape) <= 2 * self.reach:
            message = f"an image of {view.depth_m.shape} pixels is too small to segment"
            raise InputError(message, got=view.depth_m.shape)
        calm = replace(view, depth_m=_median(view.depth_m, self.median))
        points_m = points_image(calm)
        with np.errstate(invalid="ignore"):
            standing = points_m[..., 2] > self.table_m + self.above_table_m
        smooth_m = _smoothed(points_m, standing, self.smooth)
        normals = _normals(smooth_m, view.T_world_camera[:3, 3])
        inner = standing & ~self._parted(calm.depth_m, smooth_m, normals)
        patches, _ = ndimage.label(inner, structure=_CROSS)
        return InstanceMasks(_grown(_kept(patches, self.least_pixels), standing, self.grow))

    def _parted(self, depth_m: FloatArray, points_m: FloatArray, normals: FloatArray) -> BoolArray:
        """True for pixels that lie at a step or in a hollow crease."""
        parted = np.zeros(depth_m.shape, dtype=bool)
        with np.errstate(invalid="ignore"):
            for axis in (0, 1):
                for low, middle, high in _triples(depth_m.shape, axis, self.reach):
                    # The second difference is zero on a slope, whatever its angle; at a step it is the step.
                    jump = np.abs(depth_m[low] - 2 * depth_m[middle] + depth_m[high]) > self.step_m
                    apart_m = points_m[high] - points_m[low]
                    bend = ((normals[high] - normals[low]) * apart_m).sum(axis=-1)
                    hollow = bend < -np.sin(self.crease_rad) * np.linalg.norm(apart_m, axis=-1)
                    parted[middle] |= jump | hollow
        return parted


def _triples(shape: tuple[int, ...], axis: int, reach: int) -> list[tuple[_Window, _Window, _Window]]:
    """Windows that shift an image along an axis, at each distance up to `reach`: behind, here, ahead."""
    length = shape[axis]

    def window(start: int, stop: int) -> _Window:
        return (slice(start, stop), slice(None)) if axis == 0 else (slice(None), slice(start, stop))

    return [
        (window(0, length - 2 * step), window(step, length - step), window(2 * step, length))
        for step in range(1, reach + 1)
    ]


def _median(depth_m: FloatArray, edge: int) -> FloatArray:
    """Median about each pixel; where depth is missing it stays missing, and counts as far beside it."""
    missing = np.isnan(depth_m)
    filled = np.where(missing, np.inf, depth_m)
    calm = ndimage.median_filter(filled, size=edge)
    return np.where(missing | np.isinf(calm), depth_m, calm)


def _smoothed(points_m: FloatArray, valid: BoolArray, sigma: float) -> FloatArray:
    """Mean of the valid points about each pixel, with Gaussian weights; NaN where a pixel is not valid."""
    weights = ndimage.gaussian_filter(valid.astype(np.float64), sigma)
    filled = np.where(valid[..., None], points_m, 0.0)
    sums = np.stack([ndimage.gaussian_filter(filled[..., axis], sigma) for axis in range(3)], axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(valid[..., None], sums / weights[..., None], np.nan)


def _normals(points_m: FloatArray, eye_m: FloatArray) -> FloatArray:
    """Unit normals that face the camera, NaN where a neighbour is missing, shape (H, W, 3)."""
    normals = np.cross(np.gradient(points_m, axis=1), np.gradient(points_m, axis=0))
    with np.errstate(invalid="ignore", divide="ignore"):
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        away = (normals * (eye_m - points_m)).sum(axis=-1) < 0
    return np.asarray(np.where(away[..., None], -normals, normals))


def _kept(patches: IntArray, least_pixels: int) -> IntArray:
    """Number the patches that are large enough from 1 on."""
    sizes = np.bincount(patches.ravel())
    large = sizes >= least_pixels
    large[0] = False
    return np.where(large, np.cumsum(large), 0)[patches]


def _grown(labels: IntArray, standing: BoolArray, reach: int) -> IntArray:
    """Give each pixel that stands above the table to the nearest label within `reach` pixels."""
    if not labels.any():
        return labels
    distance, (rows, columns) = ndimage.distance_transform_edt(labels == 0, return_indices=True)
    return np.where(standing & (distance <= reach), labels[rows, columns], 0)
