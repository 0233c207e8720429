"""Certificates of motions: the gap-free check of one library, and many looks by another, independent one."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from planners.motion_check import MotionReport, between
from rfcompass.robots import FclCollisions
from rfcompass.types.configuration import Configuration
from rfcompass.types.motions import StageCertificate

# Ours: how far fcl's looks at a path may be apart [rad or m].
_STEP = 0.05


def certify(fcl: FclCollisions, stage: str, path: Sequence[Configuration], report: MotionReport) -> StageCertificate:
    """Let fcl look along a path that was checked without gaps.

    Args:
        fcl: What must not touch.
        stage: What the path is for.
        path: Configurations with straight motions between them.
        report: What the gap-free check found.
    """
    places = _places(path)
    apart = report.free and not any(map(fcl.collides, places))
    return StageCertificate(stage, fcl.pair_count, len(places), apart, report.clearance, report.at_least_m)


def _places(path: Sequence[Configuration]) -> list[Configuration]:
    """Waypoints, and places between them so that nothing moves more than a step from one to the next."""
    places = [path[0]]
    for a, b in pairwise(path):
        moved = a.base.inverse() @ b.base
        farthest = max(np.abs(b.joints - a.joints).max(), np.hypot(moved.x_m, moved.y_m), abs(moved.theta_rad))
        count = max(1, int(np.ceil(farthest / _STEP)))
        places += [between(a, b, k / count) for k in range(1, count + 1)]
    return places
