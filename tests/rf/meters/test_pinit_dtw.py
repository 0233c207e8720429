import numpy as np
import pytest

from rfcompass.rf.dtw import dtw
from rfcompass.rf.meters.pinit_dtw import PinItDtwMeter
from rfcompass.rf.profiles import AngularProfile

POINTS_M = np.array([[0.3, 0.6, 0.0], [0.5, 0.6, 0.0], [0.8, 0.7, 0.0]])


@pytest.mark.parametrize(("band_rad", "band"), [(None, None), (np.radians(20), 20)])
def test_m_is_the_warping_distance_of_the_profiles(make_scan, band_rad, band):
    scan = make_scan(POINTS_M)
    a, b = (AngularProfile().of(scan.trace(epc))[0] for epc in ("e0", "e1"))
    found = PinItDtwMeter(band_rad=band_rad).measure(scan).anchor_m[0, 1]
    assert found == pytest.approx(dtw(a, b, band=band), rel=1e-12)


def test_the_band_is_an_angle_and_does_not_depend_on_the_number_of_angles(make_scan):
    scan = make_scan(POINTS_M)
    coarse, fine = (
        PinItDtwMeter(profile=AngularProfile(angles=angles), band_rad=np.radians(10), per_step=True).measure(scan).m
        for angles in (361, 721)
    )
    np.testing.assert_allclose(coarse, fine, rtol=0.05)


def test_a_free_warp_loses_the_displacement_that_a_band_keeps(make_scan):
    far_m = 40.0 * np.array([[np.cos(a), np.sin(a), 0.0] for a in np.radians([90.0, 85.0, 60.0])])
    scan = make_scan(far_m)
    ratio = {}
    for band_rad in (None, np.radians(5)):
        m = PinItDtwMeter(profile=AngularProfile(window="hann"), band_rad=band_rad).measure(scan).anchor_m
        ratio[band_rad] = m[0, 2] / m[0, 1]
    assert ratio[np.radians(5)] > 3 * ratio[None]


def test_sub_apertures_are_averaged_and_silent_ones_left_out(make_scan):
    heard = np.ones((51, 3), dtype=bool)
    heard[40:] = False
    meter = PinItDtwMeter(profile=AngularProfile(sub_apertures=5))
    scan = make_scan(POINTS_M, heard=heard)
    parts = [meter.profile.of(scan.trace(epc)) for epc in ("e0", "e1")]
    known = [dtw(a, b) for a, b in zip(*parts, strict=True) if np.isfinite(a).all()]
    assert len(known) == 4
    assert meter.measure(scan).anchor_m[0, 1] == pytest.approx(np.mean(known))
