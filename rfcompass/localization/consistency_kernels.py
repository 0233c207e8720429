"""Branch and bound for the poses that meet the most comparisons, compiled.

The box of poses with the highest bound is halved next, the newest among equals, so that no box is halved whose
bound lies below the best pose. `consistency_boxes` bounds a box from above and finds poses in it.

A box is done with when its bound lies below the best pose. It is done with as well when it can only tie with the
best by meeting one certain set of rows, all that are not broken everywhere in it, and a pose that meets just
these is known: no surface of a best cell is followed. So the search ends by itself with all best cells, and a
smallest box is needed only where cells are thinner than it.
"""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.localization.consistency_boxes import (
    FEW_ROWS,
    RowArray,
    Rows,
    Scratch,
    agreeable_pose,
    contradictions,
    count_met,
    make_scratch,
    most_broken_first,
    sort_rows,
)

_ROOTS = 4  # ranges of θ to start from (ours)
_MET, _KEY, _FULL_KEY, _START, _COUNT, _BEHIND = range(6)  # columns of `_Queue.facts`


class SearchResult(NamedTuple):
    """What a search found and what it proved.

    Attributes:
        met: Largest number of rows met.
        bound: No pose meets more than that.
        found: How many poses were filled in, one for each set of rows that reaches `met`.
        undecided: How often a box was left in which further such sets may hide: too small to halve, or the one at
            which the search broke off.
        boxes: Boxes kept.
    """

    met: int
    bound: int
    found: int
    undecided: int
    boxes: int


class _Queue(NamedTuple):
    """Boxes by their bound: for each bound a chain of boxes, the newest first."""

    boxes: FloatArray  # middle (x, y, θ) and half sizes, shape (S, 6)
    facts: IntArray  # rows met everywhere, their fingerprint, the same with the open ones, where these start in
    # `open`, how many they are, next box of the chain or -1; shape (S, 6)
    open: RowArray  # open rows of all boxes, one after the other
    first: IntArray  # first box for each bound, -1 if there is none, shape (M + 1,)
    size: IntArray  # how many boxes, and how many entries of `open`, were ever put in, shape (2,)


class _Best(NamedTuple):
    """The most rows met so far, and one pose for each different set of rows that reaches it."""

    met: IntArray  # shape (1,)
    found: IntArray  # number of poses, shape (1,)
    poses: FloatArray  # shape (P, 3)
    keys: IntArray  # fingerprint of each pose's set of rows, shape (P,)


@numba.njit(cache=True, error_model="numpy")
def _is_known(best: _Best, key: int) -> bool:
    return bool((best.keys[: best.found[0]] == key).any())


@numba.njit(cache=True, error_model="numpy")
def _record(best: _Best, pose: FloatArray, met: int, key: int) -> None:
    """Remember a pose that meets more rows than any before, or as many but others."""
    if met > best.met[0]:
        best.met[0], best.found[0] = met, 0
    if met < best.met[0] or best.found[0] == len(best.poses) or _is_known(best, key):
        return
    best.poses[best.found[0]] = pose
    best.keys[best.found[0]] = key
    best.found[0] += 1


@numba.njit(cache=True, error_model="numpy")
def _judge(
    rows: Rows, candidates: RowArray, base: tuple[int, int], box: FloatArray, scratch: Scratch, best: _Best
) -> tuple[int, int, int, int, int]:
    """Record the poses found in a box, and tell what it can hold.

    Args:
        rows: All rows.
        candidates: Those that are open in a larger box.
        base: How many others are met everywhere, and their fingerprint.
        box: Middle and half sizes.
        scratch: Filled with the open rows.
        best: Best poses.

    Returns:
        Bound, or -1 if the box is done with; rows met everywhere, their fingerprint, the same with all open rows,
        and how many rows are open.
    """
    met, key, count, open_key = sort_rows(rows, candidates, box, scratch)
    met += base[0]
    key += base[1]
    bound, full_key, done = met + count, key + open_key, (-1, 0, 0, 0, 0)
    scratch.pose[0], scratch.pose[1], scratch.pose[2] = box[0], box[1], box[2]
    more, its_key = count_met(rows, count, scratch)
    _record(best, scratch.pose, met + more, key + its_key)
    if bound < best.met[0] or count == 0 or (bound == best.met[0] and _is_known(best, full_key)):
        return done
    if count <= FEW_ROWS:
        most_broken_first(count, scratch)
        bound -= contradictions(rows, count, box, scratch, bound - best.met[0] + 1)
        if bound < best.met[0]:
            return done
        agreeable_pose(rows, count, box, scratch)
        more, its_key = count_met(rows, count, scratch)
        _record(best, scratch.pose, met + more, key + its_key)
    return bound, met, key, full_key, count


@numba.njit(cache=True, error_model="numpy")
def _with_room(queue: _Queue, entries: int) -> _Queue:
    """The same queue with room for so many more open rows."""
    used = queue.size[1]
    if used + entries <= queue.open.size:
        return queue
    larger = np.empty(2 * (used + entries), dtype=np.int32)
    larger[:used] = queue.open[:used]
    return _Queue(queue.boxes, queue.facts, larger, queue.first, queue.size)


