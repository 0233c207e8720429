"""A box, the most common part: whether a hand hits it, and what of it is in front of the pads, face by face.

With f the middle of the face on axis j, d = (y, z) - (f_y, f_z) a point of a pad, the face's point behind it lies at

    x = f_x - (M_yj d_y + M_zj d_z) / M_xj,    inside the face where  |(M_yk - M_xk M_yj / M_xj) d_y + (…z…) d_z| ≤ h_k

for both other axes k, h being half the edges. Poses as in `overlap_kernels`.
"""

import numba

from rfcompass.arrays import FloatArray
from rfcompass.robots.overlap_kernels import boxes_overlap
from rfcompass.robots.piece_kernels import SIDEWAYS, clip, keep, whole_pad


@numba.njit(cache=True, error_model="numpy")
def hits_box(boxes: FloatArray, part: FloatArray, pose: FloatArray, bounds: FloatArray) -> bool:
    """True if a box of the hand (B, 2, 3) overlaps the part (1, 2, 3); `bounds` (≥ 2, 3) is memory."""
    for i in range(3):
        middle, reach = pose[3, i], 0.0
        for j in range(3):
            middle += pose[i, j] * (part[0, 0, j] + part[0, 1, j]) * 0.5
            reach += abs(pose[i, j]) * (part[0, 1, j] - part[0, 0, j]) * 0.5
        bounds[0, i], bounds[1, i] = middle - reach, middle + reach
    for b in range(len(boxes)):
        apart = False
        for i in range(3):
            apart = apart or bounds[0, i] > boxes[b, 1, i] or bounds[1, i] < boxes[b, 0, i]
        if not apart and boxes_overlap(boxes, b, part, 0, pose):
            return True
    return False


@numba.njit(cache=True, error_model="numpy")
def cut_box(
    pads: FloatArray, part: FloatArray, pose: FloatArray, face: FloatArray, polygon: FloatArray, pieces: FloatArray
) -> int:
    """Cut out what is in front of the pads of a box (1, 2, 3) about the part frame's origin; return how many pieces.

    Pads (2, P, 2, 2): those of the left jaw, then of the right; `face` (≥ 1, 3) is memory; the rest is that of
    `piece_kernels`.
    """
    count = 0
    for j in range(3):
        if abs(pose[0, j]) < SIDEWAYS:
            continue
        for side in range(2):
            # The left jaw looks at the face whose normal has x > 0.
            sign = 1.0 if (pose[0, j] > 0) == (side == 0) else -1.0
            for i in range(3):
                face[0, i] = pose[3, i] + sign * part[0, 1, j] * pose[i, j]
            for p in range(pads.shape[1]):
                if _reaches(pads, side, p, face, part, pose, j):
                    source, size = _in_front(pads, side, p, face, part, pose, j, polygon)
                    if size:
                        keep(polygon, source, size, sign * pose[0, j], pieces, count)
                        count += 1
    return count


@numba.njit(cache=True, error_model="numpy")
def _reaches(pads: FloatArray, side: int, p: int, face: FloatArray, part: FloatArray, pose: FloatArray, j: int) -> bool:
    """True if the bounding rectangle of the face on axis j, its middle `face[0]`, meets a pad."""
    k, m = (j + 1) % 3, (j + 2) % 3
    for axis in range(2):
        reach = abs(pose[1 + axis, k]) * part[0, 1, k] + abs(pose[1 + axis, m]) * part[0, 1, m]
        if face[0, 1 + axis] - reach > pads[side, p, 1, axis] or face[0, 1 + axis] + reach < pads[side, p, 0, axis]:
            return False
    return True


@numba.njit(cache=True, error_model="numpy")
def _in_front(  # noqa: PLR0913, PLR0917 - a record of arrays would cost more than the arithmetic
    pads: FloatArray, side: int, p: int, face: FloatArray, part: FloatArray, pose: FloatArray, j: int,
    polygon: FloatArray,
) -> tuple[int, int]:  # fmt: skip
    """Clip a pad to the face on axis j behind it; return where in `polygon` the piece lies, and how many corners."""
    size = whole_pad(pads, side, p, polygon)
    source = 0
    for step in range(1, 3):
        k = (j + step) % 3
        slope, bound = pose[0, k] / pose[0, j], part[0, 1, k]
        y, z = pose[1, k] - slope * pose[1, j], pose[2, k] - slope * pose[2, j]
        at = y * face[0, 1] + z * face[0, 2]
        low = min(y * pads[side, p, 0, 0], y * pads[side, p, 1, 0]) + min(
            z * pads[side, p, 0, 1], z * pads[side, p, 1, 1]
        )
        high = max(y * pads[side, p, 0, 0], y * pads[side, p, 1, 0]) + max(
            z * pads[side, p, 0, 1], z * pads[side, p, 1, 1]
        )
        if high > at + bound:
            source, size = clip(polygon, source, size, 0.0, y, z, at + bound)
        if low < at - bound:
            source, size = clip(polygon, source, size, 0.0, -y, -z, bound - at)
    y, z = pose[1, j] / pose[0, j], pose[2, j] / pose[0, j]
    for k in range(size):
        aside = y * (polygon[source, k, 1] - face[0, 1]) + z * (polygon[source, k, 2] - face[0, 2])
        polygon[source, k, 0] = face[0, 0] - aside
    return source, size
