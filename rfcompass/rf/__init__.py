"""Radio: waves, phases and profiles along an antenna path, warping, and proximity meters."""

from rfcompass.rf.channel_estimate import ChannelEstimate, estimate_channel
from rfcompass.rf.channel_offsets import ChannelOffsets, channel_offsets
from rfcompass.rf.dtw import dtw, dtw_matrix
from rfcompass.rf.hologram import Hologram, Matching, build_hologram
from rfcompass.rf.meters import (
    METERS,
    AoaMeter,
    AutoMeter,
    PhaseDtwMeter,
    PhaseL1Meter,
    PhaseRmsMeter,
    PinItDtwMeter,
    ProfileL1Meter,
    RssiMeter,
    SarNearfieldMeter,
    meter,
)
from rfcompass.rf.phases import PathProfile, path_profile, unwrapped_phase
from rfcompass.rf.profiles import AngularProfile
from rfcompass.rf.runs import runs
from rfcompass.rf.self_check import ComparatorQuality, DistanceCalibration, calibrate_distances, check_comparator
from rfcompass.rf.waves import SPEED_OF_LIGHT_M_S, free_space_channel, wavelength, wavenumber

__all__ = [
    "METERS",
    "SPEED_OF_LIGHT_M_S",
    "AngularProfile",
    "AoaMeter",
    "AutoMeter",
    "ChannelEstimate",
    "ChannelOffsets",
    "ComparatorQuality",
    "DistanceCalibration",
    "Hologram",
    "Matching",
    "PathProfile",
    "PhaseDtwMeter",
    "PhaseL1Meter",
    "PhaseRmsMeter",
    "PinItDtwMeter",
    "ProfileL1Meter",
    "RssiMeter",
    "SarNearfieldMeter",
    "build_hologram",
    "calibrate_distances",
    "channel_offsets",
    "check_comparator",
    "dtw",
    "dtw_matrix",
    "estimate_channel",
    "free_space_channel",
    "meter",
    "path_profile",
    "runs",
    "unwrapped_phase",
    "wavelength",
    "wavenumber",
]
