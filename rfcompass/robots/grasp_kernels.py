"""The verdicts of `grasp_judge`, compiled: faces of the part against boxes and pads of the hand.

Numbers of verdicts are those of `rfcompass.robots.grasp_batch.VERDICTS`; poses as in `overlap_kernels`.
"""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.robots.box_kernels import cut_box, hits_box
from rfcompass.robots.overlap_kernels import face_overlaps, faces_near, place_face
from rfcompass.robots.part_faces import BALL, FLAT, ROUND_X
from rfcompass.robots.piece_kernels import (
    CORNERS,
    SIDEWAYS,
    clip,
    facing,
    farthest,
    gap,
    keep,
    keep_within,
    touched,
    whole_pad,
)

# As in `grasp_judge`: a contact's middle is that of what lies this near to the pad [m]; and in `part_surface`: a face
# this near to a point is one that the point lies on [m].
_TOUCH_M, _ON_M = 1e-5, 2e-5

HOLDS, HITS, TOO_WIDE, NOTHING, SLIPS, BESIDE = 0, 1, 2, 3, 4, 5


class HandArrays(NamedTuple):
    """A hand at one opening, in hand axes [m].

    Boxes as they sweep (B, 2, 3), pads of the left and of the right jaw (2, P, 2, 2), a box around what is in front of
    them (1, 2, 3), limits.
    """

    boxes: FloatArray
    pads: FloatArray
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

    Which faces are near (F); a face in hand axes and its normal (5, 3); a polygon and pieces, as in `piece_kernels`;
    what each jaw touches (2, 2, 2).
    """

    near: IntArray
    face: FloatArray
    polygon: FloatArray
    pieces: FloatArray
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
    verdicts, F = np.empty(len(R), dtype=np.int64), len(part.corners)
    memory = Memory(
        np.empty(F, dtype=np.int64),
        np.empty((5, 3)),
        np.empty((2, CORNERS, 3)),
        np.empty((F * hand.pads.shape[1], CORNERS + 1, 3)),
        np.empty((2, 2, 2)),
    )
    pose = np.empty((4, 3))
    for s in range(len(R)):
        for i in range(3):
            pose[3, i] = -(R[s, 0, i] * origins[s, 0] + R[s, 1, i] * origins[s, 1] + R[s, 2, i] * origins[s, 2])
            for j in range(3):
                pose[i, j] = R[s, j, i]
        verdicts[s] = _judge(pose, hand, part, friction[s], memory)
    return verdicts


@numba.njit(cache=True, error_model="numpy")
def _judge(pose: FloatArray, hand: HandArrays, part: PartArrays, mu: float, memory: Memory) -> int:
    """Judge one pose of the part in hand axes."""
    pieces = memory.pieces
    if len(part.box):
        hit = hits_box(hand.boxes, part.box, pose, memory.face)
        count = cut_box(hand.pads, part.box, pose, memory.face, memory.polygon, pieces)
    else:
        hit, count = _hits(hand.boxes, pose, part, memory), _cut(hand, pose, part, memory)
    if hit:
        width = farthest(1.0, count, pieces) + farthest(-1.0, count, pieces)
        return TOO_WIDE if width > hand.opening else HITS
    count = keep_within(hand.opening / 2, count, pieces)
    left, right = farthest(1.0, count, pieces), farthest(-1.0, count, pieces)
    width = left + right
    if width < hand.least or width == -np.inf:
        return NOTHING
    steepest = 1 / np.sqrt(1 + mu * mu)
    for sign, end in ((1.0, left), (-1.0, right)):
        if part.kind == FLAT:
            looks = facing(sign, end - _TOUCH_M, count, pieces)
        else:
            looks = _round_facing(sign, end, count, pose, part, memory)
        if looks < steepest:
            return SLIPS
    touched(1.0, left - hand.give, count, pieces, memory.polygon, memory.windows)
    touched(-1.0, right - hand.give, count, pieces, memory.polygon, memory.windows)
    return BESIDE if gap(memory.windows) > mu * width else HOLDS


@numba.njit(cache=True, error_model="numpy")
def _hits(boxes: FloatArray, pose: FloatArray, part: PartArrays, memory: Memory) -> bool:
    """True if a box of the hand overlaps the part."""
    for b in range(len(boxes)):
        for k in range(faces_near(boxes, b, part.nodes, part.children, pose, memory.near)):
            place_face(part.corners, memory.near[k], pose, memory.face)
            if face_overlaps(boxes, b, memory.face):
                return True
    return False


@numba.njit(cache=True, error_model="numpy")
def _cut(hand: HandArrays, pose: FloatArray, part: PartArrays, memory: Memory) -> int:
    """Cut out what is in front of the pads: pieces of the faces that look at them; return how many."""
    count, pads, face, normals = 0, hand.pads, memory.face, part.normals
    for k in range(faces_near(hand.between, 0, part.nodes, part.children, pose, memory.near)):
        n = memory.near[k]
        for i in range(3):
            face[4, i] = pose[i, 0] * normals[n, 0] + pose[i, 1] * normals[n, 1] + pose[i, 2] * normals[n, 2]
        if abs(face[4, 0]) < SIDEWAYS:
            continue
        place_face(part.corners, n, pose, face)
        side = 0 if face[4, 0] > 0 else 1
        for p in range(pads.shape[1]):
            source, size = _in_front(pads, side, p, face, memory.polygon)
            if size:
                keep(memory.polygon, source, size, face[4, 0], memory.pieces, count)
                count += 1
    return count


@numba.njit(cache=True, error_model="numpy")
def _in_front(pads: FloatArray, side: int, p: int, face: FloatArray, polygon: FloatArray) -> tuple[int, int]:
    """Clip a pad to what is behind it of a face; return where in `polygon` it lies, and how many corners."""
    for axis in range(2):
        i = 1 + axis
        low, high = (
            min(face[0, i], face[1, i], face[2, i], face[3, i]),
            max(face[0, i], face[1, i], face[2, i], face[3, i]),
        )
        if low > pads[side, p, 1, axis] or high < pads[side, p, 0, axis]:
            return 0, 0
    source, size, turn = 0, whole_pad(pads, side, p, polygon), 1.0 - 2.0 * side
    for k in range(4):
        after = k + 1 if k < 3 else 0
        y, z = turn * (face[after, 2] - face[k, 2]), -turn * (face[after, 1] - face[k, 1])  # out of the face's edge
        bound = y * face[k, 1] + z * face[k, 2]
        far_y = max(y * pads[side, p, 0, 0], y * pads[side, p, 1, 0])
        if far_y + max(z * pads[side, p, 0, 1], z * pads[side, p, 1, 1]) > bound:
            source, size = clip(polygon, source, size, 0.0, y, z, bound)
    for k in range(size):
        aside = face[4, 1] * (polygon[source, k, 1] - face[0, 1]) + face[4, 2] * (polygon[source, k, 2] - face[0, 2])
        polygon[source, k, 0] = face[0, 0] - aside / face[4, 0]
    return source, size


@numba.njit(cache=True, error_model="numpy")
def _round_facing(sign: float, end: float, count: int, pose: FloatArray, part: PartArrays, memory: Memory) -> float:
    """How far the normal of the round shape that the faces stand for looks at a jaw, where the jaw touches."""
    touched(sign, end - _TOUCH_M, count, memory.pieces, memory.polygon, memory.windows)
    at, point, w = np.empty(3), np.empty(3), 0 if sign > 0 else 1
    at[0] = sign * end - pose[3, 0]
    for axis in range(2):
        at[1 + axis] = (memory.windows[w, 0, axis] + memory.windows[w, 1, axis]) / 2 - pose[3, 1 + axis]
    for j in range(3):
        point[j] = pose[0, j] * at[0] + pose[1, j] * at[1] + pose[2, j] * at[2]
    squares, x = (point**2).sum(), sign * at[0]
    if part.kind == BALL:
        return x / np.sqrt(squares)
    along = 0 if part.kind == ROUND_X else 2
    radius, on_axis = np.sqrt(max(squares - point[along] ** 2, 0.0)), sign * pose[0, along] * point[along]
    off_side, off_end, best = part.size[0] - radius, part.size[1] - abs(point[along]), -1.0
    if off_side <= max(_ON_M, off_end):
        best = (x - on_axis) / radius
    if off_end <= max(_ON_M, off_side):
        best = max(best, np.sign(on_axis) * abs(pose[0, along]))
    return best
