import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.rf.meters.aoa import AoaMeter, peak_place

angles = st.floats(0.6, np.pi - 0.6)


@given(angles, angles)
def test_m_is_the_angle_between_far_tags(make_scan, one_rad, other_rad):
    points_m = [0.5, 0.0, 0.0] + 60.0 * np.array([[np.cos(a), np.sin(a), 0.0] for a in (one_rad, other_rad)])
    found = AoaMeter().measure(make_scan(points_m)).anchor_m[0, 1]
    assert found == pytest.approx(abs(one_rad - other_rad), abs=0.01)


@given(st.floats(2.0, 8.0))
def test_the_peak_of_a_parabola_is_found_between_samples(place):
    assert peak_place(-((np.arange(11.0) - place) ** 2)) == pytest.approx(place)


@pytest.mark.parametrize(("profile", "place"), [([3.0, 1.0, 0.0], 0.0), ([0.0, 1.0, 3.0], 2.0), ([1.0, 1.0, 1.0], 0.0)])
def test_a_peak_at_the_edge_stays_there(profile, place):
    assert peak_place(np.array(profile)) == place


def test_a_missing_profile_has_no_peak():
    assert np.isnan(peak_place(np.array([0.0, np.nan, 1.0])))
