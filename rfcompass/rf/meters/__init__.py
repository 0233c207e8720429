"""Proximity meters: one file each, and how to get one by name."""

from rfcompass.rf.meters.aoa import AoaMeter
from rfcompass.rf.meters.auto import AutoMeter
from rfcompass.rf.meters.phase_dtw import PhaseDtwMeter
from rfcompass.rf.meters.phase_l1 import PhaseL1Meter
from rfcompass.rf.meters.phase_rms import PhaseRmsMeter
from rfcompass.rf.meters.pinit_dtw import PinItDtwMeter
from rfcompass.rf.meters.profile_l1 import ProfileL1Meter
from rfcompass.rf.meters.registry import METERS, meter
from rfcompass.rf.meters.rssi import RssiMeter
from rfcompass.rf.meters.sar_nearfield import SarNearfieldMeter

__all__ = [
    "METERS",
    "AoaMeter",
    "AutoMeter",
    "PhaseDtwMeter",
    "PhaseL1Meter",
    "PhaseRmsMeter",
    "PinItDtwMeter",
    "ProfileL1Meter",
    "RssiMeter",
    "SarNearfieldMeter",
    "meter",
]