@numba.njit(cache=True, error_model="numpy")
def _put(
    queue: _Queue, box: FloatArray, verdict: tuple[int, int, int, int, int], ceiling: int, scratch: Scratch
) -> None:
    """Put a box that was judged into the queue, in front of those with the same bound, which `ceiling` limits."""
    bound, met, key, full_key, count = verdict
    bound = min(bound, ceiling)
    slot, start = queue.size
    queue.boxes[slot] = box
    facts = queue.facts[slot]
    facts[_MET], facts[_KEY], facts[_FULL_KEY] = met, key, full_key
    facts[_START], facts[_COUNT], facts[_BEHIND] = start, count, queue.first[bound]
    queue.open[start : start + count] = scratch.row[:count]
    queue.first[bound] = slot
    queue.size[0] += 1
    queue.size[1] += count


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
def _roots(bounds: FloatArray, lever: float) -> FloatArray:
    """Cover all poses: the whole rectangle, with the circle cut into ranges of θ if any row names θ."""
    count = _ROOTS if lever > 0.0 else 1
    boxes = np.zeros((count, 6))
    boxes[:, :2] = (bounds[:, 0] + bounds[:, 1]) / 2.0
    boxes[:, 3:5] = (bounds[:, 1] - bounds[:, 0]) / 2.0
    if count > 1:
        boxes[:, 2] = (2 * np.arange(count) + 1) * np.pi / count - np.pi
        boxes[:, 5] = np.pi / count
    return boxes


@numba.njit(cache=True, error_model="numpy")
def _halve(box: FloatArray, axis: int, parts: FloatArray) -> None:
    """Cut a box in two along an axis."""
    for d in range(6):
        parts[0, d] = parts[1, d] = box[d] / (2.0 if d == 3 + axis else 1.0)
    parts[0, axis] -= parts[0, 3 + axis]
    parts[1, axis] += parts[1, 3 + axis]


@numba.njit(cache=True, error_model="numpy")
def _take(queue: _Queue, best: _Best, highest: int) -> tuple[int, int]:
    """Take out the box with the highest bound, -1 if none can compete any more; and its bound."""
    while highest >= best.met[0]:
        slot = queue.first[highest]
        if slot < 0:
            highest -= 1
            continue
        facts = queue.facts[slot]
        queue.first[highest] = facts[_BEHIND]
        ties_once = highest == best.met[0] == facts[_MET] + facts[_COUNT]
        if not (ties_once and _is_known(best, facts[_FULL_KEY])):
            return slot, highest
    return -1, highest


@numba.njit(cache=True, error_model="numpy")
def _judge_all(
    rows: Rows, boxes: FloatArray, parent: IntArray, ceiling: int, queue: _Queue, scratch: Scratch, best: _Best
) -> _Queue:
    """Judge the parts of a box, whose bound is `ceiling`, and put those into the queue that can compete."""
    start, stop = parent[_START], parent[_START] + parent[_COUNT]
    for box in boxes:
        queue = _with_room(queue, parent[_COUNT])
        verdict = _judge(rows, queue.open[start:stop], (parent[_MET], parent[_KEY]), box, scratch, best)
        if verdict[0] >= 0:
            _put(queue, box, verdict, ceiling, scratch)
    return queue


@numba.njit(cache=True, error_model="numpy")
def search(
    G: FloatArray, prints: IntArray, bounds: FloatArray, leaf: FloatArray, max_boxes: int, poses: FloatArray
) -> SearchResult:
    """Find poses that meet the most rows: one for each different set of rows that reaches the maximum.

    Args:
        G: Rows [n_x, n_y, g₂, g₃, β, |g|], shape (M, 6).
        prints: A random number for each row; their sum over the rows that a pose meets tells sets apart, shape (M,).
        bounds: Where the centre may lie [m], [[xmin, xmax], [ymin, ymax]], shape (2, 2).
        leaf: Half sizes (x, y, θ) of a box that is not halved any more [m, m, rad], shape (3,).
        max_boxes: Boxes to keep before giving up, at least 64.
        poses: Filled with poses (x, y, θ), shape (P, 3).
    """
    M, lever, rows, scratch = len(G), G[:, 5].max(), Rows(G, prints), make_scratch(len(G))
    one = np.zeros(1, dtype=np.int64)
    best = _Best(one.copy(), one.copy(), poses, np.zeros(len(poses), dtype=np.int64))
    all_rows, used = np.arange(M).astype(np.int32), np.array([0, M])
    facts = np.empty((max_boxes, 6), dtype=np.int64)
    queue = _Queue(np.empty((max_boxes, 6)), facts, all_rows, np.full(M + 1, -1), used)
    everything = np.array([0, 0, 0, 0, M, -1])
    queue = _judge_all(rows, _roots(bounds, lever), everything, M, queue, scratch, best)
    bound, undecided, parts = 0, 0, np.empty((2, 6))
    slot, highest = _take(queue, best, M)
    while slot >= 0:
        box = queue.boxes[slot]
        axis = _widest(box, leaf, lever)
        hopeless = highest == best.met[0] and best.found[0] == len(poses)  # more ties than are asked for
        if axis < 0 or hopeless or queue.size[0] + 2 > max_boxes:
            bound = max(bound, highest)
            undecided += 1
            if axis >= 0:
                break
        else:
            _halve(box, axis, parts)
            queue = _judge_all(rows, parts, queue.facts[slot], highest, queue, scratch, best)
        slot, highest = _take(queue, best, highest)
    return SearchResult(best.met[0], max(bound, best.met[0]), best.found[0], undecided, queue.size[0])
