"""Ways past corners: free, nearly as short as can be, straight where that is free, and none where there is none."""

import numpy as np
import pytest

from planners.corner_ways import corner_poses, way_past_corners
from planners.drive_ends import facing
from planners.motion_check import MotionChecker
from rfcompass.geometry import Pose2
from rfcompass.robots import CollisionModel, QuickCollisions, YouBot
from rfcompass.types.configuration import Configuration
from rfcompass.types.shapes import Box
from rfcompass.types.world import Body, World

ROBOT = YouBot()
JOINTS = ROBOT.posture("scan").joints
START = Configuration(JOINTS, Pose2(-1.5, 0.0, 0.0))


def box(x_m, y_m, size_m=(0.3, 1.0, 1.0), turn_rad=0.0, name="thing"):
    T = np.eye(4)
    T[:2, :2], T[:3, 3] = Pose2(0.0, 0.0, turn_rad).rotation, (x_m, y_m, size_m[2] / 2)
    return Body(name, Box(np.array(size_m)), T)


def checker_of(*bodies):
    return MotionChecker(QuickCollisions(CollisionModel(ROBOT, World(bodies))))


def length_m(path):
    return np.linalg.norm(np.diff([row.base.translation_m for row in path], axis=0), axis=1).sum()


def test_a_straight_drive_that_is_free_is_the_way():
    goal = Pose2(1.5, 0.3, 1.0)
    path = way_past_corners(checker_of(box(0.0, 3.0)), START, [goal])
    assert [row.base for row in path] == [START.base, goal]


@pytest.mark.parametrize("turn_rad", [0.0, 0.4])
def test_a_way_around_a_box_is_free_and_little_longer_than_past_its_corner(turn_rad):
    checker = checker_of(box(0.0, 0.0, turn_rad=turn_rad))
    path = way_past_corners(checker, START, [Pose2(1.5, 0.0, 0.0)])
    assert checker.check_path(path).free
    assert 3.0 < length_m(path) < 2 * np.hypot(1.5, 0.5 + 0.42)


def test_of_two_sides_the_shorter_is_taken():
    checker = checker_of(box(0.0, 0.4))
    path = way_past_corners(checker, START, [Pose2(1.5, 0.0, 0.0)])
    assert min(row.base.y_m for row in path) < -0.2
    assert max(row.base.y_m for row in path) <= 0.0


def test_of_several_goals_the_one_with_the_shortest_way_is_reached():
    part_m = np.array([1.0, 0.0])
    checker = checker_of(box(0.0, 0.0))
    ends = facing(part_m, (0.5,), 0.0)
    path = way_past_corners(checker, START, ends)
    alone_m = [length_m(way) for way in (way_past_corners(checker, START, [end]) for end in ends[::6]) if way]
    assert length_m(path) <= min(alone_m) + 0.2
    assert np.linalg.norm(path[-1].base.translation_m - part_m) == pytest.approx(0.5)


def test_poses_that_face_a_part_look_at_it_and_the_first_comes_from_where_it_is_asked():
    part_m = np.array([1.0, 2.0])
    poses = facing(part_m, (0.4, 0.5), 0.7)
    assert poses[0].theta_rad == pytest.approx(0.7)
    for pose in poses:
        assert pose.inverse().apply(part_m) == pytest.approx([np.linalg.norm(pose.translation_m - part_m), 0.0])


def test_where_no_goal_is_free_or_no_way_leads_there_is_none():
    walls = [box(1.0, 0.0, (0.1, 2.1, 1.0), 0.0, "front"), box(-1.0, 0.0, (0.1, 2.1, 1.0), 0.0, "back"),
             box(0.0, 1.0, (2.1, 0.1, 1.0), 0.0, "left"), box(0.0, -1.0, (2.1, 0.1, 1.0), 0.0, "right")]  # fmt: skip
    inside = Configuration(JOINTS, Pose2())
    assert way_past_corners(checker_of(*walls), inside, [Pose2(3.0, 0.0, 0.0)]) == ()
    assert way_past_corners(checker_of(*walls), inside, [Pose2(1.0, 0.0, 0.0)]) == ()


def test_no_corner_outside_the_area_is_passed():
    checker = checker_of(box(0.0, 0.4))
    path = way_past_corners(checker, START, [Pose2(1.5, 0.0, 0.0)], ((-2.0, -0.05), (2.0, 2.0)))
    assert min(row.base.y_m for row in path) >= -0.05
    assert max(row.base.y_m for row in path) > 0.9


def test_corners_of_a_turned_body_turn_with_it():
    turned, straight = corner_poses([box(0.0, 0.0, turn_rad=0.3)], []), corner_poses([box(0.0, 0.0)], [])
    back = Pose2(0.0, 0.0, -0.3).apply(turned[:, :2])
    assert back == pytest.approx(straight[:, :2])
    assert turned[:, 2] == pytest.approx(straight[:, 2] + 0.3)
