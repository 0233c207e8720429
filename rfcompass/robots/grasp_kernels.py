"""The verdicts of `grasp_judge`, compiled: faces of the part against boxes and pads of the hand.

Numbers of verdicts are those of `rfcompass.robots.grasp_batch.VERDICTS`.
"""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.robots.overlap_kernels import boxes_overlap, face_overlaps, faces_near, place_face
from rfcompass.robots.part_faces import BALL, FLAT, ROUND_X

# As in `grasp_judge`: a contact's middle is that of what lies this near to the pad [m]; and in `part_surface`: a face
# this near to a point is one that the point lies on [m].
_TOUCH_M, _ON_M = 1e-5, 2e-5
# Corners of a rectangle that five planes have cut.
_CORNERS = 9
# A face that looks along x by less than this has nothing in front of a pad that its neighbours have not.
_SIDEWAYS = 1e-9

HOLDS, HITS, TOO_WIDE, NOTHING, SLIPS, BESIDE = 0, 1, 2, 3, 4, 5
LEFT, RIGHT = 1.0, -1.0  # sides: outwards is side · x


class HandArrays(NamedTuple):
    """A hand at one opening, in hand axes [m].

    Boxes as they sweep (B, 2, 3), pads of both jaws (P, 2, 2), a box around what is in front of them (2, 3), limits.
    """

    boxes: FloatArray
    left: FloatArray
    right: FloatArray
    between: FloatArray
    opening: float
    least: float
    give: float


class PartArrays(NamedTuple):
    """The fields of `PartFaces`."""

    corners: FloatArray
    normals: FloatArray
    box: FloatArray
    kind: int
    size: FloatArray
    nodes: FloatArray
    children: IntArray


class Memory(NamedTuple):
    """Working memory.

    Which faces are near (F); a face in hand axes (4, 3) and its normal (3). Pieces of faces in front of a pad that they
    look at: corners (K, 9, 3), how many, how far each looks along x, how far outwards it reaches (K). A polygon and
    what is left of it (2, 9, 3). For each jaw the bounding rectangle of what touches it, and of what touches it as it
    yields (2, 2, 2, 2).
    """

    near: IntArray
    face: FloatArray
    normal: FloatArray
    pieces: FloatArray
    sizes: IntArray
    outward: FloatArray
    reach: FloatArray
    polygon: FloatArray
    windows: FloatArray


@numba.njit(cache=True, error_model="numpy")
def judge_poses(
    R: FloatArray, origins: FloatArray, friction: FloatArray, hand: HandArrays, part: PartArrays
) -> IntArray:
    """Judge many poses of hand axes in the part frame.

    Args:
        R: Their rotations, shape (S, 3, 3).
        origins: Their origins [m], shape (S, 3).
        friction: Coefficient for each pose, shape (S,).
        hand: The hand.
        part: The part.

    Returns:
        Numbers of verdicts, shape (S,).
    """
    verdicts = np.empty(len(R), dtype=np.int64)
    F, K = len(part.corners), len(part.corners) * max(len(hand.left), len(hand.right))
    memory = Memory(
        np.empty(F, dtype=np.int64),
        np.empty((4, 3)),
        np.empty(3),
        np.empty((K, _CORNERS, 3)),
        np.empty(K, dtype=np.int64),
        np.empty(K),
        np.empty(K),
        np.empty((2, _CORNERS, 3)),
        np.empty((2, 2, 2, 2)),
    )
    M, c = np.empty((3, 3)), np.empty(3)
    for s in range(len(R)):
        for i in range(3):
            c[i] = -(R[s, 0, i] * origins[s, 0] + R[s, 1, i] * origins[s, 1] + R[s, 2, i] * origins[s, 2])
            for j in range(3):
                M[i, j] = R[s, j, i]
        verdicts[s] = _judge(M, c, hand, part, friction[s], memory)
    return verdicts


