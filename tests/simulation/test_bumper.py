"""The bumper: a drive ends before what is solid, and never earlier than it must."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import CollisionModel, FclCollisions, YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot, WheelSlip
from rfcompass.simulation.bumper import LOOK_M, until_touching
from rfcompass.types.configuration import Configuration
from rfcompass.types.shapes import Box
from rfcompass.types.world import Body, World

ROBOT = YouBot()
JOINTS = ROBOT.posture("scan").joints
LEGS = PartDatabase(":memory:").assembly("LACK")
NO_SLIP = WheelSlip(position_m=0.0, heading_rad=0.0)


def standing(x_m, y_m, size_m=(0.1, 1.0, 1.0)):
    T = np.eye(4)
    T[:3, 3] = x_m, y_m, size_m[2] / 2
    return World((Body("thing", Box(np.array(size_m)), T),), floor_m=None)


def test_an_empty_world_stops_nobody():
    motion = Pose2(3.0, -2.0, 1.0)
    assert until_touching(ROBOT, World(), Configuration(JOINTS), motion) == motion


@settings(max_examples=12)
@given(st.floats(0.6, 2.5), st.floats(-np.pi, np.pi))
def test_a_wall_ahead_ends_the_drive_just_before_it(ahead_m, heading):
    start, world = Configuration(JOINTS, Pose2(0.0, 0.0, heading)), standing(ahead_m, 0.0, (0.1, 5.0, 1.0))
    along = Pose2(*(Pose2(0.0, 0.0, -heading).apply(np.array([3.0, 0.0]))).tolist(), 0.0)
    checker = FclCollisions(CollisionModel(ROBOT, world))
    assert not checker.collides(start)
    moved = until_touching(ROBOT, world, start, along)
    assert not checker.collides(Configuration(JOINTS, start.base @ moved))
    share = (np.hypot(moved.x_m, moved.y_m) + 1.5 * LOOK_M) / np.hypot(along.x_m, along.y_m)
    further = Pose2(share * along.x_m, share * along.y_m, 0.0)
    assert checker.collides(Configuration(JOINTS, start.base @ further))


def test_a_thing_beside_the_way_is_passed():
    motion = Pose2(2.0, 0.0, 0.0)
    assert until_touching(ROBOT, standing(1.0, 1.5), Configuration(JOINTS), motion) == motion


def test_what_is_touched_at_the_start_can_be_left_but_not_entered():
    behind, start = standing(-0.33, 0.0, (0.1, 1.0, 0.3)), Configuration(JOINTS)
    checker = FclCollisions(CollisionModel(ROBOT, behind))
    assert checker.collides(start)
    assert until_touching(ROBOT, behind, start, Pose2(1.0, 0.0, 0.0)) == Pose2(1.0, 0.0, 0.0)
    assert until_touching(ROBOT, behind, start, Pose2(-1.0, 0.0, 0.0)).x_m > -0.02


def a_robot(others, solid=None):
    first = LEGS[0]
    room = PlaneRoom(T_room_base=Pose2(), T_room_part=Pose2(2.0, 0.0, np.pi / 2))
    room = room.with_others([(leg, leg.layout(4)) for leg in others], np.random.default_rng(0), ((1.0, 0), (1.0, 0)))
    return SimulatedRobot(
        ROBOT, first, first.layout(4), room, np.random.default_rng(0), JOINTS, NoisyDistances(0.0), NO_SLIP, solid=solid
    )


def test_another_part_on_the_floor_stops_the_base_and_the_robot_knows_how_far_it_got():
    robot = a_robot(LEGS[1:2])
    moved = robot.move_base(Pose2(2.5, 0.0, 0.0))
    assert 0.2 < moved.x_m < 1.0
    assert robot.configuration.base == moved == robot.true_pose_in_room()


def test_the_part_that_is_sought_stops_the_base_only_in_a_solid_world():
    assert a_robot(()).move_base(Pose2(2.5, 0.0, 0.0)) == Pose2(2.5, 0.0, 0.0)
    assert 1.2 < a_robot((), World()).move_base(Pose2(2.5, 0.0, 0.0)).x_m < 2.0


@pytest.mark.parametrize("motion", [Pose2(), Pose2(0.0, 0.0, 0.3)])
def test_standing_and_turning_are_drives_too(motion):
    assert until_touching(ROBOT, standing(5.0, 5.0), Configuration(JOINTS), motion) == motion
