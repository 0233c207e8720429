import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError, JointLimitError
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot, WheelSlip

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
EXACT = NoisyDistances(0.0)
NO_SLIP = WheelSlip(position_m=0.0, heading_rad=0.0)


def a_robot(seed=0, slip=NO_SLIP, room=None):
    rng = np.random.default_rng(seed)
    room = room or PlaneRoom.draw(rng)
    return SimulatedRobot(ROBOT, LEG, LEG.layout(4), room, rng, ROBOT.posture("scan").joints, EXACT, slip)


@given(st.integers(0, 200))
def test_a_drawn_room_keeps_start_and_part_as_far_apart_as_the_paper(seed):
    room = PlaneRoom.draw(np.random.default_rng(seed))
    gap = np.linalg.norm(room.T_room_base.translation_m - room.T_room_part.translation_m)
    assert 2.0 <= gap <= 6.0


@given(st.integers(0, 50))
def test_without_noise_m_is_the_true_distance(seed):
    robot = a_robot(seed)
    seen = robot.scan()
    leg = robot.true_pose_in_base()
    for k, point in enumerate(seen.part.points_m):
        tag = np.append(leg.apply(point[:2]), seen.part_tag_heights_m[k])
        assert np.allclose(seen.proximity.m[k], np.linalg.norm(tag - seen.anchors.points_m, axis=1))


def test_what_happens_after_a_scan_does_not_change_it():
    robot = a_robot()
    seen = robot.scan()
    m, points = seen.proximity.m.copy(), seen.anchors.points_m.copy()
    robot.move_base(Pose2(1.0, 0.5, 2.0))
    robot.room = PlaneRoom.draw(np.random.default_rng(99))
    assert np.array_equal(seen.proximity.m, m)
    assert np.array_equal(seen.anchors.points_m, points)


def test_wheels_slip_but_the_robot_believes_that_it_arrived():
    robot = a_robot(slip=WheelSlip(position_m=0.01, heading_rad=0.02))
    before = robot.true_pose_in_room()
    believed = robot.move_base(Pose2(0.5, 0.1, 0.3))
    moved = before.inverse() @ robot.true_pose_in_room()
    assert believed == Pose2(0.5, 0.1, 0.3)
    assert 0 < np.linalg.norm(moved.translation_m - believed.translation_m) < 0.1


@given(st.floats(-9, 9), st.floats(-9, 9), st.floats(-3, 3))
def test_the_bumper_keeps_the_robot_in_its_area_and_the_robot_knows(x_m, y_m, theta_rad):
    robot = a_robot(room=PlaneRoom(T_room_base=Pose2(1.0, 2.0, 0.5), T_room_part=Pose2(3.0, 3.0, 0.0)))
    robot.area_m = ((0.0, 0.0), (6.0, 5.0))
    goal = Pose2(x_m, y_m, theta_rad)
    believed = robot.move_base(goal)
    reached_m = robot.true_pose_in_room().translation_m
    assert (reached_m >= -1e-9).all()
    assert (reached_m <= np.array([6.0, 5.0]) + 1e-9).all()
    wanted_m = (Pose2(1.0, 2.0, 0.5) @ goal).translation_m
    inside = (wanted_m >= 0).all() and (wanted_m <= [6.0, 5.0]).all()
    assert (believed == goal) == inside or np.allclose(believed.translation_m, goal.translation_m)
    assert np.allclose(robot.configuration.base.translation_m, believed.translation_m)


def test_the_believed_covariance_is_that_of_the_slip():
    slip = WheelSlip(position_m=0.01, heading_rad=0.02)
    moves = [Pose2(0.5, 0.1, 0.3), Pose2(0.4, -0.2, -0.5), Pose2(0.3, 0.0, 0.2)]
    room = PlaneRoom(T_room_base=Pose2(), T_room_part=Pose2(2.0, 0.0, 0.0))
    ends = []
    for seed in range(1500):
        robot = a_robot(seed, slip, room)
        for move in moves:
            robot.move_base(move)
        ends.append([robot.true_pose_in_room().x_m, robot.true_pose_in_room().y_m, robot.true_pose_in_room().theta_rad])
    predicted = robot.scan().base_covariance
    assert np.allclose(np.cov(np.array(ends).T), predicted, rtol=0.2, atol=2e-5)


def test_the_arm_keeps_its_limits():
    robot = a_robot()
    with pytest.raises(JointLimitError):
        robot.move_arm(np.full_like(robot.joints, 100.0))


@pytest.mark.parametrize("bad", [{"position_m": np.nan}, {"heading_rad": np.inf}, {"position_m": -1.0}])
def test_slip_that_cannot_be_is_refused(bad):
    with pytest.raises(InputError):
        WheelSlip(**bad)


@pytest.mark.parametrize("sigma", [-1.0, np.nan, np.inf])
def test_noise_that_cannot_be_is_refused(sigma):
    with pytest.raises(InputError):
        NoisyDistances(sigma)


def test_an_area_too_small_for_the_distance_is_refused():
    with pytest.raises(InputError) as caught:
        PlaneRoom.draw(np.random.default_rng(0), (3.0, 6.0), ((0.0, 0.0), (1.0, 1.0)))
    assert caught.value.numbers["distance_m"] == 3.0


def test_the_true_way_begins_at_the_start_and_has_a_pose_for_each_drive():
    robot = YouBot()
    leg = PartDatabase(":memory:").part("table_leg_3")
    room = PlaneRoom(T_room_base=Pose2(1.0, 2.0, 0.3), T_room_part=Pose2(3.0, 2.0, 0.0))
    device = SimulatedRobot(robot, leg, leg.layout(2), room, np.random.default_rng(0), robot.posture("scan").joints)
    for _ in range(3):
        device.move_base(Pose2(0.2, 0.0, 0.1))
    way = device.true_way_in_room()
    assert len(way) == 4
    assert (way[0], way[-1]) == (room.T_room_base, device.true_pose_in_room())
    assert device.true_part_in_room() == room.T_room_part