@numba.njit(cache=True, error_model="numpy")
def _judge(M: FloatArray, c: FloatArray, hand: HandArrays, part: PartArrays, mu: float, memory: Memory) -> int:
    """Judge one pose of the part in hand axes, rotation M (3, 3) and origin c (3)."""
    hit = _hits(hand.boxes, M, c, part, memory)
    count = _cut(hand, M, c, part, memory)
    if hit:
        width = _farthest(LEFT, np.inf, count, memory) + _farthest(RIGHT, np.inf, count, memory)
        return TOO_WIDE if width > hand.opening else HITS
    most = hand.opening / 2
    left, right = _farthest(LEFT, most, count, memory), _farthest(RIGHT, most, count, memory)
    width = left + right
    if width < hand.least or width == -np.inf:
        return NOTHING
    steepest = 1 / np.sqrt(1 + mu * mu)
    for side, end in ((LEFT, left), (RIGHT, right)):
        facing = _touch(side, end, most, count, hand.give, memory)
        if part.kind != FLAT:
            facing = _round_facing(side, end, M, c, part, memory)
        if facing < steepest:
            return SLIPS
    return BESIDE if _gap(memory.windows) > mu * width else HOLDS


@numba.njit(cache=True, error_model="numpy")
def _hits(boxes: FloatArray, M: FloatArray, c: FloatArray, part: PartArrays, memory: Memory) -> bool:
    """True if a box of the hand overlaps the part."""
    for b in range(len(boxes)):
        if len(part.box):
            if boxes_overlap(boxes[b], part.box[0], M, c):
                return True
            continue
        for k in range(faces_near(boxes[b], part.nodes, part.children, M, c, memory.near)):
            place_face(part.corners, memory.near[k], M, c, memory.face)
            if face_overlaps(boxes[b], memory.face):
                return True
    return False


@numba.njit(cache=True, error_model="numpy")
def _cut(hand: HandArrays, M: FloatArray, c: FloatArray, part: PartArrays, memory: Memory) -> int:
    """Cut out what is in front of the pads: pieces of the faces that look at them; return how many."""
    whole = len(part.box) > 0
    near = len(part.corners) if whole else faces_near(hand.between, part.nodes, part.children, M, c, memory.near)
    count, face_m, normal, polygon = 0, memory.face, memory.normal, memory.polygon
    for k in range(near):
        face = k if whole else memory.near[k]
        for i in range(3):
            normal[i] = (
                M[i, 0] * part.normals[face, 0] + M[i, 1] * part.normals[face, 1] + M[i, 2] * part.normals[face, 2]
            )
        if abs(normal[0]) < _SIDEWAYS:
            continue
        place_face(part.corners, face, M, c, face_m)
        pads = hand.left if normal[0] > 0 else hand.right
        for p in range(len(pads)):
            source, size = _in_front(pads, p, face_m, normal, polygon)
            if size:
                _keep(source, size, normal[0], count, memory)
                count += 1
    return count


@numba.njit(cache=True, error_model="numpy")
def _keep(source: int, size: int, outward: float, piece: int, memory: Memory) -> None:
    """Keep a polygon as a piece."""
    side, reach = LEFT if outward > 0 else RIGHT, -np.inf
    for k in range(size):
        reach = max(reach, side * memory.polygon[source, k, 0])
        for i in range(3):
            memory.pieces[piece, k, i] = memory.polygon[source, k, i]
    memory.sizes[piece], memory.outward[piece], memory.reach[piece] = size, outward, reach


@numba.njit(cache=True, error_model="numpy")
def _clip(polygon: FloatArray, source: int, size: int, x: float, y: float, z: float, bound: float) -> tuple[int, int]:
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
def _in_front(pads: FloatArray, p: int, face: FloatArray, normal: FloatArray, polygon: FloatArray) -> tuple[int, int]:
    """Clip a pad to what is behind it of a face; return where in `polygon` it lies, and how many corners."""
    low_y, high_y, low_z, high_z = np.inf, -np.inf, np.inf, -np.inf
    for k in range(4):
        low_y, high_y = min(low_y, face[k, 1]), max(high_y, face[k, 1])
        low_z, high_z = min(low_z, face[k, 2]), max(high_z, face[k, 2])
    if low_y > pads[p, 1, 0] or high_y < pads[p, 0, 0] or low_z > pads[p, 1, 1] or high_z < pads[p, 0, 1]:
        return 0, 0
    for k in range(4):
        polygon[0, k, 0] = 0.0
        polygon[0, k, 1] = pads[p, 1 if k in (1, 2) else 0, 0]
        polygon[0, k, 2] = pads[p, 1 if k > 1 else 0, 1]
    source, size, turn = 0, 4, LEFT if normal[0] > 0 else RIGHT
    for k in range(4):
        after = k + 1 if k < 3 else 0
        y, z = turn * (face[after, 2] - face[k, 2]), -turn * (face[after, 1] - face[k, 1])  # out of the face's edge
        bound = y * face[k, 1] + z * face[k, 2]
        if max(y * pads[p, 0, 0], y * pads[p, 1, 0]) + max(z * pads[p, 0, 1], z * pads[p, 1, 1]) > bound:
            source, size = _clip(polygon, source, size, 0.0, y, z, bound)
    for k in range(size):
        aside = normal[1] * (polygon[source, k, 1] - face[0, 1]) + normal[2] * (polygon[source, k, 2] - face[0, 2])
        polygon[source, k, 0] = face[0, 0] - aside / normal[0]
    return source, size


