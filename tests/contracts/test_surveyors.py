"""What every surveyor obeys: it finds a tag in free space, moves with the frame, and ignores what it cannot know."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.errors import InputError, TagNeverHeard, TooFewReads
from rfcompass.interfaces import Surveyor
from rfcompass.localization import SURVEYORS, HyperbolicSurveyor, SarSurveyor, survey
from rfcompass.rf import Matching
from rfcompass.types import Scan, SearchVolume

sys.path.insert(0, str(Path(__file__).parents[1] / "localization"))
from survey_scenes import RAIL_M, reads_of, square_m

EVERY = {
    **SURVEYORS,
    "sar, amplitude kept": SarSurveyor(matching=Matching(amplitude=True)),
    "sar, differential": SarSurveyor(matching=Matching(differential=True)),
}
PLANE = SearchVolume([-0.2, 0.3, 0.0], [1.2, 1.2, 0.0])
ROOM = SearchVolume([-0.4, -0.4, 0.0], [0.4, 0.4, 0.3])
surveyors = pytest.mark.parametrize("surveyor", EVERY.values(), ids=EVERY)
tags = st.tuples(st.floats(0.1, 0.9), st.floats(0.45, 0.95)).map(lambda xy: np.array([*xy, 0.0]))
few = settings(max_examples=12)


def turned(trace, angle_rad, shift_m):
    """The same reads in a frame that is turned about z and shifted."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    return replace(trace, antenna_positions_m=trace.antenna_positions_m @ R.T + shift_m), R


@surveyors
def test_it_is_a_surveyor(surveyor):
    assert isinstance(surveyor, Surveyor)


@surveyors
@given(tag_m=tags)
@few
def test_it_finds_a_tag_in_free_space(surveyor, tag_m):
    fix = surveyor.locate(reads_of(tag_m), PLANE)
    flat = getattr(surveyor, "matching", Matching()).differential  # its peak is so flat that single precision shows
    assert np.linalg.norm(fix.point_m - tag_m) < (0.05 if flat else 0.01)


@surveyors
def test_it_finds_a_tag_in_three_dimensions(surveyor):
    tag_m = np.array([0.11, -0.07, 0.05])
    fix = surveyor.locate(reads_of(tag_m, square_m()), ROOM)
    assert np.linalg.norm(fix.point_m - tag_m) < 0.02


@surveyors
@given(tag_m=tags, quarter=st.integers(0, 3), dx=st.floats(-2, 2), dy=st.floats(-2, 2))
@few
def test_the_fix_moves_with_the_frame(surveyor, tag_m, quarter, dx, dy):
    trace, shift_m = reads_of(tag_m), np.array([dx, dy, 0.5])
    moved, R = turned(trace, quarter * np.pi / 2, shift_m)
    corners = np.stack([PLANE.lower_m, PLANE.upper_m]) @ R.T + shift_m
    fix = surveyor.locate(trace, PLANE)
    other = surveyor.locate(moved, SearchVolume(corners.min(axis=0), corners.max(axis=0)))
    assert np.linalg.norm(R @ fix.point_m + shift_m - other.point_m) < 0.005


@surveyors
def test_missing_cells_do_no_harm(surveyor):
    tag_m = np.array([0.6, 0.7, 0.0])
    assert np.linalg.norm(surveyor.locate(reads_of(tag_m, heard=0.5), PLANE).point_m - tag_m) < 0.01


@surveyors
def test_half_turns_do_no_harm_if_the_phase_is_known_modulo_pi(surveyor):
    tag_m = np.array([0.6, 0.7, 0.0])
    fix = surveyor.locate(reads_of(tag_m, modulus_rad=np.pi), PLANE)
    assert np.linalg.norm(fix.point_m - tag_m) < 0.01


@surveyors
def test_a_known_height_stays_as_it_is(surveyor):
    assert surveyor.locate(reads_of([0.5, 0.7, 0.0]), PLANE).point_m[2] == 0.0


@surveyors
def test_too_few_reads_are_no_answer(surveyor):
    trace = reads_of([0.5, 0.7, 0.0], RAIL_M[:3])
    with pytest.raises(TooFewReads) as caught:
        surveyor.locate(trace, PLANE)
    assert caught.value.numbers["epc"] == "tag"


def test_a_longer_path_makes_a_smaller_box():
    tag_m = [0.5, 0.7, 0.0]
    short, whole = (SarSurveyor().locate(reads_of(tag_m, RAIL_M[part]), PLANE) for part in (slice(10, 31), slice(41)))
    assert (whole.box_m[:2] < short.box_m[:2]).all()


def test_a_tag_at_the_border_of_the_volume_is_clipped_and_not_confident():
    volume = SearchVolume([-0.2, 0.3, 0.0], [1.2, 0.6, 0.0])
    for surveyor in (SarSurveyor(), HyperbolicSurveyor()):
        fix = surveyor.locate(reads_of([0.5, 0.7, 0.0]), volume)
        assert fix.clipped
        assert not fix.confident


def test_an_axis_that_the_path_does_not_observe_has_a_box_as_large_as_the_volume():
    """A straight path sees a circle about itself: heights and ranges trade against each other."""
    volume = SearchVolume([0.0, 0.4, -0.4], [1.0, 1.2, 0.4])
    fix = HyperbolicSurveyor().locate(reads_of([0.5, 0.7, 0.0]), volume)
    assert fix.box_m[2] > 0.3
    assert not fix.confident


def test_a_scan_is_surveyed_tag_by_tag():
    places = {"a": [0.3, 0.7, 0.0], "b": [0.7, 0.6, 0.0]}
    scan = Scan({epc: replace(reads_of(place), epc=epc) for epc, place in places.items()}, "rail", 2)
    fixes = survey(scan)
    assert [fix.epc for fix in fixes] == ["a", "b"]
    assert [fix.epc for fix in survey(scan, "sar", epcs=["b"])] == ["b"]
    for fix in fixes:
        assert np.linalg.norm(fix.point_m - places[fix.epc]) < 0.01
    with pytest.raises(TagNeverHeard):
        survey(scan, epcs=["c"])
    with pytest.raises(TagNeverHeard):
        survey(Scan())
    with pytest.raises(InputError, match="hyperbolic"):
        survey(scan, "magic")
