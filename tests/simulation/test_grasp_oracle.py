"""The oracle: what a try of a grasp does to the true part, and what the robot is told of it."""

import numpy as np
import pytest
from grasp_poses import over

from rfcompass.errors import InputError
from rfcompass.geometry import Pose2
from rfcompass.interfaces import GraspOracle
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot, hand_of
from rfcompass.simulation import PartOracle, PlaneRoom, Push, SimulatedRobot
from rfcompass.types.grasp_noise import GraspNoise

ROBOT = YouBot()
HAND = hand_of(ROBOT)
LEG = PartDatabase(":memory:").part("table_leg_3")
EXACT = GraspNoise(position_m=0.0, turn_rad=0.0, friction_sd=0.0)


def oracle(pose=Pose2(), seed=0, **kwargs):  # noqa: B008 - a pose is frozen
    return PartOracle(HAND, LEG, pose, np.random.default_rng(seed), **{"noise": EXACT, **kwargs})


def sent(x=0.0, y=0.0, z=0.010, yaw=0.0):
    """Tool over a leg at the world's origin; its tips at a height z."""
    return over(x, y, z, yaw)


def test_it_is_a_grasp_oracle():
    assert isinstance(oracle(), GraspOracle)


def test_a_part_between_the_jaws_is_held_and_stays():
    judge = oracle()
    assert judge.judge(sent(), 0.075).success
    assert judge.held
    assert judge.T_world_part == Pose2()
    assert [row.verdict for row in judge.tries] == ["holds"]


@pytest.mark.parametrize(("y", "direction"), [(-0.02, -1), (0.02, 1)])
def test_a_jaw_that_comes_down_on_the_part_pushes_it_away_from_itself(y, direction):
    """The hand stands too far to one side: the jaw on the other side meets the part, which moves under the hand."""
    for seed in range(10):
        judge = oracle(seed=seed)
        outcome = judge.judge(sent(y=y), 0.075)
        assert outcome.failure.kind == "hand_hits_part"
        assert 0 <= direction * judge.T_world_part.y_m <= judge.push.slide_m
        assert judge.T_world_part.x_m == pytest.approx(0.0, abs=1e-12)
        assert abs(judge.T_world_part.theta_rad) <= judge.push.turn_rad


def test_a_part_that_slips_out_moves_along_itself():
    judge = PartOracle(HAND.with_opening(0.12), LEG, Pose2(), np.random.default_rng(1), EXACT)
    outcome = judge.judge(sent(yaw=0.6), 0.12)
    assert outcome.failure.kind == "nothing_held"
    assert judge.tries[0].verdict == "outside_friction_cone"
    along = np.array([np.cos(0.6), np.sin(0.6)])
    assert abs(judge.T_world_part.translation_m @ along) > 1e-4
    assert abs(judge.T_world_part.translation_m @ [-along[1], along[0]]) < 1e-9


def test_closing_on_nothing_moves_nothing():
    judge = oracle()
    assert judge.judge(sent(x=0.3), 0.075).failure.kind == "nothing_held"
    assert judge.T_world_part == Pose2()


def test_what_the_robot_is_told_holds_no_number():
    told = [oracle(seed=seed).judge(sent(y=0.03 * np.sin(seed), yaw=0.2 * seed), 0.075) for seed in range(8)]
    assert all(not outcome.failure.numbers for outcome in told if not outcome.success)
    assert {outcome.failure.kind for outcome in told if not outcome.success} <= {"hand_hits_part", "nothing_held"}
    assert all(not any(c.isdigit() for c in outcome.failure.message) for outcome in told if not outcome.success)


def test_the_same_try_anywhere_in_the_world_ends_the_same():
    world = Pose2(1.3, -0.4, 2.0)
    lifted = np.eye(4)
    lifted[:2, :2], lifted[:2, 3] = world.rotation, world.translation_m
    for y, yaw in ((0.0, 0.1), (0.02, 0.0), (0.0, 0.6)):
        here, there = oracle(seed=3), oracle(world, seed=3)
        assert here.judge(sent(y=y, yaw=yaw), 0.075) == there.judge(lifted @ sent(y=y, yaw=yaw), 0.075)
        moved = world.inverse() @ there.T_world_part
        np.testing.assert_allclose(moved.translation_m, here.T_world_part.translation_m, atol=1e-9)


def test_friction_is_drawn_for_each_try():
    judge = oracle(noise=GraspNoise())
    for _ in range(20):
        judge.T_world_part = Pose2()
        judge.judge(sent(), 0.075)
    assert len({row.friction for row in judge.tries}) == 20


def test_bad_pushes_and_openings_are_refused():
    with pytest.raises(InputError, match="slide_m"):
        Push(slide_m=-1.0)
    with pytest.raises(InputError, match="opens from"):
        oracle().judge(sent(), 0.2)


def closing_robot(offset_m, seed=0, opening_m=0.025):
    """A simulated robot with its tool over a leg that lies along y; the leg is off by some way across."""
    joints = dict(ROBOT.description.postures["scan"])
    joints |= {"gripper_finger_joint_l": opening_m, "gripper_finger_joint_r": opening_m}
    low = {"arm_joint_2": 2.0961, "arm_joint_3": -1.1065, "arm_joint_4": 2.5273}  # tips about 0.025 m over the floor
    configuration = ROBOT.configuration(joints | low)
    tool = ROBOT.tool_pose(configuration)
    heading = np.arctan2(tool.rotation[1, 1], tool.rotation[0, 1])
    across = np.array([np.cos(heading), np.sin(heading)])
    x, y = tool.translation[:2] + offset_m * across
    room = PlaneRoom(
        T_room_base=Pose2(2.0, 1.0, 0.7), T_room_part=Pose2(2.0, 1.0, 0.7) @ Pose2(x, y, heading - np.pi / 2)
    )
    return SimulatedRobot(ROBOT, LEG, LEG.layout(4), room, np.random.default_rng(seed), configuration.joints)


def test_closing_the_hand_of_a_simulated_robot_holds_what_is_between_its_jaws():
    robot = closing_robot(0.0)
    lain = robot.true_pose_in_base()
    assert robot.close_hand().success
    assert robot.true_pose_in_base() == lain
    assert robot.true_tries()[0].verdict == "holds"


def test_a_failed_try_of_a_simulated_robot_moves_the_part_and_the_next_scan_hears_it_there():
    robot = closing_robot(0.022)
    lain = robot.true_pose_in_base()
    heard = robot.scan().proximity.m
    assert not robot.close_hand().success
    assert robot.true_pose_in_base() != lain
    assert not np.allclose(robot.scan().proximity.m, heard, atol=1e-9)


def test_a_hand_that_is_not_open_enough_comes_down_on_the_part():
    assert closing_robot(0.0, opening_m=0.005).close_hand().failure.kind == "hand_hits_part"
