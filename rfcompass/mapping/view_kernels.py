"""Compiled projection of voxels into a depth image.

A voxel (i, j, k) goes into the image by one matrix: (u z, v z, z) = P (i, j, k, 1), with z along the optical axis.
Pixel (u, v) covers u ± 1/2, v ± 1/2. With d the depth there and h half the voxel's extent along the optical axis,

    z ≤ d - h: free;    |z - d| < h: surface;    z ≥ d + h, or no d: unobserved.

A voxel that a surface only touches lies before it or behind it.
"""

import numba
import numpy as np
import numpy.typing as npt

from rfcompass.arrays import FloatArray

StateArray = npt.NDArray[np.uint8]
Float32Array = npt.NDArray[np.float32]

# In this order a later one wins, whatever the order of the views.
OUTSIDE, UNOBSERVED, FREE, SURFACE = np.uint8(0), np.uint8(1), np.uint8(2), np.uint8(3)


@numba.njit(cache=True, inline="always")
def _seen(a: float, b: float, z: float, depth_m: Float32Array, half_m: float) -> int:
    """How one view sees a voxel, with a = u z and b = v z."""
    if z <= 0.0:
        return 0
    u, v = a / z + 0.5, b / z + 0.5
    if not (0.0 <= u < depth_m.shape[1] and 0.0 <= v < depth_m.shape[0]):
        return 0
    ahead_m = depth_m[int(v), int(u)] - z
    if ahead_m >= half_m:
        return 2
    return 3 if ahead_m > -half_m else 1


@numba.njit(cache=True)
def mark_view(state: StateArray, P: FloatArray, depth_m: Float32Array, half_m: float) -> None:
    """Raise the state of each voxel to what a view says of it.

    Args:
        state: What is known of each voxel; changed in place, shape (X, Y, Z).
        P: Projection of a voxel's indices, shape (3, 4).
        depth_m: Depth image, NaN where nothing was seen [m], shape (H, W).
        half_m: Half the extent of a voxel along the optical axis [m].
    """
    for i in range(state.shape[0]):
        for j in range(state.shape[1]):
            a, b, c = P[:, 0] * i + P[:, 1] * j + P[:, 3]
            for k in range(state.shape[2]):
                seen = _seen(a + P[0, 2] * k, b + P[1, 2] * k, c + P[2, 2] * k, depth_m, half_m)
                state[i, j, k] = max(state[i, j, k], seen)


@numba.njit(cache=True)
def add_log_odds(
    state: StateArray,
    log_odds: Float32Array,
    P: FloatArray,
    depth_m: Float32Array,
    half_m: float,
    steps: FloatArray,
) -> None:
    """Mark a view, and add to the log-odds of each voxel that it looks into.

    Args:
        state: As for `mark_view`.
        log_odds: Log-odds that a voxel is filled; changed in place, shape (X, Y, Z).
        P: As for `mark_view`.
        depth_m: As for `mark_view`.
        half_m: As for `mark_view`.
        steps: Added for a surface, added for free space, least and largest log-odds, shape (4,).
    """
    for i in range(state.shape[0]):
        for j in range(state.shape[1]):
            a, b, c = P[:, 0] * i + P[:, 1] * j + P[:, 3]
            for k in range(state.shape[2]):
                seen = _seen(a + P[0, 2] * k, b + P[1, 2] * k, c + P[2, 2] * k, depth_m, half_m)
                state[i, j, k] = max(state[i, j, k], seen)
                if seen > 1:
                    added = log_odds[i, j, k] + (steps[0] if seen == 3 else steps[1])
                    log_odds[i, j, k] = min(max(added, steps[2]), steps[3])
