"""Branch and bound for the pose that meets the most comparisons, compiled.

Every row is one comparison as a signed distance, in metres, that must not be positive:

    v(x, y, θ) = n · [x, y] + g₂ cos θ + g₃ sin θ - β,      |n| = 1.

Over a box of poses, middle ± half, v differs from its value in the middle by at most

    |n_x| half_x + |n_y| half_y + |g'(θ)| half_θ + |g| half_θ² / 2.

So each row is met everywhere in the box, met nowhere, or open. No pose of the box meets more rows than are met
everywhere or open: the box's bound. The box with the highest bound is halved next, so that no box is halved
whose bound lies below the best pose; among equals, the newest.
"""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray


class _Queue(NamedTuple):
    """Boxes by their bound: for each bound a chain of boxes, the newest first."""

    boxes: FloatArray  # middle (x, y, θ) and half sizes, shape (S, 6)
    behind: IntArray  # next box of the chain, -1 at its end, shape (S,)
    first: IntArray  # first box for each bound, -1 if there is none, shape (M + 1,)
    size: IntArray  # how many boxes were ever put in, shape (1,)


class _Best(NamedTuple):
    """The most rows met so far, and one pose for each different set of rows that reaches it."""

    met: IntArray  # shape (1,)
    found: IntArray  # number of poses, shape (1,)
    poses: FloatArray  # shape (P, 3)
    keys: IntArray  # fingerprint of each pose's set of rows, shape (P,)


@numba.njit(cache=True, error_model="numpy")
def _judge(G: FloatArray, prints: IntArray, box: FloatArray) -> tuple[int, int, int, int]:
    """Bound of a box, number of open rows, rows met in the middle, and the fingerprint of these."""
    c, s = np.cos(box[2]), np.sin(box[2])
    bound, still_open, middle, key = 0, 0, 0, 0
    for m in range(G.shape[0]):
        value = G[m, 0] * box[0] + G[m, 1] * box[1] + G[m, 2] * c + G[m, 3] * s - G[m, 4]
        turn = abs(G[m, 3] * c - G[m, 2] * s) + 0.5 * G[m, 5] * box[5]
        reach = abs(G[m, 0]) * box[3] + abs(G[m, 1]) * box[4] + turn * box[5]
        if value <= 0.0:
            middle += 1
            key += prints[m]
        bound += value <= reach
        still_open += abs(value) < reach
    return bound, still_open, middle, key


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
def _record(best: _Best, pose: FloatArray, met: int, key: int) -> None:
    """Remember a pose that meets more rows than any before, or as many but others."""
    if met > best.met[0]:
        best.met[0], best.found[0] = met, 0
    if met < best.met[0] or best.found[0] == len(best.poses):
        return
    for known in range(best.found[0]):
        if best.keys[known] == key:
            return
    best.poses[best.found[0]] = pose
    best.keys[best.found[0]] = key
    best.found[0] += 1


@numba.njit(cache=True, error_model="numpy")
def _put(G: FloatArray, prints: IntArray, box: FloatArray, queue: _Queue, best: _Best) -> None:
    """Judge a box and put it in the queue, unless nothing in it can compete or nothing in it is open."""
    bound, still_open, middle, key = _judge(G, prints, box)
    _record(best, box[:3], middle, key)
    if bound >= best.met[0] and still_open > 0:
        slot = queue.size[0]
        queue.boxes[slot] = box
        queue.behind[slot] = queue.first[bound]
        queue.first[bound] = slot
        queue.size[0] += 1


@numba.njit(cache=True, error_model="numpy")
def _put_roots(G: FloatArray, prints: IntArray, bounds: FloatArray, queue: _Queue, best: _Best) -> None:
    """Cover all poses: the whole rectangle, with the circle cut into ranges of θ if any row names θ."""
    count, box = 16 if G[:, 5].max() > 0.0 else 1, np.zeros(6)
    box[:2] = (bounds[:, 0] + bounds[:, 1]) / 2.0
    box[3:5] = (bounds[:, 1] - bounds[:, 0]) / 2.0
    box[5] = np.pi / count if count > 1 else 0.0
    for r in range(count):
        box[2] = (2 * r + 1) * np.pi / count - np.pi if count > 1 else 0.0
        _put(G, prints, box, queue, best)


@numba.njit(cache=True, error_model="numpy")
def search(
    G: FloatArray, prints: IntArray, bounds: FloatArray, leaf: FloatArray, max_boxes: int, poses: FloatArray
) -> tuple[int, int, int, int]:
    """Find poses that meet the most rows: one for each different set of rows that reaches the maximum.

    Args:
        G: Rows [n_x, n_y, g₂, g₃, β, |g|], shape (M, 6).
        prints: A random number for each row; their sum over the rows that a pose meets tells sets apart, shape (M,).
        bounds: Where the centre may lie [[xmin, xmax], [ymin, ymax]] [m], shape (2, 2).
        leaf: Half sizes (x, y, θ) of a box that is not halved any more [m, m, rad], shape (3,).
        max_boxes: Boxes to keep before giving up, at least 64.
        poses: Filled with poses (x, y, θ), shape (P, 3).

    Returns:
        Largest number met, a bound on it that no pose exceeds, how many poses were filled in, boxes kept.
    """
    M, lever = G.shape[0], G[:, 5].max()
    one = np.zeros(1, dtype=np.int64)
    behind = np.empty(max_boxes, dtype=np.int64)
    queue = _Queue(np.empty((max_boxes, 6)), behind, np.full(M + 1, -1), one)
    best = _Best(one.copy(), one.copy(), poses, np.zeros(len(poses), dtype=np.int64))
    _put_roots(G, prints, bounds, queue, best)
    highest, bound = M, 0
    while highest >= best.met[0]:
        slot = queue.first[highest]
        if slot < 0:
            highest -= 1
            continue
        queue.first[highest] = queue.behind[slot]
        box = queue.boxes[slot].copy()
        axis = _widest(box, leaf, lever)
        if axis < 0:
            bound = max(bound, highest)
            continue
        if queue.size[0] + 2 > max_boxes:
            bound = max(bound, highest)
            break
        box[3 + axis] /= 2.0
        box[axis] -= box[3 + axis]
        _put(G, prints, box, queue, best)
        box[axis] += 2.0 * box[3 + axis]
        _put(G, prints, box, queue, best)
    return best.met[0], max(bound, best.met[0]), best.found[0], queue.size[0]
