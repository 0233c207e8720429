"""Inverse kinematics of yaw-pitch-pitch-pitch-roll arms in closed form: every branch, many tasks at once.

The tool's position gives the arm plane: its heading ψ, or ψ + π with the arm bent backwards. In the plane, with the
approach at the angle p from the vertical, joint 4 stands at

    w = tool - L (sin p, cos p) - o (cos p, -sin p),

L and o as in `PlanarArm.hand_m`. Two links of lengths a2, a3 reach it from the shoulder, at the distance d, with

    cos δ = (d² - a2² - a3²) / (2 a2 a3),  φ2 = atan2(w_r, w_z) - atan2(a3 sin δ, a2 + a3 cos δ),  φ3 = φ2 + δ,

one elbow for each sign of δ. Hence four branches at most. The approach must lie in the arm plane, unless it is
vertical: then the plane and the roll together give any heading of the jaws.
"""

import numba
import numpy as np

from planners.planar_arm import PlanarArm
from rfcompass.arrays import FloatArray, IntArray

REACHED, OFF_PLANE, TOO_FAR, BEYOND_LIMIT = 0, 1, 2, 3

# An approach this far off the arm plane still lies in it; far below the 1e-6 that every answer is checked to.
_OFF_PLANE = 2e-7
# Rounding, in the cosine of the elbow and beside a joint's limit.
_SLACK = 1e-10
_TURN = 2.0 * np.pi


@numba.njit(cache=True)
def solve_all(
    arm: PlanarArm, tasks: FloatArray, near: FloatArray, alike: bool
) -> tuple[FloatArray, IntArray, IntArray, FloatArray]:
    """Solve many tasks.

    Args:
        arm: Dimensions of the arm.
        tasks: Tool position [m], approach and closing axis in the base frame, one after the other, shape (B, 9). A
            closing axis of NaN is free: the roll then stays at `near`.
        near: Joint values that each answer should be near to, where whole turns leave a choice, shape (5,).
        alike: Half a turn of the jaws is the same grasp.

    Returns:
        Joint values [rad] (B, 4, 5), NaN where there are none; what became of each branch (B, 4): `REACHED`,
        `OFF_PLANE`, `TOO_FAR` or `BEYOND_LIMIT`; the joint furthest beyond its limit (B, 4) and how far [rad] (B, 4).
        Branches: towards the tool with each elbow, then backwards with each elbow.
    """
    B = tasks.shape[0]
    q = np.full((B, 4, 5), np.nan)
    status, joint, beyond = np.full((B, 4), OFF_PLANE), np.full((B, 4), -1), np.zeros((B, 4))
    for b in range(B):
        dx, dy = tasks[b, 0] - arm.axis_m[0], tasks[b, 1] - arm.axis_m[1]
        distance = np.hypot(dx, dy)
        towards = np.arctan2(dy, dx)
        if distance < 1e-12:  # above the axis: any plane will do, the approach says which
            towards = np.arctan2(tasks[b, 4], tasks[b, 3])
        for back in range(2):
            _solve_plane(
                arm, tasks[b], (towards + np.pi * back, distance * (1 - 2 * back)), q[b, 2 * back : 2 * back + 2],
                status[b, 2 * back : 2 * back + 2],
            )  # fmt: skip
            for branch in range(2 * back, 2 * back + 2):
                if status[b, branch] == REACHED:
                    _turn_into_limits(arm, near, alike and not np.isnan(tasks[b, 6]), q[b, branch])
                    joint[b, branch], beyond[b, branch] = _furthest_out(arm, q[b, branch])
                    if joint[b, branch] >= 0:
                        status[b, branch] = BEYOND_LIMIT
    return q, status, joint, beyond


