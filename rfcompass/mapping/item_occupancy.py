"""Where tagged items are: the probability that each fills a voxel, given its tag, its size and what cameras saw.

A tag sits in the middle of one of its item's sides. Which side, how the item is turned, and where within its error the
tag is, are drawn evenly (Sobol's points, so that the same question has the same answer). An item that would stick out
into space that was seen to be free is believed less, by exp(-λ) for all of it.
"""

from collections.abc import Sequence

import numba
import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.types.tagged_items import TaggedItem
from rfcompass.types.workspace import Workspace

# Ours: places and turns of one item, enough for errors of its tag of up to 10 cm; the share that lies flat on a side,
# the others are turned anyhow; and what sticking out costs.
DRAWS = 512
FLAT_SHARE = 0.5
STICKING_OUT = 25.0
_EDGE_POINTS = 5  # sample points along each edge, to see whether an item sticks out


def items_occupancy(items: Sequence[TaggedItem], workspace: Workspace, seen_free: BoolArray) -> FloatArray:
    """Probability that at least one of the items fills each voxel, were they independent, shape (X, Y, Z).

    Args:
        items: Tagged items.
        workspace: What is mapped.
        seen_free: Voxels where nothing can be, shape (X, Y, Z); outside the workspace all is free but the table.
    """
    left = np.ones(workspace.shape)
    for item in items:
        left *= 1.0 - item_occupancy(item, workspace, seen_free)
    return np.asarray(1.0 - left)


def item_occupancy(item: TaggedItem, workspace: Workspace, seen_free: BoolArray) -> FloatArray:
    """Probability that one item fills each voxel, shape (X, Y, Z); arguments as for `items_occupancy`."""
    rotations, centres_m = _draws(item)
    half_m = item.size.size_m / 2
    h = workspace.spacing_m
    out = _sticks_out(rotations, (centres_m - workspace.lower_m) / h, half_m / h, seen_free)
    weights = np.exp(-STICKING_OUT * (out - out.min()))
    values = np.zeros(workspace.shape)
    _add_boxes(values, rotations, (centres_m - workspace.origin_m) / h, half_m / h, weights / weights.sum())
    return np.minimum(values, 1.0)


def _draws(item: TaggedItem) -> tuple[FloatArray, FloatArray]:
    """Turns (N, 3, 3) and centres (N, 3) [m] that the tag's place allows."""
    even = qmc.Sobol(7, scramble=False).random(DRAWS) + 0.5 / DRAWS  # off the ends, where a normal is infinite
    values, vectors = np.linalg.eigh(item.covariance_m2)
    tags_m = item.point_m + ndtri(even[:, :3]) * np.sqrt(np.maximum(values, 0.0)) @ vectors.T
    rotations = rotations_anyhow(even[:, 3:6])
    flat = np.arange(DRAWS) < FLAT_SHARE * DRAWS
    upright = np.full(DRAWS, 2) if item.size.deformable else (3 * even[:, 4]).astype(np.int64)
    rotations[flat] = lying_rotations(2 * np.pi * even[flat, 3], upright[flat])
    # A soft thing is flat: its tag is on one of the two large sides.
    sides = np.array([2]) if item.size.deformable else np.arange(3)
    side = sides[(even[:, 6] * len(sides)).astype(np.int64)]
    sign = np.where((even[:, 6] * len(sides) * 2).astype(np.int64) % 2 == 0, 1.0, -1.0)
    outward = np.zeros((DRAWS, 3))
    outward[np.arange(DRAWS), side] = sign * item.size.size_m[side] / 2
    return rotations, tags_m - np.einsum("nij,nj->ni", rotations, outward)


def rotations_anyhow(even: FloatArray) -> FloatArray:
    """Rotations spread evenly over all, from three numbers each [Shoemake1992], shape (N, 3, 3)."""
    a, b, c = even[:, 0], 2 * np.pi * even[:, 1], 2 * np.pi * even[:, 2]
    x, y, z, w = np.sqrt(1 - a) * np.sin(b), np.sqrt(1 - a) * np.cos(b), np.sqrt(a) * np.sin(c), np.sqrt(a) * np.cos(c)
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=-1),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=-1),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=1,
    )


