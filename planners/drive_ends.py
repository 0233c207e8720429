"""Poses at which a drive may end: facing a part, or near a goal that is not free."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2

# Ours: goals in place of one that is not free, by how far they lie from it [m], in how many directions, and turned by
# how much [rad]; a radian counts as 0.3 m, as for the search.
_RINGS_M = np.arange(0.1, 0.91, 0.1)
_DIRECTIONS = 16
_TURNS_RAD = np.radians([0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0])
_M_PER_RAD = 0.3
_SIDES = 24  # ours: of a part, from which it may be faced


def facing(
    part_m: FloatArray, off_m: Sequence[float], first_rad: float, aside_rad: Sequence[float] = (0.0,)
) -> list[Pose2]:
    """Poses about a part that face it.

    Args:
        part_m: Where it is [m], shape (2,).
        off_m: At which distances from it [m].
        first_rad: Heading of the first of them.
        aside_rad: By how much they may look past it.
    """
    headings_rad = first_rad + 2 * np.pi * np.arange(_SIDES) / _SIDES
    rows = product(off_m, headings_rad.tolist(), aside_rad)
    x_m, y_m = part_m.tolist()
    return [Pose2(x_m - r * float(np.cos(a)), y_m - r * float(np.sin(a)), float(a + turn)) for r, a, turn in rows]


def near_goals(goal: Pose2) -> list[Pose2]:
    """Places around a goal, the nearest first."""
    angles_rad = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    offsets = [(0.0, 0.0, turn) for turn in _TURNS_RAD[1:].tolist()]
    for off_m, angle, turn in product(_RINGS_M.tolist(), angles_rad.tolist(), _TURNS_RAD.tolist()):
        offsets.append((off_m * np.cos(angle), off_m * np.sin(angle), turn))
    offsets.sort(key=lambda row: round(float(np.hypot(row[0], row[1]) + _M_PER_RAD * abs(row[2])), 9))
    return [goal @ Pose2(float(x), float(y), float(turn)) for x, y, turn in offsets]
