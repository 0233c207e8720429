"""Pieces of a part's faces in front of the pads of a hand, and what the jaws touch of them. Compiled.

A polygon is worked on in an array (2, 9, 3): one half holds it, the other gets what is left of it. A piece is a block
of an array (K, 10, 3): its corners, then in row 9 how many there are, how far its face looks along x, and how far
outwards it reaches. Outwards is x for the left jaw and -x for the right; a face is in front of the jaw it looks at.
"""

import numba
import numpy as np

from rfcompass.arrays import FloatArray

# Corners of a pad that four edges and a plane have cut; then the row with what else is known of a piece.
CORNERS = 9
_SIZE, _OUTWARD, _REACH = 0, 1, 2
# A face that looks along x by less than this has nothing in front of a pad that its neighbours have not.
SIDEWAYS = 1e-9


@numba.njit(cache=True, error_model="numpy")
def whole_pad(pads: FloatArray, side: int, p: int, polygon: FloatArray) -> int:
    """Write the corners of a pad of (2, P, 2, 2) into the first half of `polygon`, x = 0; return how many."""
    for k in range(4):
        polygon[0, k, 0] = 0.0
        polygon[0, k, 1] = pads[side, p, 1 if k in (1, 2) else 0, 0]
        polygon[0, k, 2] = pads[side, p, 1 if k > 1 else 0, 1]
    return 4


@numba.njit(cache=True, error_model="numpy")
def clip(polygon: FloatArray, source: int, size: int, x: float, y: float, z: float, bound: float) -> tuple[int, int]:
    """Keep what a polygon has where (x, y, z) · point ≤ bound [SutherlandHodgman1974].

    `polygon[source]` holds it; return where in `polygon` the answer lies, and its number of corners.
    """
    if not size:
        return source, 0
    kept, k = 0, size - 1
    before = x * polygon[source, k, 0] + y * polygon[source, k, 1] + z * polygon[source, k, 2] - bound
    for after in range(size):
        here = x * polygon[source, after, 0] + y * polygon[source, after, 1] + z * polygon[source, after, 2] - bound
        if (before <= 0) != (here <= 0):
            t = before / (before - here)
            for i in range(3):
                start = polygon[source, k, i]
                polygon[1 - source, kept, i] = start + t * (polygon[source, after, i] - start)
            kept += 1
        if here <= 0:
            for i in range(3):
                polygon[1 - source, kept, i] = polygon[source, after, i]
            kept += 1
        before, k = here, after
    return 1 - source, kept


@numba.njit(cache=True, error_model="numpy")
def keep(polygon: FloatArray, source: int, size: int, outward: float, pieces: FloatArray, piece: int) -> None:
    """Keep a polygon as a piece of a face that looks along x by `outward`."""
    sign, reach = 1.0 if outward > 0 else -1.0, -np.inf
    for k in range(size):
        reach = max(reach, sign * polygon[source, k, 0])
        for i in range(3):
            pieces[piece, k, i] = polygon[source, k, i]
    pieces[piece, CORNERS, _SIZE] = size
    pieces[piece, CORNERS, _OUTWARD] = outward
    pieces[piece, CORNERS, _REACH] = reach


@numba.njit(cache=True, error_model="numpy")
def keep_within(most: float, count: int, pieces: FloatArray) -> int:
    """Drop what reaches farther out than an outward x: it lies beyond an open jaw, which would hit it otherwise."""
    kept = 0
    for piece in range(count):
        if pieces[piece, CORNERS, _REACH] <= most:
            pieces[kept] = pieces[piece]
            kept += 1
    return kept


@numba.njit(cache=True, error_model="numpy")
def farthest(sign: float, count: int, pieces: FloatArray) -> float:
    """Largest outward x of the part in front of a jaw (sign 1 left, -1 right); minus infinity if there is nothing."""
    most = -np.inf
    for piece in range(count):
        if sign * pieces[piece, CORNERS, _OUTWARD] > 0:
            most = max(most, pieces[piece, CORNERS, _REACH])
    return most


@numba.njit(cache=True, error_model="numpy")
def facing(sign: float, from_x: float, count: int, pieces: FloatArray) -> float:
    """How far what reaches an outward x looks at the jaw; of several faces that which looks at it most."""
    most = -1.0
    for piece in range(count):
        if pieces[piece, CORNERS, _REACH] >= from_x:
            most = max(most, sign * pieces[piece, CORNERS, _OUTWARD])
    return most


@numba.njit(cache=True, error_model="numpy")
def touched(
    sign: float, from_x: float, count: int, pieces: FloatArray, polygon: FloatArray, windows: FloatArray
) -> None:
    """Write into a jaw's window, of (2, 2, 2), the bounding rectangle of what lies farther out than an outward x."""
    w = 0 if sign > 0 else 1
    for axis in range(2):
        windows[w, 0, axis], windows[w, 1, axis] = np.inf, -np.inf
    for piece in range(count):
        if sign * pieces[piece, CORNERS, _OUTWARD] <= 0 or pieces[piece, CORNERS, _REACH] < from_x:
            continue
        size = int(pieces[piece, CORNERS, _SIZE])
        for k in range(size):
            for i in range(3):
                polygon[0, k, i] = pieces[piece, k, i]
        source, size = clip(polygon, 0, size, -sign, 0.0, 0.0, -from_x)
        for k in range(size):
            for axis in range(2):
                windows[w, 0, axis] = min(windows[w, 0, axis], polygon[source, k, 1 + axis])
                windows[w, 1, axis] = max(windows[w, 1, axis], polygon[source, k, 1 + axis])


@numba.njit(cache=True, error_model="numpy")
def gap(windows: FloatArray) -> float:
    """Distance between what the left and what the right jaw touches, windows (2, 2, 2)."""
    squares = 0.0
    for axis in range(2):
        beside = max(windows[0, 0, axis] - windows[1, 1, axis], windows[1, 0, axis] - windows[0, 1, axis])
        squares += max(beside, 0.0) ** 2
    return np.sqrt(squares)
