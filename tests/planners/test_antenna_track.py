"""Two legs at right angles, at their distance from the part, and inside what the carrier may drive."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.antenna_track import LEAST_LEG_M, NearTrack
from rfcompass.errors import OutOfReach

TRACK = NearTrack()


def foot_m(part_m, leg_m):
    """Distance of a place from the line through a leg [m]."""
    along = (leg_m[1] - leg_m[0])[:2] / np.linalg.norm((leg_m[1] - leg_m[0])[:2])
    away = part_m - leg_m[0, :2]
    return abs(along[0] * away[1] - along[1] * away[0])


@given(x_m=st.floats(1.7, 4.3), y_m=st.floats(1.7, 3.3))
def test_every_part_in_the_middle_of_the_room_gets_two_whole_legs(x_m, y_m):
    part_m = np.array([x_m, y_m])
    legs_m = TRACK.legs_m(part_m)
    assert legs_m.shape == (2, 2, 3)
    for leg_m in legs_m:
        assert foot_m(part_m, leg_m) == pytest.approx(TRACK.stand_off_m)
        assert np.linalg.norm(leg_m[1] - leg_m[0]) == pytest.approx(TRACK.length_m)
        assert (leg_m[:, :2] >= np.array(TRACK.low_m) - 1e-9).all()
        assert (leg_m[:, :2] <= np.array(TRACK.high_m) + 1e-9).all()
    one, other = legs_m[0, 1] - legs_m[0, 0], legs_m[1, 1] - legs_m[1, 0]
    assert one @ other == pytest.approx(0.0, abs=1e-9)


def test_the_legs_keep_to_the_side_that_has_room():
    near_corner = TRACK.legs_m(np.array([0.9, 0.9]))
    assert near_corner[0, 0, 1] == pytest.approx(2.1)
    assert near_corner[1, 0, 0] == pytest.approx(2.1)


def test_a_closet_has_no_room():
    with pytest.raises(OutOfReach) as refused:
        NearTrack(low_m=(0.0, 0.0), high_m=(2.0, 2.0)).legs_m(np.array([1.0, 1.0]))
    assert refused.value.numbers == {"part_m": [1.0, 1.0], "needed_m": LEAST_LEG_M}


blocks = st.lists(
    st.tuples(st.floats(0.5, 5.0), st.floats(0.5, 4.0), st.floats(0.1, 1.0), st.floats(0.1, 1.0)), max_size=5
)


@given(corner=st.sampled_from([(0, 0), (0, 1), (1, 0), (1, 1)]), desks=blocks)
def test_legs_along_the_walls_keep_clear_of_all_that_stands_there(corner, desks):
    keep_out_m = np.array([[[x, y], [x + w, y + d]] for x, y, w, d in desks]).reshape(-1, 2, 2)
    try:
        legs_m = TRACK.corner_legs_m(corner, keep_out_m)
    except OutOfReach:
        return
    for start_m, end_m in legs_m[:, :, :2]:
        points_m = np.linspace(start_m, end_m, 200)[:, None]
        inside = (points_m > keep_out_m[:, 0] - 0.249) & (points_m < keep_out_m[:, 1] + 0.249)
        assert not inside.all(axis=2).any()
        assert np.linalg.norm(end_m - start_m) >= LEAST_LEG_M - 1e-9


def test_free_legs_keep_the_carriers_distance_from_what_stands_there():
    desk_m = np.array([[[2.0, 1.2], [4.0, 1.5]]])
    for legs_m in TRACK.free_m(np.array([3.0, 2.5]), desk_m):
        for start_m, end_m in legs_m[:, :, :2]:
            points_m = np.linspace(start_m, end_m, 200)
            low_m, high_m = desk_m[0] + np.array([[-1.0], [1.0]]) * (TRACK.clear_m - 1e-6)
            assert not ((points_m > low_m) & (points_m < high_m)).all(axis=1).any()
