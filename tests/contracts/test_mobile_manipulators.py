"""What every robot must do, so that nothing downstream can tell one in this process from one behind a socket."""

from contextlib import contextmanager

import numpy as np
import pytest
from same_records import differences

from rfcompass.errors import InputError, JointLimitError, ShapeError
from rfcompass.geometry import Pose2
from rfcompass.interfaces import AntennaCarrier, MobileManipulator, Scanner, StateReporter
from rfcompass.recordings import PartDatabase
from rfcompass.recordings.robot_link import RemoteRobot, RobotServer
from rfcompass.robots import YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.types import GraspOutcome, Observation

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
LAYOUT = LEG.layout(4)
ROOM = PlaneRoom(T_room_base=Pose2(2.5, 2.5, 0.4), T_room_part=Pose2(3.0, 2.9, 1.2))
LEGS_M = np.array([[[1.5, 0.9, 0.3], [3.5, 0.9, 0.3]], [[0.9, 1.0, 0.3], [0.9, 3.0, 0.3]]])


def simulated(seed=0, *, radio=False):
    rng = np.random.default_rng(seed)
    sensor = RadioSetup(scene="free_space").sensor(ROOM, ROBOT.layout, LAYOUT, rng) if radio else NoisyDistances(0.05)
    return SimulatedRobot(ROBOT, LEG, LAYOUT, ROOM, rng, ROBOT.posture("scan").joints, sensor)


@contextmanager
def direct(**how):
    yield simulated(**how)


@contextmanager
def over_a_socket(**how):
    with (
        RobotServer(simulated(**how), ROBOT.name, ROBOT.joint_names) as server,
        RemoteRobot(server.host, server.port, ROBOT, LEG, LAYOUT) as robot,
    ):
        yield robot


def moved(joints, by_rad):
    """The same posture with the arm elsewhere."""
    arm = [name in ROBOT.arm_joints for name in ROBOT.joint_names]
    return np.where(arm, joints + by_rad, joints)


ROBOTS = {"simulated": direct, "over a socket": over_a_socket}


@pytest.fixture(params=ROBOTS)
def robot(request):
    with ROBOTS[request.param]() as made:
        yield made


@pytest.mark.parametrize("role", [Scanner, MobileManipulator, StateReporter, AntennaCarrier])
def test_it_plays_all_roles(robot, role):
    assert isinstance(robot, role)


def test_odometry_is_the_sum_of_the_believed_motions_and_its_covariance_grows(robot):
    believed, variances = robot.state().base, [np.trace(robot.state().base_covariance)]
    for goal in (Pose2(0.3, 0.1, 0.2), Pose2(-0.1, 0.2, -3.0), Pose2(0.0, 0.0, 1.0)):
        believed = believed @ robot.move_base(goal)
        assert robot.state().base == believed
        variances.append(np.trace(robot.state().base_covariance))
    assert (np.diff(variances) > 0).all()


def test_the_arm_goes_where_it_is_told_and_the_sensors_say_so(robot):
    joints = moved(robot.state().joints, 0.02)
    assert robot.move_arm(joints) is None
    assert np.array_equal(robot.state().joints, joints)


def test_a_joint_beyond_its_limit_is_refused_with_its_name_and_nothing_moves(robot):
    before = robot.state()
    with pytest.raises(JointLimitError) as caught:
        robot.move_arm(np.full(len(ROBOT.joint_names), 100.0))
    assert caught.value.numbers["joint"] in ROBOT.joint_names
    assert differences(robot.state(), before) == []


def test_a_posture_of_another_length_is_refused(robot):
    with pytest.raises(ShapeError):
        robot.move_arm(np.zeros(2))


def test_legs_without_an_antenna_or_of_another_shape_are_bad_input(robot):
    for legs_m in (LEGS_M, np.zeros((2, 3))):
        with pytest.raises(InputError):
            robot.use_legs(legs_m)


def test_a_scan_is_an_observation_of_where_the_robot_believes_to_be(robot):
    robot.move_base(Pose2(0.1, 0.0, 0.5))
    first, second, state = robot.scan(), robot.scan(), robot.state()
    assert isinstance(first, Observation)
    assert second.stop_id > first.stop_id
    anchors = ROBOT.tag_positions(ROBOT.configuration(state.joints, state.base))
    assert differences(first.anchors, anchors) == []
    assert first.base_pose == state.base
    assert np.array_equal(first.base_covariance, state.base_covariance)
    assert set(first.part.epcs) == set(LAYOUT.epcs)


def test_a_hand_that_closes_in_the_air_holds_nothing_and_says_why(robot):
    outcome = robot.close_hand()
    assert isinstance(outcome, GraspOutcome)
    assert not outcome.success
    assert outcome.failure.kind


def a_day(robot, *, radio):
    """Everything that a robot can do, and what it says to it."""
    said = [robot.state(), robot.scan(), robot.move_base(Pose2(0.3, 0.2, 0.7)), robot.scan()]
    robot.move_arm(moved(robot.state().joints, -0.03))
    if radio:
        robot.use_legs(LEGS_M)
    return [*said, robot.scan(), robot.close_hand(), robot.state()]


@pytest.mark.parametrize("radio", [False, True])
def test_all_of_them_say_the_same_to_the_last_bit(radio):
    told = []
    for made in ROBOTS.values():
        with made(seed=5, radio=radio) as robot:
            told.append(a_day(robot, radio=radio))
    for other in told[1:]:
        assert differences(other, told[0]) == []
    if radio:
        assert told[0][1].scan.traces
