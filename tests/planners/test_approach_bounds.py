"""No pair approaches faster than its reach allows, and what turns about its own axis does not count as moving."""

from itertools import combinations

import numpy as np
import pytest
from collision_scenes import ROBOT as YOUBOT
from collision_scenes import at, things
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.approach_bounds import _is_round, pair_reaches
from planners.motion_check import MotionChecker
from rfcompass.geometry import Pose2
from rfcompass.robots import load_robot
from rfcompass.robots.collision_model import CollisionModel
from rfcompass.robots.quick_collisions import QuickCollisions
from rfcompass.robots.solids import Solid
from rfcompass.robots.touching_links import random_joints
from rfcompass.types import Configuration, World

UR5E = load_robot("ur5e_2f85")
CHECKERS = {robot.name: QuickCollisions(CollisionModel(robot, things())) for robot in (YOUBOT, UR5E)}
REACHES = {name: pair_reaches(checker) for name, checker in CHECKERS.items()}
GJK_M = 5e-5  # its tolerance, twice and with room
Z = (np.zeros(3), np.array([0.0, 0.0, 1.0]))


def solid(kind, dimensions_m, T=None):
    none = np.zeros((0, 3))
    return Solid("thing", "link", kind, np.array(dimensions_m), np.eye(4) if T is None else T, none, none.astype(int))


@pytest.mark.parametrize("name", CHECKERS)
@given(seed=st.integers(0, 10**6), turn=st.floats(-1.5, 1.5), data=st.data())
@settings(max_examples=60)
def test_one_joint_alone_changes_no_distance_by_more_than_its_reach(name, seed, turn, data):
    checker = CHECKERS[name]
    robot = checker.model.robot
    joint = data.draw(st.integers(0, len(robot.joint_names) - 1))
    joints = random_joints(robot, np.random.default_rng(seed), 1)[0]
    moved = joints + turn * np.eye(len(joints))[joint]
    change_m = checker.distances(Configuration(moved)) - checker.distances(Configuration(joints))
    travel = robot.kinematics.joint_map.gain @ (moved - joints)
    assert (np.abs(change_m) <= REACHES[name][:, :-2] @ np.abs(travel) + GJK_M).all()


@pytest.mark.parametrize("name", CHECKERS)
@given(seed=st.integers(0, 10**6), x_m=st.floats(-0.5, 0.5), theta_rad=st.floats(-1.5, 1.5))
@settings(max_examples=40)
def test_the_base_changes_no_distance_by_more_than_its_turn_and_travel(name, seed, x_m, theta_rad):
    checker = CHECKERS[name]
    joints = random_joints(checker.model.robot, np.random.default_rng(seed), 1)[0]
    there_m = checker.distances(Configuration(joints, Pose2(x_m, 0.0, theta_rad)))
    change_m = there_m - checker.distances(Configuration(joints))
    bound_m = REACHES[name][:, -2:] @ np.abs([theta_rad, x_m])
    assert (np.abs(change_m) <= bound_m + GJK_M).all()


def test_the_upper_arm_of_a_ur5e_never_comes_nearer_to_its_pedestal():
    checker = QuickCollisions(CollisionModel(UR5E, World()))
    first = checker.pair_names.index(("base_link", "upper_arm_link"))
    assert not pair_reaches(checker)[first].any()
    draws = random_joints(UR5E, np.random.default_rng(0), 50)
    gaps_m = [checker.distances(Configuration(joints))[first] for joints in draws]
    assert np.ptp(gaps_m) < GJK_M


def test_turning_the_whole_arm_about_the_vertical_takes_few_checks():
    checker = QuickCollisions(CollisionModel(UR5E, World()))
    start = UR5E.posture("scan")
    report = MotionChecker(checker).check(start, Configuration(start.joints + np.eye(len(start.joints))[0]))
    assert report.free
    assert report.checks < 20  # 2.5 mm of air beside the pedestal made it hundreds


def test_travel_and_turns_about_the_vertical_change_nothing_over_the_floor():
    rows = [
        row for row, (_, j) in zip(REACHES[YOUBOT.name], CHECKERS[YOUBOT.name].pair_solids, strict=True) if j is None
    ]
    assert rows
    assert not np.array(rows)[:, -2:].any()
    assert not np.array(rows)[:, 0].any()  # arm_joint_1 turns about the vertical
    assert np.array(rows)[:, 1].any()


def test_where_no_pair_is_looked_at_every_motion_is_free():
    allowed = combinations(UR5E.kinematics.link_names, 2)
    checker = QuickCollisions(CollisionModel(UR5E, World(floor_m=None), allowed=allowed))
    assert pair_reaches(checker).shape == (0, len(UR5E.joint_names) + 2)
    start = UR5E.posture("scan")
    assert MotionChecker(checker).check(start, Configuration(start.joints + 1.0)).free


def test_a_cylinder_is_round_about_its_own_axis_alone():
    tilted, rod = np.eye(4), solid("cylinder", [0.05, 0.2])
    tilted[:3, :3] = [[1, 0, 0], [0, np.cos(0.01), -np.sin(0.01)], [0, np.sin(0.01), np.cos(0.01)]]
    assert _is_round(rod, at(0, 0, 0.3), Z)
    assert not _is_round(rod, at(1e-3, 0, 0.3), Z)
    assert not _is_round(rod, tilted, Z)
    assert not _is_round(rod, at(0, 0, 0.3), Z[::-1])  # a sliding joint


def test_a_ball_is_round_about_every_axis_through_its_middle():
    ball, axis = solid("sphere", [0.05]), np.array([0.6, 0.0, 0.8])
    assert _is_round(ball, at(*(0.3 * axis)), (np.zeros(3), axis))
    assert not _is_round(ball, at(0.3, 0, 0), (np.zeros(3), axis))
