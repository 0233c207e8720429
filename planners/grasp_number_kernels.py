"""Compiled: the numbers by which a two-finger grasp from straight above is judged, from heights about it.

Heights are taken on five lines along the closing direction, 5 mm apart, as wide as a finger. With the tips at t, a
depth below the point, the side of what is between the jaws is, on each line and to each side, where the height first
falls to t. From that follow the numbers `CLOSING`, without unit, each of the order of 1. Where the surface is flat, the
hand can press both tips on it and pinch, if it is cloth: `PINCHING`.
"""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray

CLOSING = (
    "clearance",  # height of the tips over what is under the fingers, of 5 mm
    "skew",  # larger angle of a side against the jaws, of the friction cone's
    "contact",  # share of the finger's width that touches, of the side with less
    "engaged",  # height of the side over the tips, of 10 mm, of the side with less
    "steepness",  # fall of the side within 5 mm, of 10 mm, of the side with less
    "width",  # of the opening
    "off_centre",  # of the middle between the sides, of 10 mm
    "unseen",  # share of the ground under a finger that no pixel showed, of the side with more
    "pinned",  # share of directions in which something rises at the end of the surface
    "palm",  # room under the palm, of 10 mm
)
PINCHING = (
    "uneven",  # difference of heights under and between the tips, of 10 mm
    "tilt",  # difference of what is highest under one tip and under the other, of 10 mm
    "longest",  # longest chord of the surface, of 200 mm
    "shortest",  # shortest chord, of 150 mm
    "pinned",  # as above
    "palm",  # as above
)
LINES, MIDDLE, _APART_M, _STEP_M, STEPS = 5, 2, 0.005, 0.0025, 25
REACH_M = (STEPS - 1) * _STEP_M
# All numbers here are ours.
# A side begins where the height is so near to the tips; the least depth of a grasp [m].
_SIDE_M, LEAST_M = 0.002, 0.006
# A finger that would come to lie so far within what was seen is stopped for certain [m].
_BURIED_M = -0.015
# A palm that would be so far in what is seen under it is stopped there; in room under it, of 10 mm.
_PALM_STOPS = -0.5
# A rise or fall that ends a surface, over which way, how far it is followed [m, m, steps], and in how many directions.
_JUMP_M, _RAY_M, _RAY_STEPS, _RAYS = 0.008, 0.004, 30, 16
# A pinch: jaws as for something so wide, tips so far below the surface, how uneven it may be [m]; the tips are
# between these steps to either side.
PINCH_WIDTH_M, PINCH_DEPTH_M, _UNEVEN_M, _PINCH_INNER, _PINCH_STEPS = 0.010, 0.006, 0.012, 6, 11
_PALM_M = 0.0125  # between places that are looked at under the palm: they reach a little beyond its edges
_BESIDE_PALM_M = 0.008


class Grid(NamedTuple):
    """A `HeightMap`: heights [m], whether seen, middle of the first cell [m], cells per metre."""

    heights: FloatArray
    seen: BoolArray
    x: float
    y: float
    per_m: float


class Claw(NamedTuple):
    """The hand and the table [m], see `planners.grasp_quality.JawSizes`.

    `palm` is its height over the tips, `cone` the friction cone's half angle [rad], `lowest` how low the tips may go,
    in the world.
    """

    opening: float
    room: float
    thickness: float
    palm: float
    palm_across: float
    palm_along: float
    cone: float
    lowest: float


class Spot(NamedTuple):
    """One place and angle.

    The point [m], cosine and sine of the angle; heights to both sides [m], shape (2, lines, steps). Around it, shape
    (4,): share of directions that end in a rise, longest and shortest chord, highest thing under the palm [m]; the
    first and the last are NaN until they are asked for. And at which step each line falls to the tips, shape
    (2, lines).
    """

    point: FloatArray
    cos: float
    sin: float
    profile: FloatArray
    around: FloatArray
    falls: IntArray


@numba.njit(cache=True, inline="always")
def _height(grid: Grid, x: float, y: float) -> float:
    """Height over a point, infinite outside the map."""
    i, j = (x - grid.x) * grid.per_m + 0.5, (y - grid.y) * grid.per_m + 0.5
    if i < 0.0 or j < 0.0 or i >= grid.heights.shape[0] or j >= grid.heights.shape[1]:
        return np.inf
    return float(grid.heights[int(i), int(j)])