def lying_rotations(yaw_rad: FloatArray, upright: IntArray) -> FloatArray:
    """Rotations with one edge (0, 1 or 2) upright, turned by a yaw, shape (N, 3, 3)."""
    rows = np.arange(len(yaw_rad))
    rotations = np.zeros((len(rows), 3, 3))
    c, s, one, other = np.cos(yaw_rad), np.sin(yaw_rad), (upright + 1) % 3, (upright + 2) % 3
    rotations[rows, 0, one], rotations[rows, 1, one] = c, s
    rotations[rows, 0, other], rotations[rows, 1, other] = -s, c
    rotations[rows, 2, upright] = 1.0
    return rotations


@numba.njit(cache=True)
def _sticks_out(rotations: FloatArray, centres: FloatArray, half: FloatArray, seen_free: BoolArray) -> FloatArray:
    """Share of each item that lies in free space, the table or beyond the workspace, by even sample points, shape (N,).

    Args:
        rotations: Turn of each, shape (N, 3, 3).
        centres: Its middle from the workspace's corner [voxel], shape (N, 3).
        half: Half its edges [voxel], shape (3,).
        seen_free: Voxels where nothing can be, shape (X, Y, Z).
    """
    X, Y, Z = seen_free.shape
    shares = np.empty(len(rotations))
    for n in range(len(rotations)):
        R, c, free = rotations[n], centres[n], 0
        for i in range(_EDGE_POINTS):
            a = ((i + 0.5) / _EDGE_POINTS * 2 - 1) * half[0]
            for j in range(_EDGE_POINTS):
                b = ((j + 0.5) / _EDGE_POINTS * 2 - 1) * half[1]
                for k in range(_EDGE_POINTS):
                    d = ((k + 0.5) / _EDGE_POINTS * 2 - 1) * half[2]
                    x = int(np.floor(R[0, 0] * a + R[0, 1] * b + R[0, 2] * d + c[0]))
                    y = int(np.floor(R[1, 0] * a + R[1, 1] * b + R[1, 2] * d + c[1]))
                    z = int(np.floor(R[2, 0] * a + R[2, 1] * b + R[2, 2] * d + c[2]))
                    if not (0 <= x < X and 0 <= y < Y and 0 <= z < Z) or seen_free[x, y, z]:
                        free += 1
        shares[n] = free / _EDGE_POINTS**3
    return shares


@numba.njit(cache=True)
def _add_boxes(
    values: FloatArray, rotations: FloatArray, centres: FloatArray, half: FloatArray, weights: FloatArray
) -> None:
    """Add the weight of every box to the voxels whose centres it holds; lengths in voxels."""
    for n in range(len(weights)):
        if weights[n] < 1e-9:
            continue
        R, c = rotations[n], centres[n]
        low, high = np.zeros(3, np.int64), np.zeros(3, np.int64)
        for axis in range(3):
            reach = abs(R[axis, 0]) * half[0] + abs(R[axis, 1]) * half[1] + abs(R[axis, 2]) * half[2]
            low[axis] = max(int(np.ceil(c[axis] - reach)), 0)
            high[axis] = min(int(np.floor(c[axis] + reach)) + 1, values.shape[axis])
        for i in range(low[0], high[0]):
            for j in range(low[1], high[1]):
                for k in range(low[2], high[2]):
                    x, y, z = i - c[0], j - c[1], k - c[2]
                    if (
                        abs(R[0, 0] * x + R[1, 0] * y + R[2, 0] * z) <= half[0]
                        and abs(R[0, 1] * x + R[1, 1] * y + R[2, 1] * z) <= half[1]
                        and abs(R[0, 2] * x + R[1, 2] * y + R[2, 2] * z) <= half[2]
                    ):
                        values[i, j, k] += weights[n]
