"""The base comes to stand beside the part, on the side that is asked, and never drives over it on the way."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from planners.beside_part import CIRCLE_M, PASS_M, over_the_part, way_beside
from rfcompass.geometry.pose2 import Pose2

HAND_M = (0.42, 0.0)
angles = st.floats(-3.1, 3.1)


@given(x_m=st.floats(-3.0, 3.0), y_m=st.floats(-3.0, 3.0), theta_rad=angles, turned_rad=angles)
def test_the_part_comes_to_lie_where_the_hand_is(x_m, y_m, theta_rad, turned_rad):
    centre_m = np.array([x_m, y_m])
    goal = over_the_part(centre_m, theta_rad, HAND_M, turned_rad)
    assert goal.inverse().apply(centre_m) == pytest.approx(np.array(HAND_M), abs=1e-9)
    assert abs(np.cos(theta_rad - goal.theta_rad + turned_rad)) < 1e-6  # across the base before it turns


def test_a_part_whose_turn_is_unknown_is_faced():
    goal = over_the_part(np.array([1.0, 1.0]), None, HAND_M)
    assert goal.theta_rad == pytest.approx(np.pi / 4)


@given(part_rad=angles, away_m=st.floats(0.3, 1.5), goal_rad=angles, heading=angles)
def test_no_way_leads_nearer_to_the_part_than_it_begins_or_may(part_rad, away_m, goal_rad, heading):
    part_m = away_m * np.array([np.cos(part_rad), np.sin(part_rad)])
    x_m, y_m = part_m + 0.42 * np.array([np.cos(goal_rad), np.sin(goal_rad)])
    stands_m, goal = np.zeros(2), Pose2(x_m, y_m, heading)
    way = way_beside(goal, part_m)
    assert way[-1] == goal
    for pose in way:
        steps_m = stands_m + np.linspace(0.0, 1.0, 50)[:, None] * (pose.translation_m - stands_m)
        nearest_m = np.linalg.norm(steps_m - part_m, axis=1).min()
        assert nearest_m >= min(PASS_M, away_m) - 1e-6
        stands_m = pose.translation_m


@given(goal_rad=angles)
def test_around_the_part_it_drives_the_shorter_way_on_a_circle(goal_rad):
    part_m = np.array([0.42, 0.0])
    x_m, y_m = part_m + 0.42 * np.array([np.cos(goal_rad), np.sin(goal_rad)])
    way = way_beside(Pose2(x_m, y_m, 0.5), part_m)
    assume(len(way) > 1)
    from_part_m = np.array([pose.translation_m for pose in way[:-1]]) - part_m
    assert np.linalg.norm(from_part_m, axis=1) == pytest.approx(CIRCLE_M)
    turned = np.diff(np.unwrap(np.arctan2(from_part_m[:, 1], from_part_m[:, 0])))
    assert abs(turned.sum()) <= np.pi + 1e-9
