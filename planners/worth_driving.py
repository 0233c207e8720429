"""Whether an estimate is worth driving to, or the antenna had better look from elsewhere first."""

import numpy as np

from rfcompass.rf.self_check import own_scale
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.tags import TagPositions

# Ours, from the first stops of 80 tuning runs. Centres with a wider standard deviation were off by half of their
# distance and more; and where the robot's own tags seemed twice as far apart as they are, by metres, however sure.
LOST_M = 1.0
MOST_STRETCHED = 2.0
PLACED_M = 0.15  # ours: a part that is less well placed than this is no obstacle that one could drive around


def is_worth_driving(estimate: PartEstimate, matrix: ProximityMatrix, anchors: TagPositions) -> bool:
    """Tell whether a drive towards the part would lead there.

    Args:
        estimate: Where the part is; one without covariance is believed.
        matrix: What the newest scan says about distances.
        anchors: Where the robot's tags were in that scan.
    """
    scale = own_scale(matrix, anchors)
    if scale is not None and not 1.0 / MOST_STRETCHED <= scale <= MOST_STRETCHED:
        return False
    if estimate.covariance is None:
        return True
    return bool(np.linalg.eigvalsh(estimate.covariance[:2, :2])[-1] <= LOST_M**2)


def is_placed(estimate: PartEstimate) -> bool:
    """Tell whether a part is known well enough to drive around where it seems to lie.

    Args:
        estimate: Where it is. One without samples is of no posterior: its covariance, if it has one, does not say how
            far a pose from one stop's comparisons can be off.
    """
    if estimate.covariance is None or not len(estimate.samples):
        return False
    return bool(np.linalg.eigvalsh(estimate.covariance[:2, :2])[-1] <= PLACED_M**2)
