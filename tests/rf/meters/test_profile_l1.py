import numpy as np
import pytest

from rfcompass.rf.meters.profile_l1 import ProfileL1Meter
from rfcompass.rf.profiles import AngularProfile

POINTS_M = np.array([[0.3, 0.6, 0.0], [0.5, 0.6, 0.0]])


@pytest.mark.parametrize("profile", [AngularProfile(), AngularProfile(sub_apertures=4, window="hann")])
def test_m_is_the_mean_difference_of_the_profiles(make_scan, profile):
    scan = make_scan(POINTS_M)
    a, b = (profile.of(scan.trace(epc)) for epc in ("e0", "e1"))
    found = ProfileL1Meter(profile=profile).measure(scan).anchor_m[0, 1]
    assert found == pytest.approx(np.abs(a - b).mean(), rel=1e-12)
