"""Whether an estimate is worth driving to, or the antenna had better look from elsewhere first."""

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.rf.self_check import own_scale
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.tags import TagPositions

# Ours, from tuning runs: a centre with a wider standard deviation leads over detours, those above 1 m were off by half
# of their distance and more; and where the robot's own tags seemed twice as far apart as they are, by metres.
LOST_M = 0.5
MOST_STRETCHED = 2.0
PLACED_M = 0.15  # ours: a part that is less well placed than this is no obstacle that one could drive around


def is_worth_driving(estimate: PartEstimate, matrix: ProximityMatrix, anchors: TagPositions) -> bool:
    """Tell whether a drive towards the part would lead there; arguments as for `doubt_m`."""
    return doubt_m(estimate, matrix, anchors) <= LOST_M


def doubt_m(estimate: PartEstimate, matrix: ProximityMatrix, anchors: TagPositions) -> float:
    """Standard deviation of the centre along its worst direction [m]; infinite where it rests on ghosts.

    Args:
        estimate: Where the part is; one without covariance is believed.
        matrix: What the newest scan says about distances.
        anchors: Where the robot's tags were in that scan.
    """
    scale = own_scale(matrix, anchors)
    if scale is not None and not 1.0 / MOST_STRETCHED <= scale <= MOST_STRETCHED:
        return float("inf")
    if estimate.covariance is None:
        return 0.0
    return _worst_m(estimate.covariance)


def is_placed(estimate: PartEstimate) -> bool:
    """Tell whether a part is known well enough to drive around where it seems to lie.

    Args:
        estimate: Where it is. One without samples is of no posterior: its covariance, if it has one, does not say how
            far a pose from one stop's comparisons can be off.
    """
    if estimate.covariance is None or not len(estimate.samples):
        return False
    return _worst_m(estimate.covariance) <= PLACED_M


def _worst_m(covariance: FloatArray) -> float:
    return float(np.sqrt(np.linalg.eigvalsh(covariance[:2, :2])[-1]))