@numba.njit(cache=True)
def take_lines(grid: Grid, spot: Spot, first: int, last: int) -> None:
    """Heights along lines `first` to `last` - 1, from the middle to both sides."""
    X, Y = grid.heights.shape
    reach = (STEPS * _STEP_M + MIDDLE * _APART_M) * grid.per_m
    i, j = (spot.point[0] - grid.x) * grid.per_m + 0.5, (spot.point[1] - grid.y) * grid.per_m + 0.5
    inside = i - reach >= 0.0 and j - reach >= 0.0 and i + reach < X and j + reach < Y
    for line in range(first, last):
        t = (line - MIDDLE) * _APART_M * grid.per_m
        for side in range(2):
            way = (1.0 - 2.0 * side) * _STEP_M * grid.per_m
            for k in range(STEPS):
                a, b = i + spot.cos * way * k - spot.sin * t, j + spot.sin * way * k + spot.cos * t
                if inside or (a >= 0.0 and b >= 0.0 and a < X and b < Y):
                    spot.profile[side, line, k] = grid.heights[int(a), int(b)]
                else:
                    spot.profile[side, line, k] = np.inf


@numba.njit(cache=True, inline="always")
def may_close(spot: Spot, claw: Claw, depths: FloatArray) -> bool:
    """Whether at some depth the middle line falls to both sides within the hand, and it is in their middle.

    Depths grow, so that each line falls no nearer than before.
    """
    spot.falls[:] = 0
    for wished in depths:
        tip = spot.point[2] - min(wished, spot.point[2] - claw.lowest)
        if spot.point[2] - tip >= LEAST_M and _is_between(spot, tip, claw):
            return True
    return False


@numba.njit(cache=True)
def _is_between(spot: Spot, tip: float, claw: Claw) -> bool:
    """Whether the hand is in the middle of the sides on the middle line, as far as its room allows, and can go down."""
    _follow_line(spot, 0, MIDDLE, tip + _SIDE_M)
    _follow_line(spot, 1, MIDDLE, tip + _SIDE_M)
    left, right = spot.falls[0, MIDDLE], spot.falls[1, MIDDLE]
    if min(left, right) < 1 or max(left, right) * _STEP_M > claw.opening / 2:
        return False
    if abs(left - right) * _STEP_M > claw.room:
        return False
    half = min((left + right - 1) * _STEP_M + claw.room, claw.opening) / 2
    return tip - _under_fingers(spot.profile, half, claw.thickness, (MIDDLE, MIDDLE + 1)) > _BURIED_M


@numba.njit(cache=True, inline="always")
def _follow_line(spot: Spot, side: int, line: int, level: float) -> None:
    """Go on along a line to the first step that is below a level; to the number of steps if there is none."""
    k = spot.falls[side, line]
    while k < STEPS and spot.profile[side, line, k] >= level:
        k += 1
    spot.falls[side, line] = k


@numba.njit(cache=True)
def closing_numbers(grid: Grid, spot: Spot, depth: float, claw: Claw, numbers: FloatArray) -> float:
    """Numbers `CLOSING` of a grasp; from one call to the next at the same spot depths must grow.

    Returns:
        What the jaws close on [m]; -1 if it is wider than the hand, or out of its middle, or skew beyond the cone,
        or the palm would be stopped.
    """
    tip = spot.point[2] - depth
    if not _is_between(spot, tip, claw):
        return -1.0
    for side in range(2):
        for line in range(LINES):
            _follow_line(spot, side, line, tip + _SIDE_M)
    left, right = _reach(spot.falls, 0), _reach(spot.falls, 1)
    width, skew = left + right, max(_skew(spot.falls, 0), _skew(spot.falls, 1))
    half = min(width + claw.room, claw.opening) / 2
    under = _under_fingers(spot.profile, half, claw.thickness, (0, LINES))
    if max(left, right) > half or skew > claw.cone or tip - under <= _BURIED_M:
        return -1.0
    palm = _palm_room(grid, tip, spot, claw)
    if palm <= _PALM_STOPS:
        return -1.0
    numbers[0], numbers[1] = min((tip - under) / 0.005, 1.0), skew / claw.cone
    numbers[2] = min(_contact(spot.falls, 0, left), _contact(spot.falls, 1, right))
    engaged_l, steep_l = _flank(spot, 0)
    engaged_r, steep_r = _flank(spot, 1)
    numbers[3] = min(engaged_l - tip, engaged_r - tip, 0.01) / 0.01
    numbers[4] = min(steep_l, steep_r, 0.01) / 0.01
    numbers[5], numbers[6] = width / claw.opening, abs(left - right) / 2 / 0.01
    numbers[7] = max(_unseen(grid, spot, 0, half, claw), _unseen(grid, spot, 1, half, claw))
    _look_around(grid, spot)
    numbers[8], numbers[9] = spot.around[0], palm
    return float(width)


