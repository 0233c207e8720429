import pytest

from rfcompass.errors import InputError, UnknownMeter
from rfcompass.rf.meters.phase_dtw import PhaseDtwMeter
from rfcompass.rf.meters.registry import METERS, meter


def test_every_meter_is_found_under_its_own_name():
    assert all(meter(kind).kind == kind for kind in METERS)
    assert {"pinit_dtw", "phase_dtw", "phase_l1", "profile_l1", "aoa", "rssi", "auto"} <= set(METERS)


def test_parameters_are_handed_on():
    assert meter("phase_dtw", band_share=0.1) == PhaseDtwMeter(band_share=0.1)


def test_an_unknown_meter_is_refused_with_those_that_exist():
    with pytest.raises(UnknownMeter, match="phase_l1") as caught:
        meter("magic")
    assert caught.value.numbers == {"meter": "magic", "known": list(METERS)}


def test_an_unknown_parameter_is_refused():
    with pytest.raises(InputError, match="magic"):
        meter("rssi", magic=1)
