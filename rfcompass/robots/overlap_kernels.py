"""Does a box overlap a box, a face, any face of a part? Separating axes, compiled.

All in hand axes: the hand's boxes are straight there, the part is turned and stands somewhere: its pose (4, 3) is three
rows of a rotation M, then the origin c. Boxes come as arrays (B, 2, 3) with an index, never as views of one: what numba
counts references to costs more here than the arithmetic.
"""

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray

# Parallel edges have no cross product; one whose square is shorter than this separates nothing.
_PARALLEL = 1e-9
# Nodes that a walk through a tree keeps in mind: one for each level, of which there are at most 64.
STACK = 64


@numba.njit(cache=True, error_model="numpy")
def boxes_overlap(boxes: FloatArray, b: int, others: FloatArray, n: int, pose: FloatArray) -> bool:
    """Separating axes of two boxes: three edges of each, and the nine products of their edges.

    Args:
        boxes: Lower and upper corners of straight ones, shape (B, 2, 3).
        b: Which of them.
        others: Lower and upper corners of turned ones in their own frame, shape (N, 2, 3).
        n: Which of them.
        pose: Rotation and origin of that frame, shape (4, 3).
    """
    if _faces_separate(boxes, b, others, n, pose):
        return False
    for i in range(3):
        for j in range(3):
            if _edges_separate(boxes, b, others, n, pose, i, j):
                return False
    return True


@numba.njit(cache=True, error_model="numpy")
def _faces_separate(boxes: FloatArray, b: int, others: FloatArray, n: int, pose: FloatArray) -> bool:
    """True if a face of one of two boxes separates them."""
    for i in range(3):
        middle, reach = pose[3, i], 0.0
        for j in range(3):
            middle += pose[i, j] * (others[n, 0, j] + others[n, 1, j]) * 0.5
            reach += abs(pose[i, j]) * (others[n, 1, j] - others[n, 0, j]) * 0.5
        if middle - reach > boxes[b, 1, i] or middle + reach < boxes[b, 0, i]:
            return True
    for j in range(3):
        middle, reach = 0.0, 0.0
        for i in range(3):
            middle += pose[i, j] * ((boxes[b, 0, i] + boxes[b, 1, i]) * 0.5 - pose[3, i])
            reach += abs(pose[i, j]) * (boxes[b, 1, i] - boxes[b, 0, i]) * 0.5
        if middle - reach > others[n, 1, j] or middle + reach < others[n, 0, j]:
            return True
    return False


@numba.njit(cache=True, error_model="numpy")
def _edges_separate(boxes: FloatArray, b: int, others: FloatArray, n: int, pose: FloatArray, i: int, j: int) -> bool:
    """True if the product of edge i of the straight box and edge j of the turned one separates them."""
    i1, i2 = (i + 1) % 3, (i + 2) % 3
    y, z = -pose[i2, j], pose[i1, j]  # the product has these components along i1 and i2
    if y * y + z * z < _PARALLEL:
        return False
    middle = y * (pose[3, i1] - (boxes[b, 0, i1] + boxes[b, 1, i1]) * 0.5) + z * (
        pose[3, i2] - (boxes[b, 0, i2] + boxes[b, 1, i2]) * 0.5
    )
    reach = abs(y) * (boxes[b, 1, i1] - boxes[b, 0, i1]) * 0.5 + abs(z) * (boxes[b, 1, i2] - boxes[b, 0, i2]) * 0.5
    for k in range(3):
        along = y * pose[i1, k] + z * pose[i2, k]
        middle += along * (others[n, 0, k] + others[n, 1, k]) * 0.5
        reach += abs(along) * (others[n, 1, k] - others[n, 0, k]) * 0.5
    return abs(middle) > reach


@numba.njit(cache=True, error_model="numpy")
def face_overlaps(boxes: FloatArray, b: int, face: FloatArray) -> bool:
    """Separating axes of a straight box and a flat face whose corners, the first four rows, are in the same frame."""
    for i in range(3):
        low = min(face[0, i], face[1, i], face[2, i], face[3, i])
        high = max(face[0, i], face[1, i], face[2, i], face[3, i])
        if low > boxes[b, 1, i] or high < boxes[b, 0, i]:
            return False
    ux, uy, uz = face[1, 0] - face[0, 0], face[1, 1] - face[0, 1], face[1, 2] - face[0, 2]
    vx, vy, vz = face[2, 0] - face[0, 0], face[2, 1] - face[0, 1], face[2, 2] - face[0, 2]
    if _separates(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx, boxes, b, face):
        return False
    for k in range(4):
        after = (k + 1) % 4
        x, y, z = face[after, 0] - face[k, 0], face[after, 1] - face[k, 1], face[after, 2] - face[k, 2]
        if (
            _separates(0.0, -z, y, boxes, b, face)
            or _separates(z, 0.0, -x, boxes, b, face)
            or _separates(-y, x, 0.0, boxes, b, face)
        ):  # fmt: skip
            return False
    return True


@numba.njit(cache=True, error_model="numpy")
def _separates(x: float, y: float, z: float, boxes: FloatArray, b: int, face: FloatArray) -> bool:
    """True if box and face do not meet along the axis (x, y, z)."""
    middle = (
        x * (boxes[b, 0, 0] + boxes[b, 1, 0])
        + y * (boxes[b, 0, 1] + boxes[b, 1, 1])
        + z * (boxes[b, 0, 2] + boxes[b, 1, 2])
    ) * 0.5
    reach = (
        abs(x) * (boxes[b, 1, 0] - boxes[b, 0, 0])
        + abs(y) * (boxes[b, 1, 1] - boxes[b, 0, 1])
        + abs(z) * (boxes[b, 1, 2] - boxes[b, 0, 2])
    )
    low, high = np.inf, -np.inf
    for k in range(4):
        at = x * face[k, 0] + y * face[k, 1] + z * face[k, 2]
        low, high = min(low, at), max(high, at)
    return low > middle + reach * 0.5 or high < middle - reach * 0.5


@numba.njit(cache=True, error_model="numpy")
def place_face(corners: FloatArray, face: int, pose: FloatArray, out: FloatArray) -> None:
    """Turn and move the corners of one face (F, 4, 3) into the first four rows of `out`."""
    for k in range(4):
        x, y, z = corners[face, k, 0], corners[face, k, 1], corners[face, k, 2]
        for i in range(3):
            out[k, i] = pose[i, 0] * x + pose[i, 1] * y + pose[i, 2] * z + pose[3, i]


@numba.njit(cache=True, error_model="numpy")
def faces_near(
    boxes: FloatArray, b: int, nodes: FloatArray, children: IntArray, pose: FloatArray, found: IntArray
) -> int:
    """Write into `found` the faces of all leaves that no face of a box separates from it; return how many."""
    stack = np.empty(STACK, dtype=np.int64)
    stack[0], waiting, count = 0, 1, 0
    while waiting:
        waiting -= 1
        node = stack[waiting]
        if _faces_separate(boxes, b, nodes, node, pose):
            continue
        if children[node, 0] >= 0:
            stack[waiting], stack[waiting + 1] = children[node, 0], children[node, 1]
            waiting += 2
            continue
        for k in range(children[node, 2], children[node, 2] + children[node, 3]):
            found[count] = k
            count += 1
    return count
