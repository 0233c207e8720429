"""The shortest way around outlines: never shorter than straight, known lengths, and free of what it goes around."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.evaluation.shortest_way import outlines_m, shortest_way_m
from rfcompass.types.scene import Obstacle
from rfcompass.types.shapes import Box, Cylinder

SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
points = st.tuples(st.floats(-4, 4), st.floats(-4, 4)).map(np.array)


def thing(shape, x_m=0.0, y_m=0.0, z_m=0.5, yaw_rad=0.0):
    T = np.eye(4)
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    T[:2, :2], T[:3, 3] = [[c, -s], [s, c]], (x_m, y_m, z_m)
    return Obstacle("thing", shape, T, "wood")


def test_straight_across_a_square_leads_around_two_corners():
    length_m = shortest_way_m(np.array([-2.0, 0.0]), np.array([2.0, 0.0]), [SQUARE])
    assert length_m == pytest.approx(2 + 2 * np.sqrt(2))


def test_along_a_side_and_past_a_corner_is_straight():
    assert shortest_way_m(np.array([-3.0, 1.0]), np.array([3.0, 1.0]), [SQUARE]) == pytest.approx(6.0)
    assert shortest_way_m(np.array([-3.0, -1.0]), np.array([1.0, 3.0]), [SQUARE]) == pytest.approx(4 * np.sqrt(2))


@settings(max_examples=60, deadline=None)
@given(points, points, st.floats(-3, 3))
def test_it_is_never_shorter_than_straight_and_a_way_back_is_as_long(start_m, end_m, yaw_rad):
    grown = outlines_m([thing(Box(np.array([2.0, 0.4, 1.0])), yaw_rad=yaw_rad)], 0.1, 0.2)
    there_m, back_m = shortest_way_m(start_m, end_m, grown), shortest_way_m(end_m, start_m, grown)
    assert there_m == pytest.approx(back_m)
    assert there_m >= np.linalg.norm(end_m - start_m) - 1e-6


@settings(max_examples=60, deadline=None)
@given(points, points, points)
def test_no_detour_over_a_third_point_is_shorter(start_m, end_m, third_m):
    inside = (np.abs(third_m) < 1).all()
    ways = [shortest_way_m(a, b, [SQUARE]) for a, b in ((start_m, end_m), (start_m, third_m), (third_m, end_m))]
    ends_inside = any((np.abs(end) < 1).all() for end in (start_m, end_m))
    if not inside and not ends_inside:
        assert ways[0] <= ways[1] + ways[2] + 1e-6


def test_a_ring_of_things_has_no_way_out():
    sides = [thing(Box(np.array([4.2, 0.2, 1.0])), y_m=y) for y in (-2.0, 2.0)]
    sides += [thing(Box(np.array([0.2, 4.2, 1.0])), x_m=x) for x in (-2.0, 2.0)]
    assert shortest_way_m(np.zeros(2), np.array([5.0, 0.0]), outlines_m(sides, 0.1, 0.1)) is None


def test_an_end_inside_a_thing_leaves_the_thing_out():
    assert shortest_way_m(np.zeros(2), np.array([3.0, 0.0]), [SQUARE]) == pytest.approx(3.0)


def test_what_hangs_higher_is_no_obstacle_and_growth_stays_inside_the_disc():
    assert outlines_m([thing(Box(np.array([1.0, 1.0, 0.1])), z_m=0.7)], 0.1, 0.2) == []
    (grown,) = outlines_m([thing(Cylinder(0.3, 1.0, "z"), 1.0, 2.0)], 0.1, 0.2)
    away_m = np.linalg.norm(grown - [1.0, 2.0], axis=1)
    assert away_m.max() <= 0.5 + 1e-9
    assert away_m.min() >= 0.45
