"""A tag that may have been moved: still there, somewhere near, or gone further than it is followed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from survey_scenes import wrist_reads

from rfcompass.errors import TooFewReads
from rfcompass.localization import WRIST_SAR, follow_tag
from rfcompass.localization.follow_tag import REACH_M
from rfcompass.types import SearchVolume, TagFix

TABLE = SearchVolume([-0.5, -0.4, 0.0], [0.5, 0.4, 0.3])
# One way of an arm, straight and half a metre high.
WAY_M = np.column_stack([np.linspace(0.5, 0.0, 24), np.linspace(-0.3, 0.1, 24), np.full(24, 0.55)])
places = st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(0.0, 0.1)).map(np.array)


def was_at(point_m):
    return TagFix("tag", np.asarray(point_m), np.full(3, 0.05), True)


def heard_at(point_m, path_m=WAY_M, constant_rad=0.7):
    return wrist_reads(point_m, path_m, constant_rad=constant_rad)


@given(place_m=places, constant_rad=st.floats(0, 6.3))
@settings(max_examples=20)
def test_a_tag_that_lay_still_keeps_its_fix(place_m, constant_rad):
    fix = was_at(place_m)
    assert follow_tag(heard_at(place_m, constant_rad=constant_rad), fix, TABLE, WRIST_SAR) is fix


@given(place_m=places, turn_rad=st.floats(0, 6.3), gone_m=st.floats(0.07, 0.12))
@settings(max_examples=20)
def test_a_tag_is_not_taken_for_a_worse_place_than_the_reads_tell(place_m, turn_rad, gone_m):
    """Wherever it went: what is said agrees with the reads as well as its true place, to the paper's 0.84."""
    now_m = place_m + gone_m * np.array([np.cos(turn_rad), np.sin(turn_rad), 0.0])
    trace = heard_at(now_m)
    followed = follow_tag(trace, was_at(place_m), TABLE, WRIST_SAR)
    assert agreement(trace, followed.point_m) >= 0.84 * agreement(trace, now_m) * (1 - 1e-6)


def agreement(trace, point_m):
    """Eq. 1 with the round trip of two antennas, summed as complex numbers, each cell with the same weight."""
    d_m = np.linalg.norm(trace.antenna_positions_m - point_m, axis=1)
    d_m = d_m + np.linalg.norm(trace.tx_positions_m - point_m, axis=1)
    turned = np.exp(2j * np.pi * d_m[:, None] * trace.frequencies_hz / 299792458.0)
    return abs((trace.channel * turned).sum()) ** 2


def test_across_a_way_a_tag_is_found_where_it_went():
    """From a way that passes over it from two sides there is no doubt."""
    corner_m = np.concatenate([WAY_M, WAY_M[:, [1, 0, 2]] * [1.0, -1.0, 1.0]])
    was_m, now_m = np.array([0.0, 0.0, 0.03]), np.array([0.09, -0.06, 0.03])
    followed = follow_tag(heard_at(now_m, corner_m), was_at(was_m), TABLE, WRIST_SAR)
    assert followed.confident
    assert np.linalg.norm(followed.point_m - now_m) < 0.02


def test_a_tag_that_went_further_than_it_is_followed_has_no_confident_fix():
    followed = follow_tag(heard_at([0.30, 0.0, 0.03]), was_at([0.0, 0.0, 0.03]), TABLE, WRIST_SAR)
    assert not followed.confident
    assert (np.abs(followed.point_m) <= REACH_M + 1e-9).all()


def test_what_was_found_stays_in_the_volume_also_for_a_tag_at_its_border():
    followed = follow_tag(heard_at([0.40, 0.39, 0.0]), was_at([0.50, 0.40, 0.0]), TABLE, WRIST_SAR)
    assert (followed.point_m >= TABLE.lower_m - 1e-9).all()
    assert (followed.point_m <= TABLE.upper_m + 1e-9).all()


def test_a_few_reads_are_no_answer():
    with pytest.raises(TooFewReads):
        follow_tag(heard_at([0, 0, 0.03], WAY_M[:1]), was_at([0, 0, 0.03]), TABLE, WRIST_SAR)
