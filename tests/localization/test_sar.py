"""The matched filter of the wrist: both antennas move, channels add up as complex numbers."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from survey_scenes import WRIST_HZ, square_m, two_heights_m, wrist_reads

from rfcompass.localization import WRIST_SAR, SarSurveyor, sar_image
from rfcompass.rf import Matching
from rfcompass.types import SearchVolume

TABLE = SearchVolume([-0.3, -0.3, 0.0], [0.3, 0.3, 0.2])
tags = st.tuples(st.floats(-0.25, 0.25), st.floats(-0.25, 0.25), st.floats(0.02, 0.15)).map(np.array)


@given(tag_m=tags, constant=st.floats(0, 6.3))
@settings(max_examples=15)
def test_a_wrist_with_two_antennas_finds_a_tag_to_millimetres_in_free_space(tag_m, constant):
    fix = WRIST_SAR.locate(wrist_reads(tag_m, constant_rad=constant), TABLE)
    assert np.linalg.norm(fix.point_m - tag_m) < 0.003


def test_taking_both_antennas_for_one_is_wrong_by_centimetres():
    """The round trip is d_tx + d_rx: with 10 cm between them, twice d_rx is up to 10 cm off."""
    tag_m = np.array([0.1, -0.1, 0.05])
    one = replace(wrist_reads(tag_m), tx_positions_m=None)
    assert np.linalg.norm(WRIST_SAR.locate(one, TABLE).point_m - tag_m) > 0.03


def test_going_the_square_twice_gives_the_same_place():
    tag_m = np.array([0.1, -0.1, 0.05])
    once, twice = square_m(0.5, 0.45, 48), np.tile(square_m(0.5, 0.45, 48), (2, 1))
    fixes = [WRIST_SAR.locate(wrist_reads(tag_m, path), TABLE) for path in (once, twice)]
    np.testing.assert_allclose(fixes[0].point_m, fixes[1].point_m, atol=1e-6)
    np.testing.assert_allclose(fixes[0].box_m, fixes[1].box_m, atol=1e-3)


def test_the_image_is_the_double_sum_of_the_paper_squared():
    """Eq. 1 by plain loops; the tabulated filter interpolates to 3e-4 of an amplitude."""
    trace = wrist_reads([0.05, 0.02, 0.04], square_m(0.5, 0.45, 8), WRIST_HZ[:3])
    field = SearchVolume([-0.06, -0.06, 0.04], [0.06, 0.06, 0.04])
    image = sar_image(trace, field, spacing_m=0.04, matching=WRIST_SAR.matching)
    k = 2 * np.pi * trace.frequencies_hz / 299_792_458.0
    peak = np.abs(trace.channel).max()
    for place in np.ndindex(image.values.shape):
        point_m = image.origin_m + image.spacing_m * np.array(place)
        total = 0.0
        for m in range(8):
            d = np.linalg.norm(point_m - trace.antenna_positions_m[m]) + np.linalg.norm(
                point_m - trace.tx_positions_m[m]
            )
            for i in range(3):
                total += trace.channel[m, i] / peak * np.exp(1j * k[i] * d)
        assert image.values[place] == pytest.approx(abs(total) ** 2, abs=24**2 * 1e-3)


def test_the_box_of_a_tag_on_the_table_reaches_below_it_and_is_not_cut_off():
    """20 cm beyond the search volume a one-height box of about 30 cm is seen whole; within it, it is not."""
    trace = wrist_reads([0.0, 0.0, 0.03])
    wide = WRIST_SAR.locate(trace, TABLE)
    narrow = replace(WRIST_SAR, box_margin_m=0.0).locate(trace, TABLE)
    assert not wide.clipped
    assert wide.box_m[2] > 0.2
    assert narrow.clipped
    assert narrow.box_m[2] <= 0.2


def test_a_second_height_makes_a_confident_fix_of_one_that_was_not():
    tag_m, low_m = [0.05, -0.1, 0.06], square_m(0.5, 0.35, 48)
    paths_m = low_m, two_heights_m(low_m)
    one, two = (WRIST_SAR.locate(wrist_reads(tag_m, path_m), TABLE) for path_m in paths_m)
    assert two.box_m[2] < one.box_m[2]
    assert not one.confident
    assert two.confident


@given(tag_m=tags)
@settings(max_examples=10)
def test_adding_channels_as_complex_numbers_never_widens_the_box(tag_m):
    trace = wrist_reads(tag_m, frequencies_hz=np.linspace(650e6, 1150e6, 9))
    coherent = WRIST_SAR.locate(trace, TABLE)
    by_power = replace(WRIST_SAR, matching=Matching(amplitude=True)).locate(trace, TABLE)
    assert (coherent.box_m <= 1.1 * by_power.box_m + 0.005).all()  # both are measured on grids of a few millimetres


def test_known_axes_have_no_margin():
    plane = SearchVolume([-0.3, -0.3, 0.05], [0.3, 0.3, 0.05])
    fix = WRIST_SAR.locate(wrist_reads([0.1, 0.0, 0.05]), plane)
    assert fix.point_m[2] == 0.05
    assert fix.box_m[2] == 0.0


def test_channels_with_constants_of_their_own_must_be_added_by_power():
    """As complex numbers they do not agree anywhere: the wrist's method then loses its peak."""
    rng, tag_m = np.random.default_rng(2), [0.1, 0.05, 0.05]
    trace = wrist_reads(tag_m)
    turned = replace(trace, channel=trace.channel * np.exp(1j * rng.uniform(0, 2 * np.pi, (1, WRIST_HZ.size))))
    by_power = SarSurveyor(matching=Matching(amplitude=True))
    assert np.linalg.norm(by_power.locate(turned, TABLE).point_m - tag_m) < 0.01
    assert np.linalg.norm(WRIST_SAR.locate(turned, TABLE).point_m - tag_m) > 0.03


def test_the_box_at_the_peak_is_the_box_of_the_fix():
    trace = wrist_reads([0.1, 0.05, 0.05])
    fix = WRIST_SAR.locate(trace, TABLE)
    np.testing.assert_array_equal(WRIST_SAR.box_at(trace, TABLE, fix.point_m).extent_m, fix.box_m)
