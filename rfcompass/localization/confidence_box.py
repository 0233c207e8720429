"""Confidence box of a peak [Boroushaki2023], section 4.2: the extent of the region of almost the same power.

The region is the connected part around the peak where P > 0.84 max P, which is -0.75 dB in power. A small box means
that the reads leave no other place; it measures ambiguity, not bias.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.rf.peak_search import Peak, PowerAt, grid_points
from rfcompass.types.volumes import SearchVolume

THRESHOLD = 0.84
# Ours: the paper prints no thresholds. Along the range of a one-metre path half a metre is already a good box.
MAX_BOX_M = (0.5, 0.5, 0.5)
HALF_SAMPLES = 12  # grid points from the peak to the edge of the window
FIRST_HALF_WIDTH_M = 0.03
WIDEN = 1.5


@dataclass(frozen=True)
class ConfidenceBox:
    """Extent of the region along x, y, z [m], shape (3,), and whether the border of the volume cuts it off."""

    extent_m: FloatArray
    clipped: bool


def confidence_box(power_at: PowerAt, volume: SearchVolume, peak: Peak, threshold: float = THRESHOLD) -> ConfidenceBox:
    """Measure the region around a peak on a window that widens until the region fits.

    Args:
        power_at: Power at points (P, 3), shape (P,).
        volume: Search volume; the region ends at its border.
        peak: Highest peak of the volume.
        threshold: Share of the peak's power.
    """
    half_m = np.where(volume.free_axes, FIRST_HALF_WIDTH_M, 0.0)
    while True:
        axes = _window(volume, peak.point_m, half_m)
        region = _region(power_at, axes, peak, threshold)
        too_narrow = _leaves_window(volume, axes, region)
        if not too_narrow.any():
            return _measure(volume, axes, region)
        half_m = np.where(too_narrow, WIDEN * half_m, half_m)


def is_confident(box: ConfidenceBox, max_box_m: tuple[float, float, float] = MAX_BOX_M) -> bool:
    """True if the box is smaller than its threshold along every axis (the paper's δ < τ) and not cut off."""
    return not box.clipped and bool((box.extent_m < max_box_m).all())


def _window(
    volume: SearchVolume, centre_m: FloatArray, half_m: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Grid around the peak that contains it, cut at the border of the volume."""
    steps = np.arange(-HALF_SAMPLES, HALF_SAMPLES + 1) / HALF_SAMPLES
    axes = [
        np.unique(np.clip(centre_m[axis] + half_m[axis] * steps, volume.lower_m[axis], volume.upper_m[axis]))
        for axis in range(3)
    ]
    return axes[0], axes[1], axes[2]


def _region(
    power_at: PowerAt, axes: tuple[FloatArray, FloatArray, FloatArray], peak: Peak, threshold: float
) -> BoolArray:
    """True on the connected part of the window around the peak that exceeds the threshold."""
    shape = tuple(axis.size for axis in axes)
    above = (power_at(grid_points(axes)) > threshold * peak.power).reshape(shape)
    centre = tuple(int(np.argmin(np.abs(axis - value))) for axis, value in zip(axes, peak.point_m, strict=True))
    above[centre] = True
    parts, _ = label(above, structure=np.ones((3, 3, 3)))
    return np.asarray(parts == parts[centre])


def _leaves_window(
    volume: SearchVolume, axes: tuple[FloatArray, FloatArray, FloatArray], region: BoolArray
) -> BoolArray:
    """True for each axis along which the region reaches an end of the window that is no border of the volume."""
    leaves = np.zeros(3, dtype=bool)
    for axis, values in enumerate(axes):
        first, last = _span(region, axis)
        low = first == 0 and values[0] > volume.lower_m[axis]
        high = last == values.size - 1 and values[-1] < volume.upper_m[axis]
        leaves[axis] = low or high
    return leaves


def _measure(volume: SearchVolume, axes: tuple[FloatArray, FloatArray, FloatArray], region: BoolArray) -> ConfidenceBox:
    extent_m, clipped = np.zeros(3), False
    for axis in np.flatnonzero(volume.free_axes).tolist():
        values, low_m, high_m = axes[axis], volume.lower_m[axis], volume.upper_m[axis]
        first, last = _span(region, axis)
        step_m = float(np.diff(values).max())
        extent_m[axis] = min(values[last] - values[first] + step_m, high_m - low_m)
        clipped |= bool(values[first] <= low_m or values[last] >= high_m)
    return ConfidenceBox(extent_m, clipped)


def _span(region: BoolArray, axis: int) -> tuple[int, int]:
    """First and last index of the region along an axis."""
    met = np.flatnonzero(region.any(axis=tuple(other for other in range(3) if other != axis)))
    return int(met[0]), int(met[-1])
