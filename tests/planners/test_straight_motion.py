"""Straight motions of the tool: straight, without gaps, and with a reason where they end."""

import numpy as np
import pytest
from collision_scenes import ROBOT, at

from planners.ik import IkRules, InverseKinematics
from planners.straight_motion import StraightMotion, move_straight
from rfcompass.robots import CollisionModel
from rfcompass.types import Body, Box, Configuration, GraspTask, World

SCAN = ROBOT.posture("scan")
LEG = Body("leg", Box(np.array([0.05, 0.4, 0.05])), at(0.42, 0, 0.025))
TASK = GraspTask([0.42, 0.0, 0.03], [0, 0, -1.0], [1.0, 0, 0])
UP = np.array([0.0, 0.0, 0.12])


def ready(world=None, task=TASK, **rules):
    ik = InverseKinematics(ROBOT, world or World((LEG,)), IkRules(**rules))
    return ik, ik.solve(task, SCAN).configuration


def test_the_tool_leaves_the_part_on_a_straight_line_and_keeps_its_axes():
    ik, grasp = ready()
    motion = move_straight(ik, TASK, grasp, UP)
    assert isinstance(motion, StraightMotion)
    assert motion.report.free
    assert motion.deviation_m <= 5e-4
    poses = [ROBOT.tool_pose(Configuration(q)) for q in motion.path]
    heights = [T.translation[2] for T in poses]
    assert heights == pytest.approx(np.linspace(0.03, 0.15, len(poses)), abs=1e-6)
    for T in poses:
        assert T.translation[:2] == pytest.approx([0.42, 0], abs=1e-6)
        assert T.rotation[:, 2] == pytest.approx([0, 0, -1], abs=1e-6)
    assert motion.reversed_path[0].tolist() == motion.path[-1].tolist()


def test_a_tighter_tolerance_needs_more_waypoints_and_is_kept():
    ik, grasp = ready()
    coarse = move_straight(ik, TASK, grasp, UP, tolerance_m=1e-3)
    fine = move_straight(ik, TASK, grasp, UP, tolerance_m=2e-5)
    assert len(fine.path) > len(coarse.path)
    assert fine.deviation_m <= 2e-5


def test_something_in_the_way_is_named_with_the_place():
    shelf = Body("shelf", Box(np.array([0.1, 0.4, 0.01])), at(0.42, 0.0, 0.40))
    ik, grasp = ready(World((LEG, shelf)))
    answer = move_straight(ik, TASK, grasp, UP)
    assert answer.kind == "scene_collision"
    assert "shelf" in answer.message
    assert 0 < dict(answer.numbers)["at"] <= 1


def test_the_end_of_the_arm_is_named():
    ik, grasp = ready()
    answer = move_straight(ik, TASK, grasp, np.array([0.0, 0.0, 0.4]))
    assert answer.kind in ("joint_limit", "unreachable")
    assert 0 < dict(answer.numbers)["at"] <= 1


def test_the_lift_carries_the_part_along():
    """With the part in the hand it is the part that meets the shelf."""
    shelf = Body("shelf", Box(np.array([0.05, 0.05, 0.01])), at(0.42, 0.18, 0.10))
    fingers = ["gripper_finger_link_l", "gripper_finger_link_r", "gripper_palm_link", "floor"]
    ik, grasp = ready(World((LEG, shelf)))
    T_tool_leg = np.linalg.inv(ROBOT.tool_pose(grasp).homogeneous) @ LEG.T_parent_body
    held = World((LEG, shelf)).attach("leg", "gripper_tool_link", T_tool_leg, fingers)
    carrying = InverseKinematics(ROBOT, model=CollisionModel(ROBOT, held))
    assert isinstance(move_straight(ik, TASK, grasp, UP), StraightMotion)
    answer = move_straight(carrying, TASK, grasp, UP)
    assert answer.kind == "scene_collision"
    assert {"leg", "shelf"} == {dict(answer.numbers)["first"], dict(answer.numbers)["second"]}


def test_a_motion_begins_where_the_task_is_done():
    ik, _ = ready()
    with pytest.raises(ValueError, match="begin"):
        move_straight(ik, TASK, SCAN, UP)
    with pytest.raises(ValueError, match="tolerance"):
        move_straight(ik, TASK, SCAN, UP, tolerance_m=0.0)
