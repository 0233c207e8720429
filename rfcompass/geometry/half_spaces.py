"""Bisectors: "nearer to anchor i than to anchor j" as one linear inequality [Wang2013], Eq. 2 and 5-6.

For a tag of the part at p_k = [x0, y0] + R(θ) q_k and height z_k, and anchors a_i, a_j in 3-D,

    |p_k - a_i|² <= |p_k - a_j|²

is linear in z' = [x0, y0, cos θ, sin θ], because the quadratic terms of p_k cancel. With Δ = a_j - a_i:

    [2Δx, 2Δy, 2Δx q_x + 2Δy q_y, 2Δy q_x - 2Δx q_y] · z' <= |a_j|² - |a_i|² - 2 Δz z_k.

The heights only change the right-hand side; the paper, in the plane, leaves them out.
"""

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2


def bisector_rows(
    nearer_m: FloatArray, farther_m: FloatArray, part_points_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rows of [Wang2013], Eq. 5-6, with the heights that the paper leaves out.

    Args:
        nearer_m: Anchor that each target is nearer to, base frame [m], shape (M, 3).
        farther_m: The other anchor of each comparison, base frame [m], shape (M, 3).
        part_points_m: Target tag of each comparison: x, y in the part frame, z in the base frame [m], shape (M, 3).

    Returns:
        A with shape (M, 4) over [x0, y0, cos θ, sin θ], and b with shape (M,).

    Deviations:
        The paper's tags all lie in one plane. Here b gains -2 Δz z_k + a_jz² - a_iz².
    """
    dx, dy, dz = (farther_m - nearer_m).T
    qx, qy, z = part_points_m.T
    A = 2.0 * np.column_stack([dx, dy, dx * qx + dy * qy, dy * qx - dx * qy])
    b = (farther_m**2).sum(axis=1) - (nearer_m**2).sum(axis=1) - 2.0 * dz * z
    return A, b


def change_frame(A: FloatArray, b: FloatArray, T_target_rows: Pose2) -> tuple[FloatArray, FloatArray]:
    """Express rows, written for a pose in one frame, in another frame [Wang2013], Eq. 9-12.

    With z'_target = U z'_rows + V, U = blkdiag(R(θm), R(θm)) and V = [xm, ym, 0, 0] (Eq. 9-11), the rows
    A z'_rows <= b become A U⁻¹ (z'_target - V) <= b (Eq. 12).

    Args:
        A: Rows over [x, y] or [x, y, cos θ, sin θ] in the rows' frame, shape (M, 2) or (M, 4).
        b: Right-hand sides, shape (M,).
        T_target_rows: Pose of the rows' frame in the target frame; (xm, ym, θm) of the paper.

    Returns:
        A U⁻¹ and b + A U⁻¹ V, same shapes.
    """
    R_inverse = T_target_rows.rotation.T
    blocks = [A[:, i : i + 2] @ R_inverse for i in range(0, A.shape[1], 2)]
    return np.hstack(blocks), b + blocks[0] @ T_target_rows.translation_m
