"""Tag positions at many configurations at once: the kinematic chain as arrays, and one compiled loop over them."""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray


class JointChain(NamedTuple):
    """The moving joints between the base and the tags, parents first, and the tags on them.

    A joint moves by scale · value + offset, where several joints may share one value (mimic joints).

    Attributes:
        parent: Index of each joint's parent joint, -1 for the base, shape (J,).
        R: Orientation of each joint in its parent at rest, shape (J, 3, 3).
        p: Position of each joint in its parent at rest [m], shape (J, 3).
        axis: Unit vector that each joint turns about or slides along, shape (J, 3).
        slides: True for a prismatic joint, shape (J,).
        value: Index of the configuration's value that moves the joint, shape (J,).
        scale: See above, shape (J,).
        offset: See above [rad or m], shape (J,).
        tag_joint: Joint that each tag rides on, -1 for the base, shape (N,).
        tag_p: Position of each tag in the frame of its joint [m], shape (N, 3).
    """

    parent: IntArray
    R: FloatArray
    p: FloatArray
    axis: FloatArray
    slides: BoolArray
    value: IntArray
    scale: FloatArray
    offset: FloatArray
    tag_joint: IntArray
    tag_p: FloatArray


@numba.njit(cache=True)
def tag_points(chain: JointChain, joints: FloatArray) -> FloatArray:
    """Positions of all tags in the base frame [m], shape (B, N, 3), for joint values (B, Q)."""
    J, N, B = chain.parent.size, chain.tag_joint.size, joints.shape[0]
    points = np.empty((B, N, 3))
    R, p, turn = np.empty((J + 1, 3, 3)), np.zeros((J + 1, 3)), np.empty((3, 3))
    R[J] = np.eye(3)  # index -1 is the base
    for b in range(B):
        for j in range(J):
            value = chain.scale[j] * joints[b, chain.value[j]] + chain.offset[j]
            _compose(R[chain.parent[j]], p[chain.parent[j]], chain.R[j], chain.p[j], R[j], p[j])
            if chain.slides[j]:
                _add_rotated(R[j], chain.axis[j], value, p[j])
            else:
                _turn_about(chain.axis[j], value, turn)
                _multiply_in_place(R[j], turn)
        for n in range(N):
            points[b, n] = p[chain.tag_joint[n]]
            _add_rotated(R[chain.tag_joint[n]], chain.tag_p[n], 1.0, points[b, n])
    return points


@numba.njit(cache=True)
def _compose(Ra: FloatArray, pa: FloatArray, Rb: FloatArray, pb: FloatArray, R: FloatArray, p: FloatArray) -> None:
    """(R, p) = (Ra, pa) · (Rb, pb)."""
    for i in range(3):
        p[i] = pa[i] + Ra[i, 0] * pb[0] + Ra[i, 1] * pb[1] + Ra[i, 2] * pb[2]
        for k in range(3):
            R[i, k] = Ra[i, 0] * Rb[0, k] + Ra[i, 1] * Rb[1, k] + Ra[i, 2] * Rb[2, k]


@numba.njit(cache=True)
def _add_rotated(R: FloatArray, v: FloatArray, factor: float, p: FloatArray) -> None:
    """P += factor · R v."""
    for i in range(3):
        p[i] += factor * (R[i, 0] * v[0] + R[i, 1] * v[1] + R[i, 2] * v[2])


@numba.njit(cache=True)
def _multiply_in_place(R: FloatArray, turn: FloatArray) -> None:
    """R = R · turn."""
    for i in range(3):
        x, y, z = R[i, 0], R[i, 1], R[i, 2]
        for k in range(3):
            R[i, k] = x * turn[0, k] + y * turn[1, k] + z * turn[2, k]


@numba.njit(cache=True)
def _turn_about(axis: FloatArray, angle_rad: float, R: FloatArray) -> None:
    """Rodrigues: R = cos I + sin [axis]x + (1 - cos) axis axisᵀ."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    x, y, z = axis
    for i in range(3):
        for k in range(3):
            R[i, k] = (1.0 - c) * axis[i] * axis[k]
        R[i, i] += c
    R[0, 1] -= s * z
    R[1, 0] += s * z
    R[0, 2] += s * y
    R[2, 0] -= s * y
    R[1, 2] -= s * x
    R[2, 1] += s * x
