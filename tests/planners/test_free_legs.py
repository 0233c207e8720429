"""Legs between obstacles: clear of them, within bounds, of different kinds, and the most telling ones first."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.free_legs import DIFFERENT_M, DIFFERENT_RAD, LEGS, SHORTEST_M, Corridor, free_tracks_m, track_information

LOW_M, HIGH_M = np.array([0.4, 0.4]), np.array([5.6, 4.6])
AN_L_M = np.array([[[-1.5, 1.2, 0.3], [1.5, 1.2, 0.3]], [[1.2, -1.5, 0.3], [1.2, 1.5, 0.3]]])

places = st.tuples(st.floats(0.6, 5.4), st.floats(0.6, 4.4)).map(np.array)
desks = st.lists(
    st.tuples(st.floats(0.5, 5.0), st.floats(0.5, 4.0), st.floats(0.1, 1.0), st.floats(0.1, 1.0)), max_size=6
).map(lambda rows: np.array([[[x, y], [x + w, y + d]] for x, y, w, d in rows]).reshape(-1, 2, 2))


NOTHING = np.zeros((0, 2, 2))


def corridor(blocks_m=NOTHING):
    return Corridor(low_m=LOW_M, high_m=HIGH_M, blocks_m=blocks_m, height_m=0.3, length_m=3.0)


def summed_information(part_m, legs_m, samples=2000):
    """J by its definition, sample by sample."""
    J = np.zeros((2, 2))
    for start_m, end_m in legs_m[:, :, :2]:
        step_m = np.linalg.norm(end_m - start_m) / samples
        away_m = [start_m + (i + 0.5) / samples * (end_m - start_m) - part_m for i in range(samples)]
        weights = [step_m / (a @ a) for a in away_m]
        u = [a / np.linalg.norm(a) for a in away_m]
        mean = sum(w * v for w, v in zip(weights, u, strict=True)) / sum(weights)
        J += sum(w * np.outer(v - mean, v - mean) for w, v in zip(weights, u, strict=True))
    return np.linalg.eigvalsh(J)[0]


def test_the_information_is_the_integral_that_it_stands_for():
    part_m = np.array([0.2, -0.1])
    assert track_information(part_m, AN_L_M) == pytest.approx(summed_information(part_m, AN_L_M), rel=0.02)


@given(angle=st.floats(-3.0, 3.0), x=st.floats(-5.0, 5.0), scale=st.floats(0.5, 3.0))
def test_information_turns_with_the_room_and_falls_with_its_size(angle, x, scale):
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    moved_m = scale * AN_L_M @ R.T + np.array([x, 1.0, 0.0])
    told = track_information(np.array([x, 1.0]), moved_m)
    assert told == pytest.approx(track_information(np.zeros(2), AN_L_M) / scale, rel=1e-6)


def test_one_straight_leg_tells_less_than_two_and_one_that_points_at_the_part_nothing():
    part_m = np.zeros(2)
    assert track_information(part_m, AN_L_M[:1]) < 0.3 * track_information(part_m, AN_L_M)
    ahead_m = np.array([[[1.0, 0.0, 0.3], [3.0, 0.0, 0.3]]])
    assert track_information(part_m, ahead_m) == pytest.approx(0.0, abs=1e-12)


@given(part_m=places, blocks_m=desks)
def test_legs_lie_within_bounds_clear_of_all_blocks_and_are_no_stubs(part_m, blocks_m):
    for legs_m in free_tracks_m(part_m, corridor(blocks_m)):
        assert 2 <= len(legs_m) <= LEGS
        assert (legs_m[:, :, :2] >= LOW_M - 1e-9).all()
        assert (legs_m[:, :, :2] <= HIGH_M + 1e-9).all()
        for start_m, end_m in legs_m[:, :, :2]:
            assert SHORTEST_M - 1e-9 <= np.linalg.norm(end_m - start_m) <= 3.0 + 1e-9
            points_m = np.linspace(start_m, end_m, 300)[1:-1, None]
            inside = (points_m > blocks_m[:, 0] + 1e-9) & (points_m < blocks_m[:, 1] - 1e-9)
            assert not inside.all(axis=2).any()


@given(part_m=places, blocks_m=desks)
def test_no_leg_is_driven_twice(part_m, blocks_m):
    legs_m = np.concatenate([np.zeros((0, 2, 3)), *free_tracks_m(part_m, corridor(blocks_m))])
    along_m, middle_m = (legs_m[:, 1] - legs_m[:, 0])[:, :2], legs_m[:, :, :2].mean(axis=1)
    u = along_m / np.linalg.norm(along_m, axis=1)[:, None]
    for i in range(len(legs_m)):
        for j in range(i):
            near = np.linalg.norm(middle_m[i] - middle_m[j]) < DIFFERENT_M
            assert not (near and abs(u[i] @ u[j]) > np.cos(DIFFERENT_RAD) + 1e-12)


@given(x_m=st.floats(1.7, 4.3), y_m=st.floats(1.7, 3.3))
def test_in_an_empty_room_the_first_track_tells_more_than_an_l(x_m, y_m):
    part_m = np.array([x_m, y_m])
    first_m = next(free_tracks_m(part_m, corridor()))
    assert track_information(part_m, first_m) > track_information(np.zeros(2), AN_L_M)


def test_where_everything_is_full_there_is_no_track():
    assert not list(free_tracks_m(np.array([3.0, 2.5]), corridor(np.array([[[0.0, 0.0], [6.0, 5.0]]]))))
