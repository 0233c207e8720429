"""The advice names what shrinks the axis that is too wide, and following it does."""

from dataclasses import replace

import numpy as np
import pytest
from survey_scenes import RISE_M, square_m, two_heights_m, wrist_reads

from rfcompass.localization import WRIST_SAR, measure_more
from rfcompass.types import SearchVolume

TABLE = SearchVolume([-0.3, -0.3, 0.0], [0.3, 0.3, 0.2])
TAG_M = np.array([0.05, -0.1, 0.06])
NARROW_HZ = np.linspace(902e6, 928e6, 8)


def advice_for(trace, surveyor=WRIST_SAR, volume=TABLE):
    fix = surveyor.locate(trace, volume)
    return fix, measure_more(trace, fix, volume, surveyor)


def test_a_confident_fix_needs_nothing():
    fix, advice = advice_for(wrist_reads(TAG_M, two_heights_m(square_m(0.5, 0.35, 48))))
    assert fix.confident
    assert advice is None


def test_one_height_and_little_bandwidth_leave_the_height_open():
    _, advice = advice_for(wrist_reads(TAG_M, frequencies_hz=NARROW_HZ))
    assert "z" in advice.wide_axes
    assert {option.aid for option in advice.options} == {"second height", "longer side", "more bandwidth"}
    worst = [(option.box_m / advice.max_box_m).max() for option in advice.options]
    assert worst == sorted(worst)


def followed(option):
    """Reads with one of the options done."""
    low_m, f_hz = square_m(0.5, 0.45, 48), NARROW_HZ
    if option.aid == "second height":
        assert option.amount == RISE_M[2]
        return wrist_reads(TAG_M, two_heights_m(low_m), f_hz)
    if option.aid == "longer side":
        return wrist_reads(TAG_M, square_m(option.amount * 0.5 / np.ptp(low_m[:, 0]), 0.45, 48), f_hz)
    return wrist_reads(TAG_M, low_m, 915e6 + option.amount * np.linspace(-0.5, 0.5, 17))


@pytest.mark.parametrize("rank", [0, 1, 2])
def test_whoever_follows_the_advice_gets_the_box_that_it_promised(rank):
    """To a tenth: boxes are read off grids of a 24th of their extent."""
    _, advice = advice_for(wrist_reads(TAG_M, frequencies_hz=NARROW_HZ))
    option = advice.options[rank]
    box_m = WRIST_SAR.locate(followed(option), TABLE).box_m
    assert (np.abs(box_m / option.box_m - 1) < 0.1).all(), (option, box_m)
    assert option.enough == (option.box_m < advice.max_box_m).all()


def test_a_box_that_is_only_cut_off_is_said_to_be():
    loose = replace(WRIST_SAR, box_margin_m=0.0, max_box_m=(1.0, 1.0, 1.0))
    fix, advice = advice_for(wrist_reads([0.0, 0.0, 0.03]), loose)
    assert fix.clipped
    assert advice.clipped
    assert advice.wide_axes == ()


def test_reads_that_reflections_have_blurred_promise_less():
    """The measured box is 1.5 times free space's, so the promised ones are too."""
    trace = wrist_reads(TAG_M)
    fix = WRIST_SAR.locate(trace, TABLE)
    plain, blurred = (
        measure_more(trace, replace(fix, box_m=factor * fix.box_m, confident=False), TABLE, WRIST_SAR)
        for factor in (1.0, 1.5)
    )
    for one, other in zip(plain.options, blurred.options, strict=True):
        np.testing.assert_allclose(other.box_m, 1.5 * one.box_m)


def test_only_positions_and_carriers_that_heard_the_tag_count():
    trace = wrist_reads(TAG_M)
    counts = trace.read_counts.copy()
    counts[24:], counts[:, 5:] = 0, 0
    half = replace(trace, channel=trace.channel * counts, read_counts=counts)
    cut = wrist_reads(TAG_M, trace.antenna_positions_m[:24], trace.frequencies_hz[:5])
    _, advice = advice_for(half)
    _, expected = advice_for(cut)
    for one, other in zip(advice.options, expected.options, strict=True):
        assert one.amount == other.amount
        np.testing.assert_allclose(one.box_m, other.box_m, rtol=0.1)  # the last millimetre of the two peaks may differ


def test_a_known_height_stays_known():
    plane = SearchVolume([-0.3, -0.3, 0.05], [0.3, 0.3, 0.05])
    _, advice = advice_for(wrist_reads(TAG_M), replace(WRIST_SAR, max_box_m=(0.01, 0.01, 0.01)), plane)
    assert all(option.box_m[2] == 0.0 for option in advice.options)
    assert advice.wide_axes == ("x", "y")
