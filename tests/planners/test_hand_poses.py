"""Quick reasons against a grasp are right: whoever is rejected cannot be done, whoever is not can be solved."""

import numpy as np
import pytest
from collision_scenes import ROBOT, at
from hypothesis import given
from hypothesis import strategies as st

from planners.antipodal import AntipodalRules, antipodal_grasps
from planners.hand_joints import hand_joints
from planners.hand_poses import floor_failures, into_arm_plane, reach_failures, turning_for
from planners.ik import IkRules, InverseKinematics
from planners.planar_arm import read_planar_arm
from rfcompass.robots import CollisionModel, QuickCollisions
from rfcompass.robots.hand import hand_of
from rfcompass.types import Box, Configuration, Cylinder, GraspTask, Solution, World

HAND, JOINTS, ARM = hand_of(ROBOT), hand_joints(ROBOT), read_planar_arm(ROBOT, soft=True)
SCAN, TOOL = ROBOT.posture("scan"), ROBOT.tool
LEG, POST = Box(np.array([0.4, 0.05, 0.05])), Cylinder(0.02, 0.25, "z")


def turned(theta):
    return np.array([[np.cos(theta), -np.sin(theta), 0], [np.sin(theta), np.cos(theta), 0], [0, 0, 1.0]])


def listed(shape):
    return antipodal_grasps(
        shape, TOOL, opening_m=HAND.greatest_m, friction=HAND.friction, rng=np.random.default_rng(0)
    )


LISTED = {"leg": (LEG, listed(LEG)), "post": (POST, listed(POST))}


def in_plane(name, T):
    shape, rows = LISTED[name]
    return into_arm_plane(rows, ROBOT, T, turning_for(ARM, shape, AntipodalRules().depth_m, HAND.friction))


def height(shape):
    return -float(shape.lower_m[2])


@given(
    name=st.sampled_from(sorted(LISTED)), x=st.floats(0.3, 0.6), y=st.floats(-0.3, 0.3), theta=st.floats(-np.pi, np.pi)
)
def test_slanted_grasps_end_in_the_arm_plane_or_are_rejected(name, x, y, theta):
    T = at(x, y, height(LISTED[name][0]), turned(theta))
    rows = in_plane(name, T)
    assert {row.rejection.kind for row in rows if row.rejection} <= {"unreachable", "too_wide"}
    for row in rows:
        if row.rejection is None:
            T_hand = T @ row.T_part_hand
            out = T_hand[:2, 3] - ARM.axis_m
            approach = T_hand[:3, :3] @ TOOL.approach_axis
            assert out[0] * approach[1] - out[1] * approach[0] == pytest.approx(0, abs=1e-9)


@given(theta=st.floats(-np.pi, np.pi))
def test_a_round_part_is_grasped_at_a_slant_whatever_its_heading(theta):
    rows = in_plane("post", at(0.45, 0.1, height(POST), turned(theta)))
    assert {row.rejection.kind for row in rows if row.rejection} == {"too_wide"}  # along its axis


@pytest.mark.parametrize(("off", "slants"), [(0.0, True), (0.2, True), (np.pi / 2, False)])
def test_a_leg_is_grasped_at_a_slant_only_where_it_points_at_the_arm(off, slants):
    heading = np.arctan2(0.1, 0.45 - ARM.axis_m[0])
    rows = in_plane("leg", at(0.45, 0.1, height(LEG), turned(heading + off)))
    slanted = [row for row in rows if row.rejection is None and closes_across(row) and not is_vertical(row)]
    assert bool(slanted) == slants


def is_vertical(row):
    return (row.T_part_hand[:3, :3] @ TOOL.approach_axis)[2] < -1 + 1e-9


def closes_across(row):
    return abs((row.T_part_hand[:3, :3] @ TOOL.closing_axis)[1]) > 0.7


def test_turning_moves_no_contact():
    T = at(0.45, 0.05, height(LEG), turned(0.2))
    depth_m = AntipodalRules().depth_m
    before = {tuple(np.round(middle(row, depth_m), 6)) for row in LISTED["leg"][1]}
    after = {tuple(np.round(middle(row, depth_m), 6)) for row in in_plane("leg", T)}
    assert after <= before


def middle(row, depth_m):
    return row.T_part_hand[:3, 3] - depth_m * row.T_part_hand[:3, :3] @ TOOL.approach_axis + 0.0


def poses(name, T):
    return np.array([T @ row.T_part_hand for row in in_plane(name, T) if row.rejection is None])


@pytest.mark.parametrize("theta", [0.0, 0.7, 1.5])
def test_what_the_closed_form_reaches_is_solved_and_what_it_does_not_reach_is_not(theta):
    T = at(0.44, 0.05, height(LEG), turned(theta))
    ik = InverseKinematics(ROBOT, World(floor_m=None), IkRules(certify=False, explain=False))
    hands = poses("leg", T)
    for T_hand, failure in zip(hands, reach_failures(ARM, ROBOT, hands, SCAN), strict=True):
        answer = ik.solve(GraspTask.of_pose(T_hand, TOOL.approach_axis, TOOL.closing_axis), SCAN)
        if failure is None:
            assert isinstance(answer, Solution) or answer.kind == "self_collision"
        else:
            assert answer.kind == failure.kind


def test_hands_in_the_floor_are_those_that_the_collision_check_finds_there():
    quick = QuickCollisions(CollisionModel(ROBOT))
    ik = InverseKinematics(ROBOT, World(floor_m=None), IkRules(certify=False, explain=False))
    hands = poses("leg", at(0.44, 0.0, height(LEG), turned(0.1)))
    opened = JOINTS.at_opening(SCAN, HAND, HAND.greatest_m)
    checked = 0
    for T_hand, failure in zip(hands, floor_failures(HAND, hands, HAND.greatest_m, 0.0), strict=True):
        answer = ik.solve(GraspTask.of_pose(T_hand, TOOL.approach_axis, TOOL.closing_axis), opened)
        if isinstance(answer, Solution):
            rows = quick.touching(answer.configuration)
            in_floor = any("floor" in (row.first, row.second) and "gripper" in row.first + row.second for row in rows)
            assert in_floor == (failure is not None)
            checked += 1
    assert checked > 20
    assert floor_failures(HAND, hands, HAND.greatest_m, None) == [None] * len(hands)


@given(opening_m=st.floats(0.025, 0.075))
def test_fingers_stand_as_far_apart_as_asked(opening_m):
    q = JOINTS.at_opening(SCAN, HAND, opening_m)
    places = [ROBOT.link_pose(q, link).translation for link in JOINTS.fingers]
    # The inner faces are 8 mm before the fingers' frames, see the URDF.
    assert np.linalg.norm(places[0] - places[1]) - 0.016 == pytest.approx(opening_m, abs=1e-9)
    assert q.joints[:5].tolist() == SCAN.joints[:5].tolist()


def test_fingers_stop_at_their_limits():
    wide = JOINTS.at_opening(Configuration(SCAN.joints), HAND, 0.2)
    assert wide.joints[JOINTS.columns].tolist() == JOINTS.most.tolist()
