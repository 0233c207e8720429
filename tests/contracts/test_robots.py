"""What every robot of the library obeys: two libraries agree on its kinematics, Jacobians are derivatives, limits hold.

The robots extra must be installed, so that nobody mistakes fewer robots for a pass; set RFCOMPASS_WITHOUT_ROBOTS=1
to test without it.
"""

import os
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
import yourdfpy

from rfcompass.errors import JointLimitError
from rfcompass.robots import Robot, describe_robot, described_robots, known_robots
from rfcompass.robots.packages import EXTRA, extra_folder
from rfcompass.types.tags import TagLayout

OURS = described_robots()
OTHERS = [name for name in known_robots() if name not in OURS]
EVERY = [*OURS, *(pytest.param(name, marks=pytest.mark.slow) for name in OTHERS)]


@lru_cache(maxsize=4)
def robot_named(name):
    """A robot of the library; one without tags gets one on each of twelve links."""
    robot = Robot(describe_robot(name))
    return robot if robot.layout.epcs else Robot(replace(robot.description, layout=tags_all_over(robot)))


def tags_all_over(robot):
    links = robot.kinematics.link_names
    frames = tuple(links[i] for i in sorted({*np.linspace(0, len(links) - 1, 12).astype(int)}))
    points_m = np.random.default_rng(5).uniform(-0.1, 0.1, (len(frames), 3))
    epcs = tuple(f"{i:024x}" for i in range(len(frames)))
    return TagLayout("robot", epcs, frames, points_m, np.ones_like(points_m), ("hand",) * len(frames))


@pytest.fixture(params=EVERY)
def robot(request):
    return robot_named(request.param)


def some_joints(robot, count=5):
    """Random joint values inside the limits, endless joints within two turns, (count, Q)."""
    rng = np.random.default_rng(11)
    limits = robot.limits
    return rng.uniform(
        np.maximum(limits.lower, -4 * np.pi), np.minimum(limits.upper, 4 * np.pi), (count, len(limits.names))
    )


def test_the_robots_extra_is_installed():
    if os.environ.get("RFCOMPASS_WITHOUT_ROBOTS") == "1":
        pytest.skip("RFCOMPASS_WITHOUT_ROBOTS=1: only the robots that need no extra are tested")
    assert extra_folder() is not None, f"{EXTRA} is missing: pip install 'rfcompass[robots]'"
    assert {"panda", "pr2", "tiago", "ur5e_2f85", "youbot"} == set(OURS)
    assert len(OTHERS) > 50


def test_pinocchio_and_yourdfpy_agree_on_every_link(robot):
    other = yourdfpy.URDF.load(str(robot.description.urdf), load_meshes=False)
    links = [link for link in robot.kinematics.link_names if not link.startswith("tag_")]
    for joints in some_joints(robot):
        configuration = robot.configuration(joints)
        other.update_cfg({name: joints[i] for i, name in enumerate(robot.joint_names)})
        base = robot.kinematics.base_frame
        for link in links:
            T = robot.link_pose(configuration, link).homogeneous
            assert np.abs(T - other.get_transform(link, base)).max() < 1e-9, link


def test_tags_are_where_their_links_carry_them(robot):
    for joints in some_joints(robot, 2):
        configuration = robot.configuration(joints)
        layout, tags = robot.layout, robot.tag_positions(configuration)
        for frame, point_m, found_m in zip(layout.frames, layout.points_m, tags.points_m, strict=True):
            assert found_m == pytest.approx(robot.link_pose(configuration, frame).act(point_m), abs=1e-12)


def test_many_configurations_at_once_give_the_same_as_one_by_one(robot):
    joints = some_joints(robot)
    one_by_one = [robot.tag_positions(robot.configuration(q)).points_m for q in joints]
    assert np.abs(robot.tag_positions_batch(joints) - np.array(one_by_one)).max(initial=0) < 1e-12


def test_tag_jacobians_equal_finite_differences(robot):
    step = 1e-6
    for joints in some_joints(robot, 2):
        J = robot.tag_jacobians(robot.configuration(joints))
        moved = np.concatenate([joints + step * np.eye(joints.size), joints - step * np.eye(joints.size)])
        plus, minus = np.split(robot.tag_positions_batch(moved), 2)
        assert np.abs(J - np.moveaxis((plus - minus) / (2 * step), 0, -1)).max(initial=0) < 1e-8


def test_limits_accept_what_is_inside_and_name_what_is_outside(robot):
    for joints in some_joints(robot, 2):
        robot.check_limits(robot.configuration(joints))
        for i, name in enumerate(robot.joint_names):
            if np.isfinite(robot.limits.upper[i]):
                outside = joints.copy()
                outside[i] = robot.limits.upper[i] + 0.01 + 1e-6 * abs(robot.limits.upper[i])
                with pytest.raises(JointLimitError) as caught:
                    robot.check_limits(robot.configuration(outside))
                assert caught.value.numbers["joint"] == name


def test_shapes_of_a_link_move_with_it(robot):
    shapes = [robot.visual_shapes(robot.configuration(joints)) for joints in some_joints(robot, 2)]
    for one, two in zip(*shapes, strict=True):
        T_one, T_two = (
            robot.link_pose(robot.configuration(joints), one.link).homogeneous for joints in some_joints(robot, 2)
        )
        in_link = np.linalg.solve(T_one, one.T_world_shape)
        assert np.abs(T_two @ in_link - two.T_world_shape).max() < 1e-9


@pytest.mark.parametrize("name", OURS)
def test_described_robots_have_tags_a_tool_and_an_arm_that_moves_the_hand_tags(name):
    robot = robot_named(name)
    assert {"hand_left", "hand_right", "base_front", "base_end"} <= set(robot.layout.roles)
    hand = [i for i, role in enumerate(robot.layout.roles) if role.startswith("hand")]
    base = [i for i, role in enumerate(robot.layout.roles) if role.startswith("base")]
    assert len(robot.arm_joints) >= 5
    first, second = robot.tag_positions_batch(some_joints(robot, 2))
    assert (np.linalg.norm(first[hand] - second[hand], axis=1) > 0.01).all()
    assert first[base] == pytest.approx(second[base])


@pytest.mark.parametrize("name", OURS)
def test_the_hand_tags_straddle_the_tool_along_its_closing_axis(name):
    robot = robot_named(name)
    configuration = robot.configuration()
    (left,), (right,) = robot.layout.with_role("hand_left"), robot.layout.with_role("hand_right")
    tool, points_m = robot.tool_pose(configuration), robot.tag_positions(configuration).points_m
    across = np.array([tool.actInv(points_m[i]) @ robot.tool.closing_axis for i in (left, right)])
    assert across[0] > 0 > across[1]
    assert all(tool.actInv(points_m[i]) @ robot.tool.approach_axis < 0 for i in (left, right))


def test_at_least_one_described_robot_of_the_extra_drives():
    if extra_folder() is not None:
        assert {name for name in OURS if robot_named(name).is_mobile} >= {"pr2", "tiago", "youbot"}
