"""Straight legs of an antenna path: an L has two, a square four.

A far-field profile needs a straight track, and an image gains most from a second track at an angle to the first. So a
bent path is cut at its corners. Candidates are found as by Douglas and Peucker: a stretch that leaves its chord is cut
at its farthest position, again and again. Noise of the positions moves such a cut by a position or two; each is then
put where the lines fitted to both sides leave the least squares. A jump, as to another height, is a cut as well.

A curve can be cut into short chords as well. It is told from a polygon by its turns: around a corner of a polygon the
legs stay straight, whereas a chord of a circle turns as far along itself as at its end.
"""

from functools import lru_cache
from itertools import pairwise

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.errors import UnsuitablePath

LEAST_POSITIONS = 3  # of a leg: two are always on a line
LEAST_TURN_RAD = np.pi / 8  # ours: where two legs turn by less, the path is bent, not cornered
CURVED_SHARE = 0.5  # ours: a leg may turn this share of the corner next to it; an arc turns the whole of it
LARGE_JUMP = 3.0  # ours: a step that is so many times the median step joins two legs that need not turn
AREA_RATIO = 0.1  # ours: a path spans two directions if it is at least this wide for its length
KEPT_PATHS = 32  # ours: all tags of a scan have one path, a dozen of them at a time at most a few heights


def straight_legs(positions_m: FloatArray, tolerance_m: float) -> list[IntArray]:
    """Cut a path into straight legs.

    Args:
        positions_m: Antenna positions in the order of the path [m], shape (L, 3).
        tolerance_m: How far a position may be from the line of its leg [m].

    Returns:
        Row indices of each leg, in the order of the path; together they are all L positions.

    Raises:
        UnsuitablePath: If a leg is not straight within the tolerance, or the path is a curve.
    """
    return list(_straight_legs(np.ascontiguousarray(positions_m, dtype=np.float64).tobytes(), tolerance_m))


@lru_cache(maxsize=KEPT_PATHS)
def _straight_legs(positions: bytes, tolerance_m: float) -> tuple[IntArray, ...]:
    """`straight_legs` of positions as bytes, so that the path that all tags of a scan share is cut once."""
    positions_m = np.frombuffer(positions).reshape(-1, 3)
    rows = np.arange(len(positions_m))
    rows.flags.writeable = False
    if bend_m(positions_m) <= tolerance_m:
        return (rows,)
    bounds = _settled(positions_m, [0, *_farthest_cuts(positions_m, tolerance_m), len(positions_m)])
    found = np.split(rows, _needed(positions_m, bounds, tolerance_m)[1:-1])
    _check_straight(positions_m, found, tolerance_m)
    _check_corners(positions_m, found)
    return tuple(found)


def bend_m(positions_m: FloatArray) -> float:
    """Largest distance of a position from the line fitted through all of them [m]."""
    centred = positions_m - positions_m.mean(axis=0)
    direction = np.linalg.svd(centred, full_matrices=False)[2][0]
    return float(np.linalg.norm(centred - np.outer(centred @ direction, direction), axis=1).max())


def spans_two_directions(positions_m: FloatArray) -> bool:
    """True if a path is no line: at least a tenth as wide as it is long; positions (L, 3) [m]."""
    spread = np.linalg.svd(positions_m - positions_m.mean(axis=0), compute_uv=False)
    return bool(spread.size > 1 and spread[1] >= AREA_RATIO * spread[0] and spread[1] > 0)


def _farthest_cuts(positions_m: FloatArray, tolerance_m: float) -> list[int]:
    """First row of each leg but the first: behind jumps, and where stretches are cut until none leaves its chord."""
    jumps = (np.flatnonzero(_jumps(positions_m)) + 1).tolist()
    cuts, stretches = list(jumps), list(zip([0, *jumps], [*jumps, len(positions_m)], strict=True))
    while stretches:
        first, end = stretches.pop()
        away_m = _from_chord_m(positions_m[first:end])
        if away_m.size and away_m.max() > tolerance_m:
            corner = first + int(away_m.argmax())
            cuts.append(corner)
            stretches += [(first, corner + 1), (corner, end)]
    return sorted(cuts)


def _jumps(positions_m: FloatArray) -> BoolArray:
    """True for each step that is far longer than the others, shape (L-1,); staying in a place is no step."""
    steps_m = np.linalg.norm(np.diff(positions_m, axis=0), axis=1)
    usual_m = np.median(steps_m[steps_m > 0]) if steps_m.any() else 0.0
    return np.asarray(steps_m > LARGE_JUMP * usual_m)