@numba.njit(cache=True)
def _solve_plane(arm: PlanarArm, task: FloatArray, plane: tuple[float, float], q: FloatArray, status: IntArray) -> None:
    """Both elbows in one arm plane, given by its heading and the tool's distance along it."""
    heading, r = plane
    c, s = np.cos(heading), np.sin(heading)
    if abs(task[4] * c - task[3] * s) > _OFF_PLANE:
        return
    lean, height = task[3] * c + task[4] * s, task[5]
    pitch = np.arctan2(lean, height)
    sp, cp = np.sin(pitch), np.cos(pitch)
    w_r = r - arm.shoulder_m[0] - arm.hand_m[0] * sp - arm.hand_m[1] * cp
    w_z = task[2] - arm.shoulder_m[1] - arm.hand_m[0] * cp + arm.hand_m[1] * sp
    cosine = (w_r**2 + w_z**2 - arm.upper_m**2 - arm.lower_m**2) / (2.0 * arm.upper_m * arm.lower_m)
    if abs(cosine) > 1.0 + _SLACK:
        status[:] = TOO_FAR
        return
    roll = _roll(task, (c, s), (sp, cp))
    bend = np.arccos(min(1.0, max(-1.0, cosine)))
    for elbow in range(2):
        delta = bend if elbow == 0 else -bend
        phi2 = np.arctan2(w_r, w_z) - np.arctan2(arm.lower_m * np.sin(delta), arm.upper_m + arm.lower_m * np.cos(delta))
        q[elbow, 0] = arm.signs[0] * (heading - arm.angles_rad[0])
        q[elbow, 1] = phi2 - arm.angles_rad[1]
        q[elbow, 2] = arm.signs[2] * (phi2 + delta - arm.angles_rad[2] - q[elbow, 1])
        bent = q[elbow, 1] + arm.signs[2] * q[elbow, 2]
        q[elbow, 3] = arm.signs[3] * (pitch - arm.angles_rad[3] - bent)
        q[elbow, 4] = arm.signs[4] * (roll - arm.angles_rad[4])
        status[elbow] = REACHED


@numba.njit(cache=True)
def _roll(task: FloatArray, heading: tuple[float, float], pitch: tuple[float, float]) -> float:
    """Angle of the closing axis about the approach, from the direction that leans out; NaN if free."""
    (c, s), (sp, cp) = heading, pitch
    normal = task[7] * c - task[6] * s
    lean = (task[6] * c + task[7] * s) * cp - task[8] * sp
    return np.arctan2(normal, lean)


@numba.njit(cache=True)
def _turn_into_limits(arm: PlanarArm, near: FloatArray, alike: bool, q: FloatArray) -> None:
    """Add whole turns, and half turns to the roll if the jaws are alike, so that each joint is within and nearest."""
    for k in range(5):
        if np.isnan(q[k]):
            q[k] = min(arm.upper[k], max(arm.lower[k], near[k]))
            continue
        step = np.pi if k == 4 and alike else _TURN
        value = q[k] - step * np.round((q[k] - near[k]) / step)
        if value < arm.lower[k] - _SLACK:
            value += step * np.ceil((arm.lower[k] - _SLACK - value) / step)
        elif value > arm.upper[k] + _SLACK:
            value -= step * np.ceil((value - arm.upper[k] - _SLACK) / step)
        q[k] = value


@numba.njit(cache=True)
def _furthest_out(arm: PlanarArm, q: FloatArray) -> tuple[int, float]:
    """Joint furthest beyond its limit, and how far, the shorter way round; (-1, 0) if there is none."""
    joint, furthest = -1, 0.0
    for k in range(5):
        out = max(arm.lower[k] - q[k], q[k] - arm.upper[k])
        if out > _SLACK:
            other = q[k] + _TURN if q[k] < arm.lower[k] else q[k] - _TURN
            out = min(out, max(arm.lower[k] - other, other - arm.upper[k]))
            if out > furthest:
                joint, furthest = k, out
        q[k] = min(arm.upper[k], max(arm.lower[k], q[k])) if out <= _SLACK else q[k]
    return joint, furthest