@numba.njit(cache=True)
def _reach(falls: IntArray, side: int) -> float:
    """How far out a side is, where it is furthest [m]."""
    furthest = 0
    for line in range(LINES):
        furthest = max(furthest, falls[side, line])
    return (furthest - 0.5) * _STEP_M


@numba.njit(cache=True)
def _contact(falls: IntArray, side: int, reach: float) -> float:
    """Share of the lines on which a side is within 5 mm of where it is furthest."""
    touching = 0
    for line in range(LINES):
        touching += (falls[side, line] - 0.5) * _STEP_M > reach - _APART_M
    return float(touching / LINES)


@numba.njit(cache=True)
def _skew(falls: IntArray, side: int) -> float:
    """Angle of a side against the jaws [rad], between the last lines that it is on."""
    first, last = MIDDLE, MIDDLE
    while first > 0 and falls[side, first - 1] > 0:
        first -= 1
    while last < LINES - 1 and falls[side, last + 1] > 0:
        last += 1
    if last == first:
        return 0.0
    return float(abs(np.arctan((falls[side, last] - falls[side, first]) * _STEP_M / ((last - first) * _APART_M))))


@numba.njit(cache=True)
def _flank(spot: Spot, side: int) -> tuple[float, float]:
    """Height of a side's rim, and how far it falls within 5 mm, on the middle line [m]."""
    k = spot.falls[side, MIDDLE]
    rim = spot.profile[side, MIDDLE, max(k - 2, 0)]
    return max(rim, spot.profile[side, MIDDLE, k - 1]), rim - spot.profile[side, MIDDLE, k]


@numba.njit(cache=True)
def _under_fingers(profile: FloatArray, half: float, thickness: float, lines: tuple[int, int]) -> float:
    """Highest thing where the fingers come down, half the opening to each side, on some lines."""
    first, last = _finger_steps(half, thickness)
    highest = -np.inf
    for side in range(2):
        for line in range(lines[0], lines[1]):
            for k in range(first, last + 1):
                highest = max(highest, profile[side, line, k])
    return highest


@numba.njit(cache=True)
def _palm_room(grid: Grid, tip: float, spot: Spot, claw: Claw) -> float:
    """Height of the palm over what is highest under it, of 10 mm, within ±1; looked for once at each spot."""
    if np.isnan(spot.around[3]):
        spot.around[3] = _palm_top(grid, spot, claw)
    return float(min(max((tip + claw.palm - spot.around[3]) / 0.01, -1.0), 1.0))


@numba.njit(cache=True)
def _palm_top(grid: Grid, spot: Spot, claw: Claw) -> float:
    """Highest thing that was seen under the palm."""
    long = int((claw.palm_along + _BESIDE_PALM_M) / _PALM_M + 0.5)
    wide = int((claw.palm_across + _BESIDE_PALM_M) / _PALM_M + 0.5)
    top = -np.inf
    for i in range(-long, long + 1):
        for j in range(-wide, wide + 1):
            along, across_m = i * _PALM_M, j * _PALM_M
            x = spot.point[0] + spot.cos * along - spot.sin * across_m
            height = _height(grid, x, spot.point[1] + spot.sin * along + spot.cos * across_m)
            if height < np.inf:  # what nobody saw is not taken for high: the palm is far up
                top = max(top, height)
    return top