def _from_chord_m(positions_m: FloatArray) -> FloatArray:
    """Distance of each position from the line through both ends, or from the start if the ends meet [m]."""
    if len(positions_m) < LEAST_POSITIONS:
        return np.zeros(0)
    away, chord = positions_m - positions_m[0], positions_m[-1] - positions_m[0]
    length_m = np.linalg.norm(chord)
    if length_m > 1e-2 * np.linalg.norm(away, axis=1).max():
        away = away - np.outer(away @ chord, chord) / length_m**2
    return np.asarray(np.linalg.norm(away, axis=1))


def _settled(positions_m: FloatArray, bounds: list[int]) -> list[int]:
    """Move each bound between two stretches by a few rows to where the lines of both sides fit best."""
    bounds = list(bounds)
    for place in range(1, len(bounds) - 1):
        before, after = bounds[place - 1], bounds[place + 1]
        near = range(bounds[place] - LEAST_POSITIONS, bounds[place] + LEAST_POSITIONS + 1)
        choice = [cut for cut in near if before + LEAST_POSITIONS <= cut <= after - LEAST_POSITIONS]
        if choice:
            rests = [_rest(positions_m[before:cut]) + _rest(positions_m[cut:after]) for cut in choice]
            bounds[place] = choice[int(np.argmin(rests))]
    return bounds


def _needed(positions_m: FloatArray, bounds: list[int], tolerance_m: float) -> list[int]:
    """Drop each bound without which, its neighbours settled again, the stretches are straight as well.

    Noise can cut a sharp corner before and behind its tip; without one of both the other one finds it.
    """
    place = 1
    while place < len(bounds) - 1:
        first, end = max(place - 2, 0), place + 3
        fewer = _settled(positions_m, [*bounds[first:place], *bounds[place + 1 : end]])
        if all(bend_m(positions_m[slice(*leg)]) <= tolerance_m for leg in pairwise(fewer)):
            bounds = [*bounds[:first], *fewer, *bounds[end:]]
            place = max(place - 1, 1)
        else:
            place += 1
    return bounds


def _rest(positions_m: FloatArray) -> float:
    """Sum of squared distances from the fitted line [m²]."""
    spread = np.linalg.svd(positions_m - positions_m.mean(axis=0), compute_uv=False)
    return float((spread[1:] ** 2).sum())


def _check_straight(positions_m: FloatArray, found: list[IntArray], tolerance_m: float) -> None:
    for leg in found:
        if len(leg) < LEAST_POSITIONS or (bend := bend_m(positions_m[leg])) > tolerance_m:
            bend = bend_m(positions_m)
            message = f"the antenna path leaves a straight line by {bend:.3f} m and has no straight legs either"
            raise UnsuitablePath(f"{message}; use a phase meter", bend_m=bend, allowed_m=tolerance_m)


def _check_corners(positions_m: FloatArray, found: list[IntArray]) -> None:
    jumps = _jumps(positions_m)
    for one, other in pairwise(found):
        if jumps[one[-1]]:
            continue
        a, b = _direction(positions_m[one]), _direction(positions_m[other])
        corner_rad = float(np.arccos(np.clip(a @ b, -1.0, 1.0)))
        leg_rad = max(_turn_rad(positions_m[one]), _turn_rad(positions_m[other]))
        if corner_rad < LEAST_TURN_RAD or leg_rad > CURVED_SHARE * corner_rad:
            message = (
                f"the antenna path is no straight line but a curve: it turns by {corner_rad:.2f} rad between "
                f"stretches that turn by {leg_rad:.2f} rad themselves; use a phase meter"
            )
            raise UnsuitablePath(message, bend_m=bend_m(positions_m), corner_rad=corner_rad, leg_rad=leg_rad)


def _direction(positions_m: FloatArray) -> FloatArray:
    """Direction of the fitted line, along the path, shape (3,)."""
    direction = np.linalg.svd(positions_m - positions_m.mean(axis=0), full_matrices=False)[2][0]
    return np.asarray(direction if direction @ (positions_m[-1] - positions_m[0]) >= 0 else -direction)


def _turn_rad(positions_m: FloatArray) -> float:
    """By how much a stretch turns from end to end [rad], from the parabola fitted across it; 0 for a line."""
    centred = positions_m - positions_m.mean(axis=0)
    along = centred @ _direction(positions_m)
    length_m = float(np.ptp(along))
    if length_m == 0.0:
        return 0.0
    curvature = np.polynomial.polynomial.polyfit(along / length_m, centred / length_m, 2)[2]
    return float(2.0 * np.linalg.norm(curvature))
