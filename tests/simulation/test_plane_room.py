import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError, JointLimitError
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.simulation import PlaneRoom, RoomNoise, SimulatedRobot

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
IDEAL = RoomNoise(distance_sigma=0.0, slip_m=0.0, slip_rad=0.0)


def a_robot(seed=0, noise=IDEAL, room=None):
    rng = np.random.default_rng(seed)
    room = room or PlaneRoom.draw(rng)
    return SimulatedRobot(ROBOT, LEG, LEG.layout(4), room, rng, ROBOT.posture("scan").joints, noise)


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
    robot = a_robot(noise=RoomNoise(slip_m=0.01, slip_rad=0.02))
    before = robot.true_pose_in_room()
    believed = robot.move_base(Pose2(0.5, 0.1, 0.3))
    moved = before.inverse() @ robot.true_pose_in_room()
    assert believed == Pose2(0.5, 0.1, 0.3)
    assert 0 < np.linalg.norm(moved.translation_m - believed.translation_m) < 0.1


def test_the_believed_covariance_is_that_of_the_slip():
    noise = RoomNoise(slip_m=0.01, slip_rad=0.02)
    moves = [Pose2(0.5, 0.1, 0.3), Pose2(0.4, -0.2, -0.5), Pose2(0.3, 0.0, 0.2)]
    room = PlaneRoom(T_room_base=Pose2(), T_room_part=Pose2(2.0, 0.0, 0.0))
    ends = []
    for seed in range(1500):
        robot = a_robot(seed, noise, room)
        for move in moves:
            robot.move_base(move)
        ends.append([robot.true_pose_in_room().x_m, robot.true_pose_in_room().y_m, robot.true_pose_in_room().theta_rad])
    predicted = robot.scan().base_covariance
    assert np.allclose(np.cov(np.array(ends).T), predicted, rtol=0.2, atol=2e-5)


def test_the_arm_keeps_its_limits():
    robot = a_robot()
    with pytest.raises(JointLimitError):
        robot.move_arm(np.full_like(robot.joints, 100.0))


@pytest.mark.parametrize("bad", [{"distance_sigma": -1.0}, {"slip_m": np.nan}, {"slip_rad": np.inf}])
def test_noise_that_cannot_be_is_refused(bad):
    with pytest.raises(InputError):
        RoomNoise(**bad)
