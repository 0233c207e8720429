"""Rigid registration of point sets in the plane, after [Kabsch1976] and [Umeyama1991]."""

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.geometry.pose2 import Pose2


def fit_pose2(points_b_m: FloatArray, points_a_m: FloatArray, weights: FloatArray | None = None) -> Pose2:
    """Find the pose `T_a_b` that best maps points of frame b onto their partners in frame a.

    Minimises Σ w_k |p_a,k - (R(θ) p_b,k + t)|². In the plane the optimum is closed-form:
    θ = atan2(Σ w (b × a), Σ w (b · a)) of the centred points.

    Args:
        points_b_m: Points in frame b [m], shape (K, 2).
        points_a_m: The same points in frame a [m], shape (K, 2).
        weights: Non-negative weights, shape (K,); equal weights if None.

    Raises:
        ShapeError: If fewer than two points, or points that all coincide, leave the turn undefined.
    """
    b = read_only(points_b_m, "points_b_m", (None, 2))
    a = read_only(points_a_m, "points_a_m", (len(b), 2))
    w = np.ones(len(b)) if weights is None else read_only(weights, "weights", (len(b),))
    if len(b) < 2 or (w < 0).any() or w.sum() <= 0:
        raise ShapeError(f"fit_pose2: needs two weighted points, got {len(b)}", points=len(b))
    b_mean, a_mean = np.average(b, axis=0, weights=w), np.average(a, axis=0, weights=w)
    db, da = b - b_mean, a - a_mean
    cross = float(w @ (db[:, 0] * da[:, 1] - db[:, 1] * da[:, 0]))
    dot = float(w @ (db * da).sum(axis=1))
    if np.hypot(cross, dot) <= 1e-12 * float(w.sum()):
        raise ShapeError("fit_pose2: coincident points do not define a turn", points=len(b))
    turn = Pose2(0.0, 0.0, np.arctan2(cross, dot))
    x_m, y_m = a_mean - turn.apply(b_mean)
    return Pose2(x_m, y_m, turn.theta_rad)
