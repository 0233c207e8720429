"""Configurations, limits, postures and shapes of any robot."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import JointLimitError, RobotModelError, ShapeError
from rfcompass.geometry import Pose2
from rfcompass.robots import Robot, RobotDescription, Tool, YouBot
from rfcompass.robots.layouts import data_folder
from rfcompass.types.configuration import Configuration

ROBOT = YouBot()
BARE = RobotDescription("bare", data_folder() / "youbot.urdf")


def test_a_configuration_by_name_equals_the_same_by_order():
    by_name = ROBOT.configuration({"arm_joint_2": 1.0, "gripper_finger_joint_r": 0.02})
    by_order = ROBOT.configuration([0.01007, 1.0, -0.01571, 0.02212, 0.11062, 0, 0.02])
    assert by_name.joints == pytest.approx(by_order.joints)


def test_joints_at_rest_are_inside_all_limits():
    ROBOT.check_limits(ROBOT.configuration(), soft=True)


def test_an_unknown_joint_or_posture_lists_the_known_ones():
    with pytest.raises(RobotModelError, match=r"no joint 'elbow'.*arm_joint_5"):
        ROBOT.configuration({"elbow": 1.0})
    with pytest.raises(RobotModelError, match=r"no posture 'dance'.*candle, folded, scan"):
        ROBOT.posture("dance")


@pytest.mark.parametrize("joints", [[], np.zeros(6), np.zeros((7, 1)), np.full(7, np.nan), "abc"])
def test_joint_values_of_another_shape_or_not_finite_are_refused(joints):
    with pytest.raises(ShapeError):
        ROBOT.configuration(joints)


def test_a_configuration_of_another_robot_is_refused_everywhere():
    alien = Configuration(np.zeros(6))
    for use in (ROBOT.tag_positions, ROBOT.tag_jacobians, ROBOT.tool_pose, ROBOT.visual_shapes, ROBOT.check_limits):
        with pytest.raises(ShapeError):
            use(alien)
    with pytest.raises(ShapeError):
        ROBOT.tag_positions_batch(np.zeros((4, 6)))


@given(joint=st.integers(0, 6), excess=st.floats(1e-6, 10), above=st.booleans())
def test_a_joint_outside_is_named_with_its_value_and_limits(joint, excess, above):
    values = (ROBOT.limits.lower + ROBOT.limits.upper) / 2
    values[joint] = ROBOT.limits.upper[joint] + excess if above else ROBOT.limits.lower[joint] - excess
    with pytest.raises(JointLimitError, match=ROBOT.joint_names[joint]) as caught:
        ROBOT.check_limits(ROBOT.configuration(values))
    assert caught.value.numbers == {
        "joint": ROBOT.joint_names[joint],
        "value": values[joint],
        "lower": ROBOT.limits.lower[joint],
        "upper": ROBOT.limits.upper[joint],
    }


def test_soft_limits_are_narrower_than_the_mechanical_ones():
    at_the_stop = ROBOT.configuration(ROBOT.limits.upper)
    ROBOT.check_limits(at_the_stop)
    with pytest.raises(JointLimitError, match="arm_joint_1"):
        ROBOT.check_limits(at_the_stop, soft=True)


def test_tag_positions_do_not_depend_on_where_the_base_is():
    here, there = ROBOT.posture("scan"), ROBOT.posture("scan", Pose2(3, -2, 1))
    assert (ROBOT.tag_positions(here).points_m == ROBOT.tag_positions(there).points_m).all()
    assert ROBOT.tag_positions(here).frame == "base"
    assert ROBOT.tag_positions(here).epcs == ROBOT.layout.epcs


@given(x=st.floats(-5, 5), y=st.floats(-5, 5), theta=st.floats(-3, 3))
def test_shapes_move_with_the_base(x, y, theta):
    base = Pose2(x, y, theta)
    for here, there in zip(
        ROBOT.visual_shapes(ROBOT.posture("scan")), ROBOT.visual_shapes(ROBOT.posture("scan", base)), strict=True
    ):
        assert there.T_world_shape[:3, 3] == pytest.approx(base.apply(here.T_world_shape[:3, 3]), abs=1e-9)
        assert (there.kind, there.link) == (here.kind, here.link)


def test_tags_are_drawn_where_they_are_standing_along_their_dipoles():
    robot = YouBot("skew6")
    configuration = robot.posture("scan")
    drawn = [shape for shape in robot.visual_shapes(configuration) if shape.link.startswith("tag_")]
    assert [shape.link for shape in drawn] == [f"tag_{i}" for i in range(1, 7)]
    points_m = np.array([shape.T_world_shape[:3, 3] for shape in drawn])
    assert points_m == pytest.approx(robot.tag_positions(configuration).points_m)
    for shape, frame, dipole in zip(drawn, robot.layout.frames, robot.layout.dipoles, strict=True):
        along = robot.link_pose(configuration, frame).rotation @ dipole
        assert shape.T_world_shape[:3, np.argmax(shape.dimensions_m)] == pytest.approx(along)


def test_a_robot_survives_the_trip_between_processes():
    copy = pickle.loads(pickle.dumps(ROBOT))
    configuration = pickle.loads(pickle.dumps(ROBOT.posture("scan", Pose2(1, 2, 3))))
    assert configuration.base == Pose2(1, 2, 3)
    assert (copy.tag_positions(configuration).points_m == ROBOT.tag_positions(configuration).points_m).all()


def test_threads_may_share_a_robot():
    rng = np.random.default_rng(0)
    many = [ROBOT.configuration(q) for q in rng.uniform(ROBOT.limits.lower, ROBOT.limits.upper, (400, 7))]
    expected = ROBOT.tag_positions_batch(np.array([configuration.joints for configuration in many]))
    with ThreadPoolExecutor(4) as pool:
        found = np.array([tags.points_m for tags in pool.map(ROBOT.tag_positions, many)])
    assert found == pytest.approx(expected, abs=1e-12)


def test_a_bare_urdf_is_a_robot_without_tags_and_tool():
    robot = Robot(BARE)
    configuration = robot.configuration()
    assert robot.tag_positions(configuration).points_m.shape == (0, 3)
    assert robot.tag_jacobians(configuration).shape == (0, 3, 7)
    assert robot.tag_positions_batch(np.zeros((5, 7))).shape == (5, 0, 3)
    assert not robot.is_mobile
    with pytest.raises(RobotModelError, match="names no tool"):
        robot.tool_pose(configuration)


def test_the_base_frame_may_be_any_link_that_is_rigid_to_the_root():
    lifted = Robot(replace(ROBOT.description, base_frame="arm_link_0"))
    configuration = ROBOT.posture("scan")
    offset_m = np.array([0.143, 0, 0.084 + 0.046])
    expected = ROBOT.tag_positions(configuration).points_m - offset_m
    assert lifted.tag_positions(configuration).points_m == pytest.approx(expected)
    assert lifted.tag_positions_batch([configuration.joints])[0] == pytest.approx(expected)
    assert lifted.tag_jacobians(configuration) == pytest.approx(ROBOT.tag_jacobians(configuration))


def test_a_base_frame_that_moves_or_is_missing_is_refused():
    with pytest.raises(RobotModelError, match=r"moves with joint 'arm_joint_3'"):
        Robot(replace(BARE, base_frame="arm_link_3"))
    with pytest.raises(RobotModelError, match=r"no link 'odom'.*base_footprint"):
        Robot(replace(BARE, base_frame="odom"))


def test_a_description_that_does_not_fit_its_urdf_is_refused():
    axes = np.eye(3)
    with pytest.raises(RobotModelError, match="no link 'tcp'"):
        Robot(replace(BARE, tool=Tool("tcp", axes[0], axes[1])))
    with pytest.raises(RobotModelError, match="no joint 'elbow'"):
        Robot(replace(BARE, postures={"bent": {"elbow": 1.0}}))
    with pytest.raises(JointLimitError, match="arm_joint_1"):
        Robot(replace(BARE, postures={"bent": {"arm_joint_1": -1.0}}))


def test_tool_axes_must_be_perpendicular_unit_vectors():
    for approach, closing in [((0, 0, 1), (0, 0, 1)), ((0, 0, 2), (0, 1, 0)), ((0, 0, 0), (0, 1, 0))]:
        with pytest.raises(RobotModelError, match="no perpendicular unit vectors"):
            Tool("tcp", np.array(approach), np.array(closing))
