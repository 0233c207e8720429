"""How the base comes to stand beside a part: around it, and on another side of it where a wall is in the way."""

from collections.abc import Sequence

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2

# Ours. The base is 0.58 m long: nearer than this its centre may not pass the part; around it, it drives on a circle
# that leaves room for the arm, from point to point.
PASS_M = 0.38
CIRCLE_M = 0.75
STEP_RAD = np.radians(45.0)


def over_the_part(
    centre_m: FloatArray, theta_rad: float | None, hand_point_m: Sequence[float], turned_rad: float = 0.0
) -> Pose2:
    """Pose of the base from which the part's centre lies at a point of the base frame.

    Args:
        centre_m: Centre of the part [m], shape (2,).
        theta_rad: Its orientation [rad]; its long side then lies across the base, as jaws that point sideways need
            it. If None, the base faces the part from where the frame's origin is.
        hand_point_m: Where the centre is to lie, x, y in the base frame [m].
        turned_rad: By how much the base is turned about the part from there [rad].
    """
    turn = float(np.arctan2(centre_m[1], centre_m[0]))
    if theta_rad is not None:
        turn = float(theta_rad % np.pi - np.pi / 2.0)  # half a turn of the part is no difference
    turn += turned_rad
    x_m, y_m = centre_m - Pose2(0.0, 0.0, turn).apply(np.array(hand_point_m))
    return Pose2(x_m, y_m, turn)


def way_beside(goal: Pose2, part_m: FloatArray) -> list[Pose2]:
    """Waypoints of the base from the origin of its frame to a pose, not over the part.

    Args:
        goal: Pose in that frame.
        part_m: Centre of the part in that frame [m], shape (2,).

    Returns:
        Poses to drive to one after another: the goal alone, if the straight way passes the part at a distance or leads
        away from it; else back, and around it the shorter way.
    """
    if _nearest_m(goal.translation_m, part_m) >= min(PASS_M, float(np.linalg.norm(part_m)) - 1e-6):
        return [goal]
    start, end = (float(np.arctan2(*(point_m - part_m)[::-1])) for point_m in (np.zeros(2), goal.translation_m))
    turn_rad = float((end - start + np.pi) % (2.0 * np.pi) - np.pi)
    count = max(1, int(np.ceil(abs(turn_rad) / STEP_RAD)))
    angles = start + turn_rad * np.arange(count + 1) / count
    heading = float((goal.theta_rad + np.pi) % (2.0 * np.pi) - np.pi)
    points_m = part_m + CIRCLE_M * np.column_stack([np.cos(angles), np.sin(angles)])
    share = np.arange(count + 1) / count
    return [*(Pose2(x, y, s * heading) for (x, y), s in zip(points_m.tolist(), share.tolist(), strict=True)), goal]


def _nearest_m(end_m: FloatArray, part_m: FloatArray) -> float:
    """Distance of the part from the straight way from the origin [m]."""
    length_2 = float(end_m @ end_m)
    share = 0.0 if length_2 == 0.0 else float(np.clip(part_m @ end_m / length_2, 0.0, 1.0))
    return float(np.linalg.norm(part_m - share * end_m))
