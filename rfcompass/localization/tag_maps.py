"""Where a part tag truly is, once its own bias is allowed for: the likelihood of its place, smeared, compiled.

Reflections shift the place where a tag seems to be, and they do so alike in every scan of a part that lies still.
So a tag is taken to seem to be at p + β, with one unknown β for all scans,

    β ~ 0.98 N(0, σ²) + 0.02 N(0, 9 σ²)   along x and along y,

and the likelihood of p is that of the seeming place, smeared with this density. A floor stands for fixes that are
altogether wrong.
"""

import numba
import numpy as np
from numpy import exp, log

from rfcompass.arrays import FloatArray

WIDE_SHARE = 0.02
WIDE_FACTOR = 3.0
_TAPS_SD = 4.0
_FLOOR_PER_M2 = 1e-6  # ours: density of "anywhere in this square metre" beside the likelihood's mass of 1


@numba.njit(cache=True, error_model="numpy")
def _taps(sd: float, pitch: float) -> FloatArray:
    """Share of a normal density in each cell, middle first, shape (R + 1,)."""
    reach = int(np.ceil(_TAPS_SD * sd / pitch)) + 1
    taps = np.empty(reach + 1)
    for n in range(reach + 1):
        taps[n] = exp(-0.5 * (n * pitch / sd) ** 2)
    return taps / (2.0 * taps.sum() - taps[0])


@numba.njit(cache=True, error_model="numpy")
def _smear(mass: FloatArray, taps: FloatArray) -> FloatArray:
    """Convolve along y, where there is mass, then along x; what leaves the map is lost."""
    X, Y = mass.shape
    out, along = np.zeros((X, Y)), np.empty(Y)
    for i in range(X):
        if not mass[i].any():
            continue
        along[:] = 0.0
        for j in range(Y):
            if mass[i, j] > 0.0:
                for n in range(max(0, j - taps.size + 1), min(Y, j + taps.size)):
                    along[n] += taps[abs(n - j)] * mass[i, j]
        for n in range(max(0, i - taps.size + 1), min(X, i + taps.size)):
            for j in range(Y):
                out[n, j] += taps[abs(n - i)] * along[j]
    return out


@numba.njit(cache=True, error_model="numpy")
def smeared_map(
    cells: FloatArray, log_weight: FloatArray, pitch: float, bias_sd: float
) -> tuple[FloatArray, FloatArray]:
    """Log density of a tag's true place on a grid.

    Args:
        cells: Seeming places of equal area [m], shape (C, 2).
        log_weight: Their log likelihood, shape (C,).
        pitch: Pitch of the grid [m].
        bias_sd: σ of the bias along each axis [m].

    Returns:
        The log density [log 1/m²], shape (X, Y), and the place of the grid's first point [m], shape (2,).
    """
    weight = exp(log_weight - log_weight.max())
    weight /= weight.sum()
    margin = np.ceil((_TAPS_SD - 1.0) * WIDE_FACTOR * bias_sd / pitch) * pitch
    heavy = np.flatnonzero(weight > 1e-9 * weight.max())
    first, last = np.empty(2), np.empty(2)
    for axis in range(2):
        first[axis] = cells[heavy, axis].min() - margin
        last[axis] = cells[heavy, axis].max() + margin
    mass = np.zeros((int((last[0] - first[0]) / pitch) + 2, int((last[1] - first[1]) / pitch) + 2))
    for c in heavy:
        u, v = (cells[c, 0] - first[0]) / pitch, (cells[c, 1] - first[1]) / pitch
        i, j = int(u), int(v)
        fu, fv = u - i, v - j
        mass[i, j] += weight[c] * (1.0 - fu) * (1.0 - fv)
        mass[i + 1, j] += weight[c] * fu * (1.0 - fv)
        mass[i, j + 1] += weight[c] * (1.0 - fu) * fv
        mass[i + 1, j + 1] += weight[c] * fu * fv
    narrow = _smear(mass, _taps(bias_sd, pitch))
    wide = _smear(mass, _taps(WIDE_FACTOR * bias_sd, pitch))
    density = ((1.0 - WIDE_SHARE) * narrow + WIDE_SHARE * wide) / pitch**2
    return log(density + _FLOOR_PER_M2), first
