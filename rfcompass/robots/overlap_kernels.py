"""Does a box overlap a box, a face, any face of a part? Separating axes, compiled.

All in hand axes: the hand's box is straight there, the part is turned by M and stands at c.
"""

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray

# Parallel edges have no cross product; one whose square is shorter than this separates nothing.
_PARALLEL = 1e-9
# Nodes that a walk through a tree keeps in mind: one for each level, of which there are at most 64.
STACK = 64


@numba.njit(cache=True, error_model="numpy")
def boxes_overlap(box: FloatArray, other: FloatArray, M: FloatArray, c: FloatArray) -> bool:
    """Separating axes of two boxes: three edges of each, and the nine products of their edges.

    Args:
        box: Lower and upper corner of the straight one, shape (2, 3).
        other: Lower and upper corner of the turned one in its own frame, shape (2, 3).
        M: Rotation of that frame, shape (3, 3).
        c: Its origin, shape (3,).
    """
    if _faces_separate(box, other, M, c):
        return False
    for i in range(3):
        for j in range(3):
            if _edges_separate(box, other, M, c, i, j):
                return False
    return True


@numba.njit(cache=True, error_model="numpy")
def _faces_separate(box: FloatArray, other: FloatArray, M: FloatArray, c: FloatArray) -> bool:
    """True if a face of one of two boxes separates them."""
    for i in range(3):
        middle, reach = c[i], 0.0
        for j in range(3):
            middle += M[i, j] * (other[0, j] + other[1, j]) * 0.5
            reach += abs(M[i, j]) * (other[1, j] - other[0, j]) * 0.5
        if middle - reach > box[1, i] or middle + reach < box[0, i]:
            return True
    for j in range(3):
        middle, reach = 0.0, 0.0
        for i in range(3):
            middle += M[i, j] * ((box[0, i] + box[1, i]) * 0.5 - c[i])
            reach += abs(M[i, j]) * (box[1, i] - box[0, i]) * 0.5
        if middle - reach > other[1, j] or middle + reach < other[0, j]:
            return True
    return False


@numba.njit(cache=True, error_model="numpy")
def _edges_separate(box: FloatArray, other: FloatArray, M: FloatArray, c: FloatArray, i: int, j: int) -> bool:
    """True if the product of edge i of the straight box and edge j of the turned one separates them."""
    i1, i2 = (i + 1) % 3, (i + 2) % 3
    y, z = -M[i2, j], M[i1, j]  # the product has these components along i1 and i2
    if y * y + z * z < _PARALLEL:
        return False
    middle = y * (c[i1] - (box[0, i1] + box[1, i1]) * 0.5) + z * (c[i2] - (box[0, i2] + box[1, i2]) * 0.5)
    reach = abs(y) * (box[1, i1] - box[0, i1]) * 0.5 + abs(z) * (box[1, i2] - box[0, i2]) * 0.5
    for k in range(3):
        along = y * M[i1, k] + z * M[i2, k]
        middle += along * (other[0, k] + other[1, k]) * 0.5
        reach += abs(along) * (other[1, k] - other[0, k]) * 0.5
    return abs(middle) > reach


@numba.njit(cache=True, error_model="numpy")
def face_overlaps(box: FloatArray, face: FloatArray) -> bool:
    """Separating axes of a straight box (2, 3) and a flat face whose corners (4, 3) are in the same frame."""
    for i in range(3):
        low = min(face[0, i], face[1, i], face[2, i], face[3, i])
        high = max(face[0, i], face[1, i], face[2, i], face[3, i])
        if low > box[1, i] or high < box[0, i]:
            return False
    ux, uy, uz = face[1, 0] - face[0, 0], face[1, 1] - face[0, 1], face[1, 2] - face[0, 2]
    vx, vy, vz = face[2, 0] - face[0, 0], face[2, 1] - face[0, 1], face[2, 2] - face[0, 2]
    if _separates(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx, box, face):
        return False
    for k in range(4):
        after = (k + 1) % 4
        x, y, z = face[after, 0] - face[k, 0], face[after, 1] - face[k, 1], face[after, 2] - face[k, 2]
        if (
            _separates(0.0, -z, y, box, face)
            or _separates(z, 0.0, -x, box, face)
            or _separates(-y, x, 0.0, box, face)
        ):  # fmt: skip
            return False
    return True


@numba.njit(cache=True, error_model="numpy")
def _separates(x: float, y: float, z: float, box: FloatArray, face: FloatArray) -> bool:
    """True if box and face do not meet along the axis (x, y, z)."""
    middle = (x * (box[0, 0] + box[1, 0]) + y * (box[0, 1] + box[1, 1]) + z * (box[0, 2] + box[1, 2])) * 0.5
    reach = abs(x) * (box[1, 0] - box[0, 0]) + abs(y) * (box[1, 1] - box[0, 1]) + abs(z) * (box[1, 2] - box[0, 2])
    low, high = np.inf, -np.inf
    for k in range(4):
        at = x * face[k, 0] + y * face[k, 1] + z * face[k, 2]
        low, high = min(low, at), max(high, at)
    return low > middle + reach * 0.5 or high < middle - reach * 0.5


@numba.njit(cache=True, error_model="numpy")
def place_face(corners: FloatArray, face: int, M: FloatArray, c: FloatArray, out: FloatArray) -> None:
    """Turn and move the corners of one face (F, 4, 3) into `out` (4, 3)."""
    for k in range(4):
        for i in range(3):
            out[k, i] = (
                M[i, 0] * corners[face, k, 0] + M[i, 1] * corners[face, k, 1] + M[i, 2] * corners[face, k, 2] + c[i]
            )


@numba.njit(cache=True, error_model="numpy")
def faces_near(
    box: FloatArray, nodes: FloatArray, children: IntArray, M: FloatArray, c: FloatArray, found: IntArray
) -> int:
    """Write into `found` the faces of all leaves that no face of a box separates from it; return how many."""
    stack = np.empty(STACK, dtype=np.int64)
    stack[0], waiting, count = 0, 1, 0
    while waiting:
        waiting -= 1
        node = stack[waiting]
        if _faces_separate(box, nodes[node], M, c):
            continue
        if children[node, 0] >= 0:
            stack[waiting], stack[waiting + 1] = children[node, 0], children[node, 1]
            waiting += 2
            continue
        for k in range(children[node, 2], children[node, 2] + children[node, 3]):
            found[count] = k
            count += 1
    return count
