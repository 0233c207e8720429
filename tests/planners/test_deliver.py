"""Delivering: the part is carried clear of the floor, put down where it was to go, and the hand comes away empty."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.carry import plan_carry
from planners.deliver import DeliverRules, Delivery, base_goal
from planners.grasp import GraspPlanner
from rfcompass.errors import DeliveryFailed
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot, WheelSlip
from rfcompass.types import PartEstimate

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
LAY = Pose2(0.42, 0.01, 1.5)
START = ROBOT.posture("scan")
angles, places = st.floats(-np.pi, np.pi), st.floats(-3, 3)


@pytest.fixture(scope="module")
def plan():
    known = PartEstimate(LEG.part_id, LAY.translation_m, LAY.theta_rad, "told", 1, LEG.resting_height_m)
    return GraspPlanner(ROBOT).plan(LEG, known, start=START)


class Driven(SimulatedRobot):
    """Remembers its drives."""

    moves = ()

    def move_base(self, T_base_goal):
        self.moves = (*self.moves, T_base_goal)
        return super().move_base(T_base_goal)


def a_device(slip=None):
    """A robot with the part under its hand."""
    room = PlaneRoom(T_room_base=Pose2(), T_room_part=LAY)
    still = slip or WheelSlip(position_m=0.0, heading_rad=0.0)
    rng = np.random.default_rng(0)
    return Driven(ROBOT, LEG, LEG.layout(4), room, rng, START.joints, NoisyDistances(0.0), still)


def delivered(plan, device, goal, **rules):
    """Grasp by the plan, then deliver."""
    for joints in np.concatenate([stage.joints for stage in plan.stages if stage.stage in ("reach", "approach")]):
        device.move_arm(joints)
    assert device.close_hand().success
    for joints in plan.retreat:
        device.move_arm(joints)
    return Delivery(ROBOT, device, DeliverRules(**rules)).put_down(LEG, plan, Pose2(), goal)


def test_the_carry_goes_straight_up_from_where_the_grasp_ended(plan):
    carry = plan_carry(ROBOT, LEG, plan)
    assert np.array_equal(carry.joints[0], plan.retreat[-1])
    ends_m = [ROBOT.tool_pose(ROBOT.configuration(q)).translation for q in (carry.joints[0], carry.joints[-1])]
    assert np.allclose((ends_m[1] - ends_m[0])[:2], 0.0, atol=1e-3)
    assert ends_m[1][2] - ends_m[0][2] >= 0.05 - 1e-3


def test_hand_and_part_are_carried_clear_of_the_floor(plan):
    carry, as_it_ended = plan_carry(ROBOT, LEG, plan), plan_carry(ROBOT, LEG, plan, ())
    assert carry.floor_m > as_it_ended.floor_m >= 0.05 - 1e-3  # the lift of the grasp itself
    assert len(as_it_ended.joints) == 1


@given(angles, places, places, angles)
def test_the_base_stands_where_the_part_comes_down_at_the_goal_up_to_half_a_turn(held_rad, x_m, y_m, theta_rad):
    held, goal = Pose2(0.42, 0.03, held_rad), Pose2(x_m, y_m, theta_rad)
    base = base_goal(held, goal)
    end = base @ held
    assert np.allclose(end.translation_m, goal.translation_m, atol=1e-9)
    assert abs(np.sin(end.theta_rad - goal.theta_rad)) < 1e-9
    other = goal @ Pose2(0.0, 0.0, np.pi) @ goal.inverse() @ base  # from the other side
    assert (goal.inverse() @ base).y_m <= (goal.inverse() @ other).y_m + 1e-9


@pytest.mark.parametrize("goal", [Pose2(1.5, -0.8, 2.0), Pose2(-4.0, 3.0, -1.0), Pose2(0.42, 0.0, 1.5)])
def test_without_slip_the_part_ends_where_it_was_to_go(plan, goal):
    device = a_device()
    put = delivered(plan, device, goal)
    end = device.room.T_room_part
    assert put.short_m < 1e-9
    assert np.linalg.norm(end.translation_m - goal.translation_m) < 1e-3
    assert abs(np.sin(end.theta_rad - goal.theta_rad)) < 5e-3
    assert abs(device.true_drop_m()) < 1e-3


def test_with_slip_the_part_ends_as_far_off_as_the_wheels_slipped(plan):
    device, goal = a_device(WheelSlip(position_m=0.01, heading_rad=0.02)), Pose2(3.0, 1.0, 0.3)
    put = delivered(plan, device, goal)
    slipped = put.T_odom_base.inverse() @ device.true_pose_in_room()
    assert put.short_m < 1e-9  # the robot believes its wheels
    assert np.linalg.norm(slipped.translation_m) > 1e-3
    expected = put.T_odom_base @ slipped @ put.T_odom_base.inverse() @ put.T_odom_part
    assert np.allclose(device.room.T_room_part.translation_m, expected.translation_m, atol=1e-3)


def test_no_drive_is_longer_than_the_rules_allow(plan):
    device = a_device()
    put = delivered(plan, device, Pose2(4.0, -2.0, 0.0), step_m=1.0)
    assert put.drives == len(device.moves) >= 4
    assert max(np.hypot(move.x_m, move.y_m) for move in device.moves) <= 1.0 + 1e-9


def test_afterwards_the_arm_is_back_where_the_grasp_began(plan):
    device = a_device()
    delivered(plan, device, Pose2(1.0, 0.0, 0.0))
    assert np.array_equal(device.joints, START.joints)


def test_a_part_that_is_put_down_at_the_bumper_is_not_delivered(plan):
    device = a_device()
    device.area_m = ((-1.0, -1.0), (1.0, 1.0))
    put = delivered(plan, device, Pose2(3.0, 0.0, np.pi / 2))
    assert put.short_m > 1.0
    with pytest.raises(DeliveryFailed) as failure:
        Delivery(ROBOT, device).check_reached(put)
    assert failure.value.numbers["short_m"] == put.short_m
    assert np.allclose(device.room.T_room_part.translation_m, put.T_odom_part.translation_m, atol=1e-3)