@numba.njit(cache=True, error_model="numpy")
def _farthest(side: float, most: float, pieces: int, memory: Memory) -> float:
    """Largest outward x up to `most` of the part in front of a jaw; minus infinity if there is nothing.

    A piece that ends farther out lies beyond the open jaw as a whole: the jaw would hit it otherwise.
    """
    farthest = -np.inf
    for piece in range(pieces):
        if side * memory.outward[piece] > 0 and memory.reach[piece] <= most:
            farthest = max(farthest, memory.reach[piece])
    return farthest


@numba.njit(cache=True, error_model="numpy")
def _touch(side: float, end: float, most: float, pieces: int, give: float, memory: Memory) -> float:
    """Write what a jaw touches into its windows, as it is and as it yields; return how far its faces look at it."""
    windows, polygon, facing = memory.windows[0 if side > 0 else 1], memory.polygon, -1.0
    windows[:, 0], windows[:, 1] = np.inf, -np.inf
    for piece in range(pieces):
        outward = side * memory.outward[piece]
        if outward <= 0 or not end - give <= memory.reach[piece] <= most:
            continue
        size, source = memory.sizes[piece], 0
        polygon[0, :size] = memory.pieces[piece, :size]
        for depth in range(1, -1, -1):  # what lies near is a part of what lies less near
            from_x = side * (end - (give if depth else _TOUCH_M))
            source, size = _clip(polygon, source, size, -side, 0.0, 0.0, -side * from_x)
            for k in range(size):
                for axis in range(2):
                    windows[depth, 0, axis] = min(windows[depth, 0, axis], polygon[source, k, 1 + axis])
                    windows[depth, 1, axis] = max(windows[depth, 1, axis], polygon[source, k, 1 + axis])
        if size:
            facing = max(facing, outward)
    return facing


@numba.njit(cache=True, error_model="numpy")
def _round_facing(side: float, end: float, M: FloatArray, c: FloatArray, part: PartArrays, memory: Memory) -> float:
    """How far the normal of the round shape that the faces stand for looks at a jaw, where the jaw touches."""
    window = memory.windows[0 if side > 0 else 1, 0]
    at = (side * end - c[0], (window[0, 0] + window[1, 0]) / 2 - c[1], (window[0, 1] + window[1, 1]) / 2 - c[2])
    point = np.empty(3)
    for j in range(3):
        point[j] = M[0, j] * at[0] + M[1, j] * at[1] + M[2, j] * at[2]
    squares, x = (point**2).sum(), side * (M[0, 0] * point[0] + M[0, 1] * point[1] + M[0, 2] * point[2])
    if part.kind == BALL:
        return x / np.sqrt(squares)
    along = 0 if part.kind == ROUND_X else 2
    radius, on_axis = np.sqrt(max(squares - point[along] ** 2, 0.0)), side * M[0, along] * point[along]
    off_side, off_end, best = part.size[0] - radius, part.size[1] - abs(point[along]), -1.0
    if off_side <= max(_ON_M, off_end):
        best = (x - on_axis) / radius
    if off_end <= max(_ON_M, off_side):
        best = max(best, np.sign(on_axis) * abs(M[0, along]))
    return best


@numba.njit(cache=True, error_model="numpy")
def _gap(windows: FloatArray) -> float:
    """Distance between what the two yielding pads touch."""
    squares = 0.0
    for axis in range(2):
        beside = max(windows[0, 1, 0, axis] - windows[1, 1, 1, axis], windows[1, 1, 0, axis] - windows[0, 1, 1, axis])
        squares += max(beside, 0.0) ** 2
    return np.sqrt(squares)
