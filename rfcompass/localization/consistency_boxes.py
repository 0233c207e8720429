"""What one box of poses can hold: how many comparisons at most, and a pose that meets many of them.

Every row is one comparison as a signed distance, in metres, that must not be positive:

    v(x, y, θ) = n · [x, y] + g₂ cos θ + g₃ sin θ - β,      |n| = 1.

Over a box of poses, middle ± half, v differs from its value in the middle by at most

    |n_x| half_x + |n_y| half_y + s,      s = |g'(θ)| half_θ + |g| half_θ² / 2.

So each row is met everywhere in the box, met nowhere, or open; a part of the box needs to look only at the rows
that are open in the whole. No pose of the box meets more rows than are met everywhere or open. That bound counts
open rows that contradict each other. For all θ of the box, the positions that meet row m lie within
n_m · [x, y] <= β_m - g(θ_middle) + s_m. Where the intersection of some such half-planes with the box's rectangle
is empty, every pose breaks at least one of those rows; groups that share no row add up.
"""

from typing import NamedTuple, TypeAlias

import numba
import numpy as np
import numpy.typing as npt

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.localization.pose_kernels import clip, copy_vertices

RowArray: TypeAlias = npt.NDArray[np.int32]

FEW_ROWS = 48  # boxes with more open rows are too large for groups to be worth their time (ours)


class Rows(NamedTuple):
    """All comparisons."""

    G: FloatArray  # [n_x, n_y, g₂, g₃, β, |g|], shape (M, 6)
    prints: IntArray  # a random number for each row; sums over rows tell sets of rows apart, shape (M,)


class Scratch(NamedTuple):
    """The open rows of the box at hand, and room to work in."""

    row: RowArray  # which rows are open, shape (M,)
    value: FloatArray  # their signed distances in the middle of the box [m], shape (M,)
    polygon: FloatArray  # shape (V, 2)
    trial: FloatArray  # shape (V, 2)
    cut: FloatArray  # shape (V, 3)
    pose: FloatArray  # shape (3,)


@numba.njit(cache=True)
def make_scratch(rows: int) -> Scratch:
    """Room for problems of so many rows."""
    corners = FEW_ROWS + 8
    return Scratch(
        np.empty(rows, dtype=np.int32), np.empty(rows),
        np.empty((corners, 2)), np.empty((corners, 2)), np.empty((corners, 3)), np.empty(3),
    )  # fmt: skip


@numba.njit(cache=True, error_model="numpy")
def _swing(G: FloatArray, m: int, box: FloatArray, c: float, s: float) -> float:
    """By how much the turn inside the box can change row m [m]."""
    return (abs(G[m, 3] * c - G[m, 2] * s) + 0.5 * G[m, 5] * box[5]) * box[5]


@numba.njit(cache=True, error_model="numpy")
def sort_rows(rows: Rows, candidates: RowArray, box: FloatArray, scratch: Scratch) -> tuple[int, int, int, int]:
    """Sort the rows that may be open; those that are go to `scratch`.

    Returns:
        How many are met everywhere in the box, their fingerprint, how many are open, and their fingerprint.
    """
    G, c, s = rows.G, np.cos(box[2]), np.sin(box[2])
    met, key, count, open_key = 0, 0, 0, 0
    for m in candidates:
        value = G[m, 0] * box[0] + G[m, 1] * box[1] + G[m, 2] * c + G[m, 3] * s - G[m, 4]
        reach = abs(G[m, 0]) * box[3] + abs(G[m, 1]) * box[4] + _swing(G, m, box, c, s)
        if value <= -reach:
            met += 1
            key += rows.prints[m]
        elif value <= reach:
            scratch.row[count] = m
            scratch.value[count] = value
            count += 1
            open_key += rows.prints[m]
    return met, key, count, open_key


@numba.njit(cache=True, error_model="numpy")
def count_met(rows: Rows, count: int, scratch: Scratch) -> tuple[int, int]:
    """How many of the open rows `scratch.pose` meets, and their fingerprint."""
    G, pose = rows.G, scratch.pose
    c, s = np.cos(pose[2]), np.sin(pose[2])
    met, key = 0, 0
    for q in range(count):
        m = scratch.row[q]
        if G[m, 0] * pose[0] + G[m, 1] * pose[1] + G[m, 2] * c + G[m, 3] * s <= G[m, 4]:
            met += 1
            key += rows.prints[m]
    return met, key


@numba.njit(cache=True, error_model="numpy")
def most_broken_first(count: int, scratch: Scratch) -> None:
    """Order the open rows by their signed distance in the middle, falling (insertion sort)."""
    value, row = scratch.value, scratch.row
    for q in range(1, count):
        v, m, p = value[q], row[q], q - 1
        while p >= 0 and value[p] < v:
            value[p + 1], row[p + 1] = value[p], row[p]
            p -= 1
        value[p + 1], row[p + 1] = v, m


@numba.njit(cache=True, error_model="numpy")
def _fill_rectangle(polygon: FloatArray, box: FloatArray) -> int:
    for corner in range(4):
        polygon[corner, 0] = box[0] + (box[3] if corner in (1, 2) else -box[3])
        polygon[corner, 1] = box[1] + (box[4] if corner >= 2 else -box[4])
    return 4


@numba.njit(cache=True, error_model="numpy")
def agreeable_pose(rows: Rows, count: int, box: FloatArray, scratch: Scratch) -> None:
    """Find a pose at the middle θ, `scratch.pose`, that meets many open rows.

    Take one row after the other, from the back, the best met first, unless nothing would be left.
    """
    G, c, s = rows.G, np.cos(box[2]), np.sin(box[2])
    polygon, trial, pose = scratch.polygon, scratch.trial, scratch.pose
    corners = _fill_rectangle(polygon, box)
    for q in range(count - 1, -1, -1):
        m = scratch.row[q]
        copy_vertices(polygon, corners, trial)
        left = clip(trial, corners, G, m, G[m, 4] - G[m, 2] * c - G[m, 3] * s, scratch.cut)
        if left >= 3:
            copy_vertices(trial, left, polygon)
            corners = left
    pose[0], pose[1], pose[2] = 0.0, 0.0, box[2]
    for v in range(corners):
        pose[0] += polygon[v, 0] / corners
        pose[1] += polygon[v, 1] / corners


@numba.njit(cache=True, error_model="numpy")
def contradictions(rows: Rows, count: int, box: FloatArray, scratch: Scratch, enough: int) -> int:
    """Number of groups of open rows, without a common row, that no pose of the box meets together.

    Args:
        rows: All rows.
        count: How many rows are open.
        box: Middle and half sizes.
        scratch: The open rows; groups are closed in their order.
        enough: Stop at this number.
    """
    G, c, s = rows.G, np.cos(box[2]), np.sin(box[2])
    corners, groups = _fill_rectangle(scratch.polygon, box), 0
    for q in range(count):
        m = scratch.row[q]
        room = G[m, 4] - G[m, 2] * c - G[m, 3] * s + _swing(G, m, box, c, s)
        corners = clip(scratch.polygon, corners, G, m, room, scratch.cut)
        if corners < 3:
            groups += 1
            if groups >= enough:
                break
            corners = _fill_rectangle(scratch.polygon, box)
    return groups
