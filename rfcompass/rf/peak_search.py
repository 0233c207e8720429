"""Coarse-to-fine search of the highest peak of a hologram.

A hologram has side lobes about half a wavelength apart. A coarse step of an eighth of a wavelength meets every lobe;
the best local maxima of the coarse grid, not only the first, are climbed on ever finer grids.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter

from rfcompass.arrays import FloatArray
from rfcompass.types.volumes import SearchVolume

STEPS_PER_WAVELENGTH = 8
FINER = 3  # each level divides the step by this
MOVES = 20  # a climb that has not ended after so many moves goes on at the next level

PowerAt = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class Peak:
    """A local maximum: where it is [m], shape (3,), and how high."""

    point_m: FloatArray
    power: float


def volume_axes(volume: SearchVolume, step_m: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Evenly spaced values along each axis, from border to border, at most `step_m` apart [m]."""
    sides = zip(volume.lower_m, volume.upper_m, strict=True)
    x, y, z = (np.linspace(low, high, int(np.ceil((high - low) / step_m)) + 1) for low, high in sides)
    return x, y, z


def grid_points(axes: tuple[FloatArray, FloatArray, FloatArray]) -> FloatArray:
    """All points of a grid, z fastest [m], shape (X Y Z, 3)."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def coarse_peaks(power_at: PowerAt, volume: SearchVolume, wavelength_m: float, *, keep: int) -> list[Peak]:
    """Find the local maxima of a grid of an eighth of a wavelength.

    Args:
        power_at: Power at points (P, 3), shape (P,).
        volume: Where to search.
        wavelength_m: Wavelength that sets the step [m].
        keep: How many to return.

    Returns:
        At most `keep` grid points, highest first.
    """
    axes = volume_axes(volume, wavelength_m / STEPS_PER_WAVELENGTH)
    points_m = grid_points(axes)
    power = power_at(points_m)
    grid = power.reshape([axis.size for axis in axes])
    tops = np.flatnonzero(grid == maximum_filter(grid, size=3, mode="nearest"))
    best = tops[np.argsort(-power[tops], kind="stable")[:keep]]
    return [Peak(points_m[top], float(power[top])) for top in best]


def highest_peak(
    power_at: PowerAt, volume: SearchVolume, wavelength_m: float, *, keep: int, resolution_m: float
) -> Peak:
    """Climb from the best coarse maxima and return the highest top.

    Args:
        power_at: Power at points (P, 3), shape (P,).
        volume: Where to search.
        wavelength_m: Wavelength that sets the coarse step [m].
        keep: How many coarse maxima are climbed.
        resolution_m: The finest step is no longer than this [m].
    """
    starts = coarse_peaks(power_at, volume, wavelength_m, keep=keep)
    tops = climb(power_at, volume, starts, wavelength_m / STEPS_PER_WAVELENGTH, resolution_m=resolution_m)
    return max(tops, key=lambda peak: peak.power)


def climb(
    power_at: PowerAt, volume: SearchVolume, starts: Sequence[Peak], step_m: float, *, resolution_m: float
) -> list[Peak]:
    """Climb from some grid points, each to the top of its lobe, on grids of ever smaller step.

    All climb side by side, since asking for the power of a few points takes as long as for many.
    """
    best = list(starts)
    while step_m > resolution_m:
        step_m /= FINER
        climbing = list(range(len(best)))
        for _ in range(MOVES):
            around_m = np.stack([_neighbourhood(volume, best[i].point_m, step_m) for i in climbing])
            power = power_at(around_m.reshape(-1, 3)).reshape(len(climbing), -1)
            tops = power.argmax(axis=1).tolist()
            risen = [k for k, i in enumerate(climbing) if power[k, tops[k]] > best[i].power]
            for k in risen:
                best[climbing[k]] = Peak(around_m[k, tops[k]], float(power[k, tops[k]]))
            climbing = [climbing[k] for k in risen]
            if not climbing:
                break
    return best


def _neighbourhood(volume: SearchVolume, centre_m: FloatArray, step_m: float) -> FloatArray:
    """Points up to FINER - 1 steps from a centre along each free axis, inside the volume."""
    offsets = step_m * np.arange(1 - FINER, FINER)
    around = [
        np.clip(centre_m[axis] + offsets, volume.lower_m[axis], volume.upper_m[axis])
        if volume.free_axes[axis]
        else centre_m[axis : axis + 1]
        for axis in range(3)
    ]
    return grid_points((around[0], around[1], around[2]))
