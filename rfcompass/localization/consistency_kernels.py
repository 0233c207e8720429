"""Branch and bound for the pose that meets the most comparisons, compiled.

Every row is one comparison as a signed distance, in metres, that must not be positive:

    v(x, y, θ) = n · [x, y] + g₂ cos θ + g₃ sin θ - β,      |n| = 1.

Over a box of poses, centre ± half, v differs from its value in the middle by at most

    |n_x| half_x + |n_y| half_y + |g'(θ)| half_θ + |g| half_θ² / 2.

So each row is met everywhere in the box, met nowhere, or open. No pose of the box meets more rows than are met
everywhere or open: that is the bound. A box keeps only its open rows for its children.
"""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray

_MAX_WAITING = 128  # boxes that wait at the same time: two for each halving on the way down


class _Stack(NamedTuple):
    """Boxes still to be searched, the next one last."""

    boxes: FloatArray  # middle (x, y, θ) and half sizes, shape (S, 6)
    tally: IntArray  # rows met everywhere, rows that are open, rows met in the middle, shape (S, 3)
    open_rows: IntArray  # which rows are open, shape (S, M)


@numba.njit(cache=True, error_model="numpy")
def _judge(G: FloatArray, rows: IntArray, box: FloatArray, open_rows: IntArray) -> tuple[int, int, int]:
    """Count rows met everywhere, open rows (listed in `open_rows`), and rows met in the middle of the box."""
    c, s = np.cos(box[2]), np.sin(box[2])
    everywhere, still_open, middle = 0, 0, 0
    for m in rows:
        value = G[m, 0] * box[0] + G[m, 1] * box[1] + G[m, 2] * c + G[m, 3] * s - G[m, 4]
        turn = abs(G[m, 3] * c - G[m, 2] * s) + 0.5 * G[m, 5] * box[5]
        reach = abs(G[m, 0]) * box[3] + abs(G[m, 1]) * box[4] + turn * box[5]
        middle += value <= 0.0
        if value + reach <= 0.0:
            everywhere += 1
        elif value - reach <= 0.0:
            open_rows[still_open] = m
            still_open += 1
    return everywhere, still_open, middle


@numba.njit(cache=True, error_model="numpy")
def _widest(box: FloatArray, leaf: FloatArray, lever: float) -> int:
    """Axis to halve next: the one that moves the part's tags most; -1 if the box is a leaf."""
    axis, most = -1, 0.0
    for d in range(3):
        moved = box[3 + d] * (lever if d == 2 else 1.0)
        if box[3 + d] > leaf[d] and moved > most:
            axis, most = d, moved
    return axis


@numba.njit(cache=True, error_model="numpy")
def _roots(G: FloatArray, bounds: FloatArray) -> _Stack:
    """Boxes that cover all poses: the whole rectangle, with the circle cut into ranges of θ if any row names θ."""
    M, count = G.shape[0], 16 if G[:, 5].max() > 0.0 else 1
    size = count + _MAX_WAITING
    stack = _Stack(np.zeros((size, 6)), np.zeros((size, 3), dtype=np.int64), np.zeros((size, M), dtype=np.int64))
    for r in range(count):
        box = stack.boxes[r]
        box[:2] = (bounds[:, 0] + bounds[:, 1]) / 2.0
        box[3:5] = (bounds[:, 1] - bounds[:, 0]) / 2.0
        if count > 1:
            box[2] = (2 * r + 1) * np.pi / count - np.pi
            box[5] = np.pi / count
        stack.tally[r] = _judge(G, np.arange(M), box, stack.open_rows[r])
    return stack


@numba.njit(cache=True, error_model="numpy")
def _swap(stack: _Stack, top: int) -> None:
    """Exchange boxes `top` and `top + 1`."""
    box, tally, rows = stack.boxes[top].copy(), stack.tally[top].copy(), stack.open_rows[top].copy()
    stack.boxes[top] = stack.boxes[top + 1]
    stack.tally[top] = stack.tally[top + 1]
    stack.open_rows[top] = stack.open_rows[top + 1]
    stack.boxes[top + 1], stack.tally[top + 1], stack.open_rows[top + 1] = box, tally, rows


@numba.njit(cache=True, error_model="numpy")
def _halve(G: FloatArray, stack: _Stack, top: int, axis: int) -> None:
    """Replace box `top` by its halves, at `top` and `top + 1`; the one that may meet more rows comes last."""
    boxes, tally = stack.boxes, stack.tally
    rows, sure = stack.open_rows[top, : tally[top, 1]].copy(), tally[top, 0]
    boxes[top, 3 + axis] /= 2.0
    boxes[top + 1] = boxes[top]
    boxes[top, axis] -= boxes[top, 3 + axis]
    boxes[top + 1, axis] += boxes[top + 1, 3 + axis]
    for half in range(top, top + 2):
        everywhere, still_open, middle = _judge(G, rows, boxes[half], stack.open_rows[half])
        tally[half, 0], tally[half, 1], tally[half, 2] = sure + everywhere, still_open, sure + middle
    if tally[top, 2] > tally[top + 1, 2]:
        _swap(stack, top)


@numba.njit(cache=True, error_model="numpy")
def search(
    G: FloatArray, bounds: FloatArray, leaf: FloatArray, best: int, max_nodes: int, poses: FloatArray
) -> tuple[int, int, int, int]:
    """Find poses that meet the most rows, depth first.

    Args:
        G: Rows [n_x, n_y, g₂, g₃, β, |g|], shape (M, 6).
        bounds: Where the centre may lie [[xmin, xmax], [ymin, ymax]] [m], shape (2, 2).
        leaf: Half sizes (x, y, θ) of a box that is not halved any more [m, m, rad], shape (3,).
        best: Number of rows that a pose is known to meet, 0 if none is. Boxes that can only equal the best are
            searched if it is known, so that ties are found.
        max_nodes: Boxes to look at before giving up.
        poses: Filled with poses (x, y, θ) that meet the most rows, shape (P, 3).

    Returns:
        Largest number met, a bound on it that no pose exceeds, how many poses were filled in, boxes looked at.
    """
    needed, lever = 0 if best > 0 else 1, G[:, 5].max()
    stack = _roots(G, bounds)
    bound, found, nodes, top = best, 0, 0, 16 if lever > 0.0 else 1
    while top > 0:
        top -= 1
        everywhere, still_open, middle = stack.tally[top]
        if everywhere + still_open < best + needed:
            continue
        if middle > best:
            best, found = middle, 0
        if middle == best and found < len(poses):
            poses[found] = stack.boxes[top, :3]
            found += 1
        axis = _widest(stack.boxes[top], leaf, lever) if still_open else -1
        if axis < 0 or nodes >= max_nodes:
            bound = max(bound, everywhere + still_open)
            continue
        _halve(G, stack, top, axis)
        nodes += 2
        top += 2
    return best, max(bound, best), found, nodes
