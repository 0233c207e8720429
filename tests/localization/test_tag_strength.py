"""In free space a tag has one strength wherever it is, and it is found at its place."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from survey_scenes import RAIL_M, reads_of, square_m, wrist_reads

from rfcompass.localization.tag_strength import tag_strength

points = st.tuples(st.floats(0.0, 1.0), st.floats(0.4, 1.2), st.just(0.0)).map(np.array)


@given(points, points)
def test_equal_tags_are_equally_strong_at_their_places(one_m, other_m):
    one, other = tag_strength(reads_of(one_m)), tag_strength(reads_of(other_m, heard=0.5, seed=3))
    assert one.at(one_m) == pytest.approx(other.at(other_m), abs=1e-9)


def test_tags_seen_with_two_antennas_are_equally_strong_at_their_places():
    places = np.array([0.1, -0.05, 0.0]), np.array([-0.1, 0.12, 0.05])
    one, other = (tag_strength(wrist_reads(place)).at(place) for place in places)
    assert one == pytest.approx(other, abs=1e-9)


@given(points, st.floats(-30, 30))
def test_more_power_is_more_strength_by_as_many_decibels(point_m, gain_db):
    trace = reads_of([0.4, 0.7, 0.0])
    louder = replace(trace, channel=trace.channel * 10 ** (gain_db / 20))
    assert tag_strength(louder).at(point_m) - tag_strength(trace).at(point_m) == pytest.approx(gain_db, abs=1e-9)


@given(points)
def test_a_tag_farther_off_must_be_stronger_to_be_heard_as_well(point_m):
    strength = tag_strength(reads_of([0.4, 0.7, 0.0]))
    assert strength.at(point_m + np.array([0.0, 0.1, 0.0])) > strength.at(point_m)


@pytest.mark.parametrize("trace", [reads_of([0.4, 0.7, 0.0], heard=0.7), wrist_reads([0.1, 0.0, 0.0])], ids=["1", "2"])
@given(point_m=points, axis=st.integers(0, 2))
def test_the_gradient_is_the_derivative(trace, point_m, axis):
    strength, step = tag_strength(trace), 1e-5 * np.eye(3)[axis]
    slope = (strength.at(point_m + step) - strength.at(point_m - step)) / 2e-5
    assert strength.gradient(point_m)[axis] == pytest.approx(slope, abs=1e-4)


def test_a_fade_costs_less_than_its_decibels_in_the_mean():
    """Half of the amplitudes 40 dB down: 20 dB in a mean of decibels, 5.9 dB in the mean of amplitudes."""
    trace = reads_of([0.0, 0.0, -2.0], square_m(height_m=0.0))
    faded = np.where(np.arange(len(trace.channel))[:, None] % 2, trace.channel, 0.01 * trace.channel)
    loss = tag_strength(trace).at(np.array([0.0, 0.0, -2.0])) - tag_strength(replace(trace, channel=faded)).at(
        np.array([0.0, 0.0, -2.0])
    )
    assert loss == pytest.approx(-20 * np.log10((1 + 0.01) / 2), abs=0.5)


def test_positions_where_nothing_was_heard_do_not_count():
    trace = reads_of([0.4, 0.7, 0.0])
    heard = (np.arange(len(RAIL_M)) < 20)[:, None]
    part = replace(trace, channel=trace.channel * heard, read_counts=trace.read_counts * heard)
    assert tag_strength(part).at(np.array([0.4, 0.7, 0.0])) == pytest.approx(
        tag_strength(trace).at(np.array([0.4, 0.7, 0.0])), abs=1e-9
    )