@numba.njit(cache=True)
def _unseen(grid: Grid, spot: Spot, side: int, half: float, claw: Claw) -> float:
    """Share of the places where a finger comes down that no pixel showed; outside the map none did."""
    first, last = _finger_steps(half, claw.thickness)
    sign, unseen = 1.0 - 2.0 * side, 0
    for line in range(LINES):
        t = (line - MIDDLE) * _APART_M
        for k in range(first, last + 1):
            along = sign * k * _STEP_M
            i = (spot.point[0] + spot.cos * along - spot.sin * t - grid.x) * grid.per_m + 0.5
            j = (spot.point[1] + spot.sin * along + spot.cos * t - grid.y) * grid.per_m + 0.5
            inside = i >= 0.0 and j >= 0.0 and i < grid.seen.shape[0] and j < grid.seen.shape[1]
            unseen += not (inside and grid.seen[int(i), int(j)])
    return float(unseen / (LINES * (last - first + 1)))


@numba.njit(cache=True)
def _finger_steps(half: float, thickness: float) -> tuple[int, int]:
    """First and last step of a finger that stands half an opening from the middle."""
    first, last = int(np.ceil(half / _STEP_M - 1e-6)), int(np.ceil((half + thickness) / _STEP_M - 1e-6))
    return first, min(last, STEPS - 1)


@numba.njit(cache=True, inline="always")
def is_even(spot: Spot, first: int, last: int) -> bool:
    """Whether heights on lines under and between the tips differ little."""
    return _unevenness(spot, first, last) < _UNEVEN_M


@numba.njit(cache=True)
def _unevenness(spot: Spot, first: int, last: int) -> float:
    """Largest difference of heights on lines under and between the tips [m]."""
    lowest, highest = np.inf, -np.inf
    for side in range(2):
        for line in range(first, last):
            for k in range(_PINCH_STEPS + 1):
                lowest, highest = min(lowest, spot.profile[side, line, k]), max(highest, spot.profile[side, line, k])
    return highest - lowest


@numba.njit(cache=True)
def pinching_numbers(grid: Grid, spot: Spot, claw: Claw, numbers: FloatArray) -> bool:
    """Numbers `PINCHING`, the rest 0; False if the surface is not even enough, or stops the palm."""
    uneven = _unevenness(spot, 0, LINES)
    if not uneven < _UNEVEN_M:
        return False
    palm = _palm_room(grid, spot.point[2] - PINCH_DEPTH_M, spot, claw)
    if palm <= _PALM_STOPS:
        return False
    _look_around(grid, spot)
    numbers[:] = 0.0
    numbers[0], numbers[1] = uneven / 0.01, _tilt(spot) / 0.01
    numbers[2], numbers[3], numbers[4] = spot.around[1] / 0.2, spot.around[2] / 0.15, spot.around[0]
    numbers[5] = palm
    return True


@numba.njit(cache=True)
def _tilt(spot: Spot) -> float:
    """How much later one tip touches than the other [m]."""
    tops = np.full(2, -np.inf)
    for side in range(2):
        for line in range(LINES):
            for k in range(_PINCH_INNER, _PINCH_STEPS + 1):
                tops[side] = max(tops[side], spot.profile[side, line, k])
    return float(abs(tops[0] - tops[1]))


@numba.njit(cache=True)
def _look_around(grid: Grid, spot: Spot) -> None:
    """Follow the surface in all directions, unless that was done for the same point; sum up where it ends."""
    around, half = spot.around, _RAYS // 2
    if not np.isnan(around[0]):
        return
    around[0], around[1], around[2] = 0.0, 0.0, np.inf
    for n in range(half):
        ahead, rises_ahead = _follow_surface(grid, spot.point, 2 * np.pi * n / _RAYS)
        behind, rises_behind = _follow_surface(grid, spot.point, 2 * np.pi * (n + half) / _RAYS)
        around[1], around[2] = max(around[1], ahead + behind), min(around[2], ahead + behind)
        around[0] += (rises_ahead + rises_behind) / _RAYS


@numba.njit(cache=True)
def _follow_surface(grid: Grid, point: FloatArray, angle: float) -> tuple[float, float]:
    """How far the surface goes in a direction [m], and 1 where something rises at its end."""
    dx, dy, here = _RAY_M * np.cos(angle), _RAY_M * np.sin(angle), point[2]
    for k in range(1, _RAY_STEPS + 1):
        height = _height(grid, point[0] + dx * k, point[1] + dy * k)
        if abs(height - here) > _JUMP_M:
            return (k - 0.5) * _RAY_M, 1.0 if height > here else 0.0
        here = height
    return _RAY_STEPS * _RAY_M, 0.0
