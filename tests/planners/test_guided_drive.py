"""Guided drives: what the bumper finds is put on the map, and another way is looked for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.drive_around import DriveAround
from planners.guided_drive import BACK_M, MOST_BUMPS, GuidedDrive, _back, is_short, whole
from planners.map_pose import KnownStart
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import CollisionModel, QuickCollisions, YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot, WheelSlip
from rfcompass.types import PartEstimate
from rfcompass.types.configuration import Configuration
from rfcompass.types.shapes import Box
from rfcompass.types.world import Body, World

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
JOINTS = ROBOT.posture("scan").joints
T_MAP_ODOM = Pose2(2.0, -1.0, 0.8)
GOAL = Pose2(2.5, 0.0, 0.0)


def standing(x_m, y_m, size_m):
    T = np.eye(4)
    T[:3, 3] = x_m, y_m, size_m[2] / 2
    return Body("unknown", Box(np.array(size_m)), T)


def a_device(*solid, part_m=(4.0, 3.0)):
    room, rng = PlaneRoom(T_room_base=Pose2(), T_room_part=Pose2(*part_m, np.pi / 2)), np.random.default_rng(0)
    slip = WheelSlip(position_m=0.0, heading_rad=0.0)
    return SimulatedRobot(
        ROBOT, LEG, LEG.layout(4), room, rng, JOINTS, NoisyDistances(0.0), slip, solid=World(solid, None)
    )


def around(**options):
    return DriveAround(ROBOT, World(), KnownStart(T_MAP_ODOM), np.random.default_rng(0), **options)


def test_where_nothing_is_in_the_way_one_drive_is_enough():
    device = a_device()
    assert GuidedDrive(device, around()).drive(device.scan(), JOINTS, [GOAL]) == (GOAL,)


def test_an_unknown_thing_is_bumped_into_once_and_driven_around():
    device, guide = a_device(standing(1.3, 0.0, (0.1, 0.15, 0.05))), around()
    made = GuidedDrive(device, guide).drive(device.scan(), JOINTS, [GOAL])
    end = device.true_pose_in_room()
    assert 1 <= len(guide.bumps) <= MOST_BUMPS
    assert np.allclose(end.translation_m, GOAL.translation_m, atol=1e-6)
    assert np.allclose(whole(made).translation_m, end.translation_m, atol=1e-6)


def test_a_robot_that_is_walled_in_gives_up_and_says_how_far_it_got():
    walls = [standing(x, y, size) for x, y, size in [
        (1.0, 0.0, (0.1, 3.0, 0.5)), (-1.0, 0.0, (0.1, 3.0, 0.5)), (0.0, 1.0, (3.0, 0.1, 0.5)),
        (0.0, -1.0, (3.0, 0.1, 0.5))]]  # fmt: skip
    walls = [Body(f"wall_{i}", wall.shape, wall.T_parent_body) for i, wall in enumerate(walls)]
    device, guide = a_device(*walls), around()
    made = GuidedDrive(device, guide).drive(device.scan(), JOINTS, [GOAL])
    assert len(guide.bumps) <= MOST_BUMPS + 1
    assert np.linalg.norm(whole(made).translation_m) < 1.0
    assert np.abs(device.true_pose_in_room().translation_m).max() < 1.0


def test_the_first_goal_that_a_way_leads_to_is_taken():
    blocked = standing(2.5, 0.0, (0.3, 0.3, 0.5))
    at = np.eye(4)
    at[:2, :2], at[:2, 3] = T_MAP_ODOM.rotation, T_MAP_ODOM.translation_m
    mapped = Body("known", blocked.shape, at @ blocked.T_parent_body)
    guide = DriveAround(ROBOT, World((mapped,)), KnownStart(T_MAP_ODOM), np.random.default_rng(0))
    device, other = a_device(), Pose2(0.5, 1.0, 0.4)
    GuidedDrive(device, guide).drive(device.scan(), JOINTS, [GOAL, other])
    assert np.allclose(device.true_pose_in_room().translation_m, other.translation_m, atol=1e-6)


def test_the_sought_part_is_driven_around_where_it_seems_to_lie():
    device, guide = a_device(part_m=(1.2, 0.0)), around(part=LEG)
    seen = PartEstimate(LEG.part_id, np.array([1.2, 0.0]), np.pi / 2, "told", 1, height_m=LEG.resting_height_m)
    GuidedDrive(device, guide).drive(device.scan(), JOINTS, [GOAL], beside=seen)
    assert not guide.bumps
    assert np.allclose(device.true_pose_in_room().translation_m, GOAL.translation_m, atol=1e-6)


@settings(max_examples=8)
@given(st.floats(-np.pi, np.pi), st.floats(0.1, 2.0))
def test_what_was_bumped_into_is_put_just_before_the_robot(direction, rest_m):
    device, guide = a_device(), around()
    rest = Pose2(float(rest_m * np.cos(direction)), float(rest_m * np.sin(direction)), 0.0)
    guide.bumped(device.scan(), JOINTS, Pose2(), rest)
    checker = QuickCollisions(CollisionModel(ROBOT, World(tuple(guide.bumps), floor_m=None)))
    assert not checker.touching(Configuration(JOINTS, T_MAP_ODOM))
    step = Pose2(float(0.05 * np.cos(direction)), float(0.05 * np.sin(direction)), 0.0)
    assert checker.touching(Configuration(JOINTS, T_MAP_ODOM @ step))


def test_a_turn_that_was_stopped_tells_no_place():
    device, guide = a_device(), around()
    guide.bumped(device.scan(), JOINTS, Pose2(), Pose2(0.0, 0.0, 0.5))
    assert not guide.bumps


@pytest.mark.parametrize(("moved", "short"), [(Pose2(1.0, 0.0, 0.0), False), (Pose2(0.9, 0.0, 0.0), True)])
def test_a_drive_is_short_if_much_of_it_is_left(moved, short):
    assert is_short(Pose2(1.0, 0.0, 0.0), moved) is short


def test_a_bump_beside_the_part_is_the_parts_and_ends_the_drive():
    device, guide = a_device(), around()
    assert not guide.bumped(device.scan(), JOINTS, Pose2(), Pose2(1.0, 0.0, 0.0), np.array([0.6, 0.1]))
    assert guide.bumped(device.scan(), JOINTS, Pose2(), Pose2(1.0, 0.0, 0.0), np.array([1.6, 0.1]))
    assert len(guide.bumps) == 1


def test_a_bump_beside_a_thing_of_the_map_is_that_thing_which_is_kept_away_from_more():
    T = np.eye(4)
    T[:2, :2], T[:2, 3], T[2, 3] = T_MAP_ODOM.rotation, T_MAP_ODOM.apply(np.array([0.45, 0.0])), 0.25
    guide = DriveAround(
        ROBOT,
        World((Body("desk", Box(np.array([0.2, 0.5, 0.5])), T),)),
        KnownStart(T_MAP_ODOM),
        np.random.default_rng(0),
    )
    assert guide.bumped(a_device().scan(), JOINTS, Pose2(), Pose2(1.0, 0.0, 0.0))
    assert (guide.bumps, guide.wary) == ([], {"desk"})


def test_after_a_bump_the_robot_goes_back_the_way_it_came():
    device, guide = a_device(standing(1.3, 0.0, (0.1, 0.15, 0.05))), around()
    made = GuidedDrive(device, guide).drive(device.scan(), JOINTS, [GOAL])
    forward, back = made[:2]
    assert forward.x_m > 0.5
    assert np.isclose(back.x_m, -BACK_M)
    assert (back.y_m, back.theta_rad) == (0.0, 0.0)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3))
def test_backing_off_undoes_the_end_of_a_straight_drive(x_m, y_m, theta_rad):
    moved = Pose2(x_m, y_m, theta_rad)
    end_m = (moved @ _back(moved)).translation_m
    length_m = float(np.hypot(x_m, y_m))
    assert np.isclose(np.linalg.norm(end_m), max(0.0, length_m - BACK_M), atol=1e-9)
    assert abs(end_m[0] * y_m - end_m[1] * x_m) <= 1e-6
