"""A scan takes its link through all poses, straight, and says why where it cannot."""

from itertools import pairwise

import numpy as np
import pytest

from planners.ik import InverseKinematics
from planners.motion_check import MotionChecker
from planners.scan_motion import ScanMotion, plan_scan
from rfcompass.robots import load_robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import Failure
from rfcompass.types.shapes import Box
from rfcompass.types.world import Body, World

ROBOT, LINK = load_robot("ur5e_2f85"), "camera_optical_link"
START = ROBOT.posture("scan")
DOWN = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


def corners(half_m=0.1, height_m=0.45, middle_m=0.45):
    poses = np.tile(np.eye(4), (5, 1, 1))
    poses[:, :3, :3] = DOWN
    ring = np.array([(1, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)]) * half_m
    poses[:, :3, 3] = np.column_stack([middle_m + ring[:, 0], ring[:, 1], np.full(5, height_m)])
    return poses


@pytest.fixture(scope="module")
def square():
    return plan_scan(InverseKinematics(ROBOT), LINK, corners(), START, spacing_m=0.05)


def test_it_stands_at_every_pose_that_was_asked_for(square):
    assert isinstance(square, ScanMotion)
    assert square.poses_of(ROBOT, LINK)[square.stops] == pytest.approx(corners(), abs=1e-5)


def test_waypoints_lie_on_the_sides_of_the_square_and_near_each_other(square):
    places = square.poses_of(ROBOT, LINK)[:, :3, 3]
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() <= 0.05 + 1e-5
    assert np.abs(places[:, :2] - [0.45, 0.0]).max(axis=1) == pytest.approx(0.1, abs=1e-5)


def test_nothing_touches_anywhere_on_the_way(square):
    checker = MotionChecker(InverseKinematics(ROBOT).collisions)
    assert checker.check_path([Configuration(row) for row in square.path]).free
    assert square.report.at_least_m > 0


def test_poses_in_the_world_are_those_in_the_base_moved_with_the_base(square):
    T = np.array([[0, -1, 0, 0.3], [1, 0, 0, -0.5], [0, 0, 1, 0.2], [0, 0, 0, 1.0]])
    moved = square.poses_of(ROBOT, "antenna_rx_link", T)
    assert moved == pytest.approx(T @ square.poses_of(ROBOT, "antenna_rx_link"), abs=1e-12)


def test_turns_are_spread_evenly_over_a_leg():
    poses = corners()[:2].copy()
    c, s = np.cos(0.4), np.sin(0.4)
    poses[1, :3, :3] = DOWN @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    motion = plan_scan(InverseKinematics(ROBOT), LINK, poses, START, spacing_m=0.05)
    turned = motion.poses_of(ROBOT, LINK)[:, :3, :3]
    steps = [np.arccos((np.trace(a.T @ b) - 1) / 2) for a, b in pairwise(turned)]
    assert steps == pytest.approx([0.4 / len(steps)] * len(steps), abs=1e-4)


def test_a_block_under_the_hand_is_named():
    T = np.eye(4)
    T[:3, 3] = 0.62, 0.0, 0.19  # the hand hangs 7 cm beyond the camera
    block = Body("block", Box(np.array([0.06, 0.06, 0.38])), T)
    failure = plan_scan(InverseKinematics(ROBOT, World((block,))), LINK, corners(), START)
    assert isinstance(failure, Failure)
    assert failure.kind == "scene_collision"
    assert "block" in failure.message
    assert 0 <= dict(failure.numbers)["at"] <= 1


def test_a_square_beyond_the_arm_is_out_of_reach():
    failure = plan_scan(InverseKinematics(ROBOT), LINK, corners(middle_m=1.4), START)
    assert (failure.kind, dict(failure.numbers)["at"]) == ("unreachable", 0.0)


@pytest.mark.parametrize(("count", "spacing_m"), [(1, 0.04), (5, 0.0), (5, -1.0)])
def test_what_cannot_be_a_scan_is_refused(count, spacing_m):
    with pytest.raises(ValueError, match="cannot be"):
        plan_scan(InverseKinematics(ROBOT), LINK, corners()[:count], START, spacing_m)
