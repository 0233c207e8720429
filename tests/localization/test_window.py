"""Only the newest stops count: three motions, and at most two metres of the base's path."""

import numpy as np
import pytest
from compared_scenes import a_leg, leg_points

from rfcompass.errors import InputError
from rfcompass.geometry import Pose2
from rfcompass.localization.window import recent_stops
from rfcompass.types import Observation, TagPositions


def at(*base_poses):
    anchors, part = TagPositions("base", ("r1", "r2"), np.eye(3)[:2]), a_leg(leg_points(2))
    return [Observation(s, anchors, part, np.zeros(2), base_pose=pose) for s, pose in enumerate(base_poses)]


def ids(observations):
    return [stop.stop_id for stop in observations]


def test_three_motions_are_kept():
    assert ids(recent_stops(at(*[Pose2(0.1 * s) for s in range(5)]))) == [2, 3, 4]


def test_hand_motions_cost_no_travel():
    assert ids(recent_stops(at(*[Pose2()] * 5), max_motions=4, max_travel_m=0.0)) == [1, 2, 3, 4]


def test_two_metres_are_measured_along_the_path_not_as_the_crow_flies():
    there_and_back = at(Pose2(0.0), Pose2(1.5), Pose2(0.0))
    assert ids(recent_stops(there_and_back)) == [1, 2]


def test_turning_on_the_spot_costs_no_travel():
    assert ids(recent_stops(at(Pose2(), Pose2(0, 0, 2.0), Pose2(0, 0, -1.0)))) == [0, 1, 2]


def test_the_newest_stop_is_always_kept():
    assert ids(recent_stops(at(Pose2(), Pose2(9.0)))) == [1]


def test_no_observation_or_no_window_is_refused():
    with pytest.raises(InputError):
        recent_stops([])
    with pytest.raises(InputError):
        recent_stops(at(Pose2()), max_motions=0)
