"""Where the robot's base stands in the frame of the antenna path: its own tags, seen in near-field images."""

import numpy as np

from rfcompass.errors import TagNeverHeard
from rfcompass.localization.measuring import with_known_heights
from rfcompass.localization.rigid_fit import RigidFit, fit_rigid_part
from rfcompass.rf.meters.sar_nearfield import SarNearfieldMeter
from rfcompass.types.observation import Observation

LEAST_TAGS = 3  # ours: two tags fit anything


def locate_base(observation: Observation, meter: SarNearfieldMeter | None = None) -> RigidFit:
    """Lay the robot's tags, whose places in the base frame FK knows, through their near-field images.

    The carrier and the robot need no common map: one scan tells where each is for the other.

    Args:
        observation: One stop with its reads; the z axis of both frames counts from the floor.
        meter: Makes the images; `SarNearfieldMeter()` if None.

    Returns:
        Base pose in the frame of the antenna positions: `centre_m` and `theta_rad`, with its covariance.

    Raises:
        TagNeverHeard: If fewer than three of the robot's tags can be placed.
    """
    images, scan, anchors = meter or SarNearfieldMeter(), with_known_heights(observation), observation.anchors
    heard = np.array([epc in scan.traces for epc in anchors.epcs])
    seen_m = np.full((len(anchors.epcs), 2), np.nan)
    for index in np.flatnonzero(heard):
        epc = anchors.epcs[index]
        seen_m[index] = images.place(scan.traces[epc], scan.heights_m[epc])[:2]
    placed = np.isfinite(seen_m).all(axis=1)
    if placed.sum() < LEAST_TAGS:
        message = f"{placed.sum()} of the robot's {len(placed)} tags can be placed, {LEAST_TAGS} are needed"
        raise TagNeverHeard(message, heard=int(placed.sum()), needed=LEAST_TAGS)
    return fit_rigid_part(anchors.points_m[placed, :2], seen_m[placed])
