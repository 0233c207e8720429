"""Legs of the antenna in any direction between obstacles, for where an L along the walls has no room.

What a leg can tell about a place is measured by the information of its phases. At antenna position s, seen from the
place in direction u(s) from distance d(s), the phase changes with the place as 2k u(s), and reflections are as loud as
the tag is weak, so that a sample counts 1/d². The phase of a whole leg is not known; what is left is

    J = Σ_legs ∫ (u - ū)(u - ū)ᵀ / d² ds,    ū the mean of u over the leg with the same weights,

and a track is worth the smaller eigenvalue of J: what it tells along the worst direction. All of this is ours.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray

# Ours. Directions, distances from the part, and the least length of legs that are tried; how many make a track; by what
# they must differ; and samples along a leg.
DIRECTIONS_RAD = np.radians(np.arange(0.0, 180.0, 15.0))
STAND_OFFS_M = np.arange(1.0, 2.25, 0.1)
SHORTEST_M = 0.8
LEGS = 4
DIFFERENT_RAD, DIFFERENT_M = np.radians(30.0), 0.6
_SAMPLES = 15
_EDGE_M = 1e-9  # rounding


@dataclass(frozen=True, slots=True, kw_only=True)
class Corridor:
    """Where the antenna may be.

    Attributes:
        low_m: Least x, y [m], shape (2,).
        high_m: Largest x, y [m], shape (2,).
        blocks_m: Rectangles that it must not enter, its own size allowed for: least and largest x, y, shape (B, 2, 2).
        height_m: Its height [m].
        length_m: Length of a leg, where there is room [m].
    """

    low_m: FloatArray
    high_m: FloatArray
    blocks_m: FloatArray
    height_m: float
    length_m: float


def track_information(part_m: FloatArray, legs_m: FloatArray) -> float:
    """What a track tells about a place along the worst direction, the smaller eigenvalue of J [1/m].

    Args:
        part_m: The place [m], shape (2,).
        legs_m: Start and end of each leg [m], shape (L, 2, 3).
    """
    return float(np.linalg.eigvalsh(_information(part_m, legs_m).sum(axis=0))[0])


def free_tracks_m(part_m: FloatArray, corridor: Corridor) -> Iterator[FloatArray]:
    """Find tracks of two to four legs for a place, the most telling one first.

    A track begins with the pair of legs that tells most, and takes the leg that adds most, twice. Legs of one track,
    and of one track and the next, differ in direction or place, as reflections are others only from elsewhere.

    Args:
        part_m: The place [m], shape (2,).
        corridor: Where legs may lie.

    Yields:
        Start and end of each leg [m], shape (L, 2, 3).
    """
    legs = list(_free_legs(part_m, corridor))
    legs_m = np.array(legs).reshape(-1, 2, 3)
    J, alike = _information(part_m, legs_m), _alike(legs_m)
    left = np.ones(len(legs), dtype=bool)
    while (pair := _best_pair(J, left & ~alike.all(axis=1), alike)) is not None:
        chosen = list(pair)
        while len(chosen) < LEGS:
            others = np.flatnonzero(left & ~alike[chosen].any(axis=0))
            if not others.size:
                break
            chosen.append(int(others[_smaller_eigenvalue(J[chosen].sum(axis=0) + J[others]).argmax()]))
        left &= ~alike[chosen].any(axis=0)
        yield legs_m[chosen]


def _best_pair(J: FloatArray, left: BoolArray, alike: BoolArray) -> tuple[int, int] | None:
    """The two legs, of those left, that tell most together; None if there are no two."""
    one, other = np.nonzero(np.triu(left[:, None] & left & ~alike, 1))
    if not one.size:
        return None
    best = int(_smaller_eigenvalue(J[one] + J[other]).argmax())
    return int(one[best]), int(other[best])


def _alike(legs_m: FloatArray) -> BoolArray:
    """True for each two legs that hardly differ, shape (L, L)."""
    along_m, middle_m = (legs_m[:, 1] - legs_m[:, 0])[:, :2], legs_m[:, :, :2].mean(axis=1)
    u = along_m / np.linalg.norm(along_m, axis=1)[:, None]
    parallel = np.abs(u @ u.T) > np.cos(DIFFERENT_RAD)
    near = np.linalg.norm(middle_m[:, None] - middle_m, axis=2) < DIFFERENT_M
    return np.asarray(parallel & near)


def _information(part_m: FloatArray, legs_m: FloatArray) -> FloatArray:
    """J of each leg, shape (L, 2, 2)."""
    share = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    start_m, end_m = legs_m[:, 0, :2], legs_m[:, 1, :2]
    away_m = start_m[:, None] + share[:, None] * (end_m - start_m)[:, None] - part_m
    d_m = np.linalg.norm(away_m, axis=2)
    u = away_m / d_m[..., None]
    weight = np.linalg.norm(end_m - start_m, axis=1)[:, None] / _SAMPLES / d_m**2
    mean = (weight[..., None] * u).sum(axis=1) / weight.sum(axis=1)[:, None]
    spread = u - mean[:, None]
    return np.asarray(np.einsum("ls,lsi,lsj->lij", weight, spread, spread))


def _smaller_eigenvalue(J: FloatArray) -> FloatArray:
    half_trace = (J[:, 0, 0] + J[:, 1, 1]) / 2
    det = J[:, 0, 0] * J[:, 1, 1] - J[:, 0, 1] ** 2
    return np.asarray(half_trace - np.sqrt(np.maximum(half_trace**2 - det, 0.0)))


def _free_legs(part_m: FloatArray, corridor: Corridor) -> Iterator[FloatArray]:
    """A leg in each gap between obstacles, along every line that passes the place, shape (2, 3) each."""
    for angle in DIRECTIONS_RAD:
        along = np.array([np.cos(angle), np.sin(angle)])
        for stand_off_m in (*STAND_OFFS_M, *-STAND_OFFS_M):
            foot_m = part_m + stand_off_m * np.array([-along[1], along[0]])
            for low, high in gaps(foot_m, along, corridor):
                if high - low >= SHORTEST_M:
                    ends_m = foot_m + span(0.0, low, high, corridor.length_m)[:, None] * along
                    yield np.column_stack([ends_m, np.full(2, corridor.height_m)])


def span(middle_m: float, low_m: float, high_m: float, length_m: float) -> FloatArray:
    """Interval of a length inside another one, its middle as near as possible to a place, shape (2,)."""
    half_m = min(length_m, high_m - low_m) / 2
    centre_m = min(max(middle_m, low_m + half_m), high_m - half_m)
    return np.array([centre_m - half_m, centre_m + half_m])


def gaps(foot_m: FloatArray, along: FloatArray, corridor: Corridor) -> Iterator[tuple[float, float]]:
    """Free intervals of a line, measured from its foot [m], in ascending order.

    Args:
        foot_m: A point of the line [m], shape (2,); a line along an edge of the corridor is inside.
        along: Its direction, of length one, shape (2,).
        corridor: Where it may be.
    """
    room = np.array([[corridor.low_m, corridor.high_m]])
    enters, leaves = _crossings(foot_m, along, np.concatenate([room, corridor.blocks_m]))
    at, end = float(enters[0]), float(leaves[0])
    met = np.flatnonzero(enters[1:] < leaves[1:]) + 1
    for block in met[np.argsort(enters[met], kind="stable")]:
        if enters[block] > at:
            yield at, min(float(enters[block]), end)
        at = max(at, float(leaves[block]))
    if end > at:
        yield at, end


def _crossings(foot_m: FloatArray, along: FloatArray, boxes_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where a line enters and leaves each rectangle [m]; it enters after it leaves where it misses it, shape (B,)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = (boxes_m - foot_m) / along
    beside = np.abs(along) < 1e-12
    inside = (boxes_m[:, 0] < foot_m) & (foot_m < boxes_m[:, 1])
    inside[0] = (boxes_m[0, 0] - _EDGE_M <= foot_m) & (foot_m <= boxes_m[0, 1] + _EDGE_M)  # the room, its edge included
    low = np.where(beside, np.where(inside, -np.inf, np.inf), ends.min(axis=1))
    high = np.where(beside, np.where(inside, np.inf, -np.inf), ends.max(axis=1))
    return low.max(axis=1), high.min(axis=1)
