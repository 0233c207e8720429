"""Symbolic forward kinematics equal pinocchio's."""

import casadi as ca
import numpy as np
import pytest

from planners.symbolic_fk import SymbolicKinematics, planar
from rfcompass.errors import RobotModelError
from rfcompass.geometry import Pose2
from rfcompass.robots import described_robots, load_robot
from rfcompass.robots.collision_model import homogeneous


@pytest.mark.parametrize("name", described_robots())
def test_every_link_is_where_pinocchio_puts_it(name):
    robot = load_robot(name)
    q = ca.SX.sym("q", len(robot.joint_names))
    kinematics = SymbolicKinematics(robot, q)
    links = [robot.tool.frame, *robot.kinematics.link_names[::7]]
    pose_of = ca.Function("poses", [q], [entry for link in links for entry in kinematics.pose(link)])
    for values in np.random.default_rng(0).uniform(-2, 2, (30, len(robot.joint_names))):
        answers = [np.array(entry) for entry in pose_of(values)]
        for i, link in enumerate(links):
            T = robot.link_pose(robot.configuration(values), link)
            assert np.abs(answers[2 * i] - T.rotation).max() < 1e-12
            assert np.abs(answers[2 * i + 1].ravel() - T.translation).max() < 1e-12


def test_a_base_that_drives_carries_everything():
    robot = load_robot("youbot")
    q, base = ca.SX.sym("q", 7), ca.SX.sym("base", 3)
    pose = SymbolicKinematics(robot, q, planar(base[0], base[1], base[2])).pose("gripper_tool_link")
    place = ca.Function("place", [q, base], [pose.p])
    joints = robot.posture("scan").joints
    expected = homogeneous(Pose2(1.0, -2.0, 0.7)) @ robot.tool_pose(robot.posture("scan")).homogeneous
    assert np.array(place(joints, [1.0, -2.0, 0.7])).ravel() == pytest.approx(expected[:3, 3], abs=1e-12)


def test_an_unknown_link_is_refused():
    robot = load_robot("youbot")
    with pytest.raises(RobotModelError, match="elbow"):
        SymbolicKinematics(robot, ca.SX.sym("q", 7)).pose("elbow")
