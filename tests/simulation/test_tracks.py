"""Tracks go where they are told, at their spacing, and errors of a carrier keep what they are meant to keep."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError, ShapeError
from rfcompass.simulation import AntennaTrack

places = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)
spacings = st.floats(0.01, 0.5)


def steps_m(track):
    return np.linalg.norm(np.diff(track.positions_m, axis=0), axis=1)


@given(start_m=places, end_m=places, spacing_m=spacings)
def test_a_line_has_both_ends_and_equal_steps_no_longer_than_asked(start_m, end_m, spacing_m):
    track = AntennaTrack.line(start_m, end_m, spacing_m)
    np.testing.assert_allclose(track.positions_m[[0, -1]], [start_m, end_m], atol=1e-12)
    assert steps_m(track).max() <= spacing_m + 1e-9
    assert np.ptp(steps_m(track)) < 1e-9


@given(corners=st.lists(places, min_size=3, max_size=5), spacing_m=spacings)
def test_a_polyline_meets_every_corner_and_is_as_long_as_its_legs(corners, spacing_m):
    track = AntennaTrack.polyline(corners, spacing_m)
    for corner in corners:
        assert np.linalg.norm(track.positions_m - corner, axis=1).min() < 1e-9
    legs_m = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    assert steps_m(track).sum() == pytest.approx(legs_m.sum())


@given(side_m=st.floats(0.2, 1.0), height_m=st.floats(0.1, 1.0))
def test_a_square_is_level_and_closed_and_looks_down(side_m, height_m):
    track = AntennaTrack.square((1.0, 2.0), side_m, height_m)
    assert (track.positions_m[:, 2] == height_m).all()
    assert np.abs(track.positions_m[:, :2] - [1.0, 2.0]).max() == pytest.approx(side_m / 2)
    closing_m = np.linalg.norm(track.positions_m[0] - track.positions_m[-1])
    assert steps_m(track).sum() + closing_m == pytest.approx(4 * side_m)
    np.testing.assert_allclose(track.rotations[:, :, 0], np.tile([0, 0, -1.0], (len(track), 1)), atol=1e-12)


@given(facing_m=places)
def test_an_antenna_that_faces_a_point_points_at_it(facing_m):
    track = AntennaTrack.line((4.0, -1.0, 0.5), (4.0, 1.0, 0.5), facing_m=facing_m)
    towards = facing_m - track.positions_m
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    np.testing.assert_allclose(track.rotations[:, :, 0], towards, atol=1e-9)


def test_ports_in_turn_repeat_every_pose():
    track = AntennaTrack.line((0, 0, 0), (1, 0, 0), 0.25).through_ports([3, 1])
    assert track.ports.tolist() == [3, 1] * 5
    assert np.array_equal(track.positions_m[::2], track.positions_m[1::2])


def test_one_track_after_another_is_both():
    one, other = AntennaTrack.line((0, 0, 0), (1, 0, 0)), AntennaTrack.line((0, 1, 0), (0, 2, 0), port=2)
    both = one.then(other)
    assert len(both) == len(one) + len(other)
    assert both.ports[len(one)] == 2


def test_a_carrier_without_errors_goes_where_it_believes():
    track = AntennaTrack.line((0, 0, 0), (1, 0, 0))
    went = track.perturbed(np.random.default_rng(0))
    assert np.array_equal(went.positions_m, track.positions_m)


@given(seed=st.integers(0, 1000))
def test_offset_and_turn_move_a_track_as_a_whole(seed):
    track = AntennaTrack.line((0, 0, 0.3), (2, 0, 0.3))
    went = track.perturbed(np.random.default_rng(seed), offset_m=0.05, turn_rad=0.1)
    np.testing.assert_allclose(steps_m(went), steps_m(track), atol=1e-12)
    assert (went.positions_m[:, 2] == 0.3).all()


def test_a_walk_spreads_as_the_root_of_the_steps():
    track = AntennaTrack.line((0, 0, 0), (4, 0, 0), 0.04)
    went = [track.perturbed(np.random.default_rng(seed), walk_m_per_step=0.001) for seed in range(400)]
    off_m = np.array([one.positions_m - track.positions_m for one in went])
    for step in (24, 99):  # after 25 and 100 steps; the spread of 400 draws is good to 3.5 %
        assert off_m[:, step, :2].std() == pytest.approx(0.001 * np.sqrt(step + 1), rel=0.15)


@pytest.mark.parametrize("spacing_m", [0.0, -0.1, np.inf, np.nan])
def test_a_spacing_that_cannot_be_is_refused(spacing_m):
    with pytest.raises(InputError):
        AntennaTrack.line((0, 0, 0), (1, 0, 0), spacing_m)


def test_rotations_that_do_not_rotate_and_ports_below_one_are_refused():
    with pytest.raises(ShapeError):
        AntennaTrack(np.zeros((1, 3)), 2.0 * np.eye(3)[None], np.ones(1))
    with pytest.raises(ShapeError):
        AntennaTrack.at(np.zeros((1, 3)), port=0)
    with pytest.raises(InputError):
        AntennaTrack.polyline([(0, 0, 0)])
