"""Tagged URDFs carry the same tags when they are loaded again."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import RobotModelError
from rfcompass.robots import Robot, RobotDescription, YouBot, tag_urdf
from rfcompass.robots.layouts import data_folder, no_tags
from rfcompass.robots.tagging import rpy_of_axis, with_tags
from rfcompass.robots.urdf_xml import parse_urdf
from rfcompass.types.tags import TagLayout

YOUBOT = data_folder() / "youbot.urdf"


def a_layout(frames=("arm_link_3", "base_link"), dipoles=((1, 2, 3), (0, -1, 0))):
    N = len(frames)
    points_m = 0.1 * np.arange(3 * N).reshape(N, 3)
    return TagLayout("robot", tuple(f"{i:024x}" for i in range(N)), frames, points_m, np.array(dipoles), ("hand",) * N)


def tags_in(path, configuration, count):
    """Tag poses as yourdfpy reads them from the file."""
    model = yourdfpy.URDF.load(str(path), load_meshes=False)
    names = YouBot().joint_names
    model.update_cfg(dict(zip(names, configuration.joints, strict=True)))
    return [model.get_transform(f"tag_{i}", "base_footprint") for i in range(1, count + 1)]


@pytest.mark.parametrize("layout", [YouBot("l0").layout, YouBot("skew6").layout, a_layout()])
def test_loading_a_tagged_urdf_gives_the_same_tag_frames(tmp_path, layout):
    path = tag_urdf(YOUBOT, layout, tmp_path / "tagged.urdf")
    robot = Robot(replace(YouBot().description, layout=layout))
    configuration = robot.posture("scan")
    read = tags_in(path, configuration, len(layout.epcs))
    points_m = np.array([T[:3, 3] for T in read])
    assert points_m == pytest.approx(robot.tag_positions(configuration).points_m, abs=1e-9)
    for T, frame, dipole in zip(read, layout.frames, layout.dipoles, strict=True):
        assert T[:3, 2] == pytest.approx(robot.link_pose(configuration, frame).rotation @ dipole, abs=1e-9)


def test_tagging_twice_leaves_only_the_second_layout(tmp_path):
    once = tag_urdf(YOUBOT, YouBot("l0").layout, tmp_path / "once.urdf")
    twice = tag_urdf(once, a_layout(), tmp_path / "twice.urdf")
    direct = tag_urdf(YOUBOT, a_layout(), tmp_path / "direct.urdf")
    assert twice.read_text() == direct.read_text()
    assert twice.read_text().count('<child link="tag_') == 2


def test_a_layout_without_tags_takes_all_tags_off(tmp_path):
    path = tag_urdf(YOUBOT, no_tags(), tmp_path / "plain.urdf")
    assert not [name for name in Robot(RobotDescription("r", path)).kinematics.link_names if name.startswith("tag_")]


def test_the_source_may_be_overwritten(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_bytes(YOUBOT.read_bytes())
    tag_urdf(path, a_layout(), path)
    assert path.read_text().count('<child link="tag_') == 2


def test_a_layout_on_a_link_that_is_not_there_leaves_the_old_file(tmp_path):
    out = tmp_path / "tagged.urdf"
    out.write_text("precious")
    with pytest.raises(RobotModelError, match=r"no link 'elbow'.*arm_link_5"):
        tag_urdf(YOUBOT, a_layout(frames=("elbow", "base_link")), out)
    assert [file.read_text() for file in tmp_path.iterdir()] == ["precious"]


def test_a_folder_that_is_not_there_is_an_error_that_names_the_file(tmp_path):
    with pytest.raises(RobotModelError, match="cannot be written"):
        tag_urdf(YOUBOT, a_layout(), tmp_path / "nowhere" / "tagged.urdf")


def test_a_foreign_link_named_like_a_tag_is_not_taken_over():
    moving_tag = YOUBOT.read_text().replace('name="tag_1_joint" type="fixed"', 'name="tag_1_joint" type="continuous"')
    with pytest.raises(RobotModelError, match=r"'tag_1'.*no tag of ours"):
        with_tags(parse_urdf(moving_tag.encode(), "r"), a_layout())


@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 1e-3))
def test_the_turned_z_axis_is_the_dipole(direction):
    axis = np.array(direction) / np.linalg.norm(direction)
    assert pin.rpy.rpyToMatrix(*rpy_of_axis(axis))[:, 2] == pytest.approx(axis, abs=1e-9)
