"""Every defect of a URDF is named, and what passes the check can be loaded."""

import copy
import pickle

import numpy as np
import pytest
import trimesh

from rfcompass.errors import InputError, RobotModelError
from rfcompass.robots import Robot, RobotDescription, check_urdf
from rfcompass.robots.layouts import data_folder
from rfcompass.robots.urdf_xml import read_urdf, urdf_text

YOUBOT = data_folder() / "youbot.urdf"
LIMIT = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'
LINKS = '<link name="a"/><link name="b"/>'


def checked(tmp_path, body, **arguments):
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="r">{body}</robot>')
    return check_urdf(path, **arguments)


def joint(inside, kind="revolute", parent="a", child="b", name="j"):
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


def link(inside):
    return f'<link name="a">{inside}</link>'


def kinds(report):
    return [defect.kind for defect in report.defects]


def test_our_robot_has_no_defect():
    report = check_urdf(YOUBOT, frames=["gripper_tool_link", "tag_9"])
    assert report.ok
    assert report.defects == ()
    assert (report.name, len(report.links), len(report.moving)) == ("youbot", 25, 7)
    report.require_ok()


@pytest.mark.parametrize(
    ("body", "kind"),
    [
        (LINKS + joint("", parent="z"), "unknown_parent"),
        (LINKS + joint(LIMIT, child="z"), "unknown_child"),
        (LINKS + joint(LIMIT, parent=""), "unknown_parent"),
        (LINKS + joint(""), "no_limit"),
        (LINKS + joint('<limit lower="0" upper="1"/>'), "no_limit"),
        (LINKS + joint('<limit lower="1" upper="-1" velocity="1" effort="1"/>'), "reversed_limits"),
        (LINKS + joint('<limit lower="1" upper="1" velocity="1" effort="1"/>'), "no_range"),
        (LINKS + joint('<limit lower="0" upper="1" velocity="-1" effort="1"/>'), "negative_limit"),
        (LINKS + joint('<limit lower="x" upper="1" velocity="1" effort="1"/>'), "not_a_number"),
        (LINKS + joint(LIMIT + '<safety_controller k_velocity="1" soft_upper_limit="2"/>'), "soft_limits"),
        (LINKS + joint(LIMIT + '<axis xyz="0 0 0"/>'), "zero_axis"),
        (LINKS + joint(LIMIT + "<axis/>"), "zero_axis"),
        (LINKS + joint(LIMIT + '<axis xyz="0 0 2"/>'), "axis_length"),
        (LINKS + joint(LIMIT + '<origin xyz="0 0 nan"/>'), "not_a_number"),
        (LINKS + joint(LIMIT, kind="floating"), "joint_type"),
        (LINKS + joint(LIMIT, kind="bendy"), "joint_type"),
        (LINKS + joint(LIMIT + '<mimic joint="z"/>'), "unknown_mimic"),
        (LINKS + joint(LIMIT + '<mimic joint="j"/>'), "mimic"),
        (LINKS + joint(LIMIT) + joint(LIMIT), "duplicate_joint"),
        (LINKS + joint(LIMIT) + joint(LIMIT, name="k"), "two_parents"),
        (LINKS + joint(LIMIT) + joint(LIMIT, parent="b", child="a", name="k"), "ring"),
        ('<link name="c"/>' + LINKS + joint(LIMIT) + joint(LIMIT, parent="b", child="a", name="k"), "ring"),
        (LINKS, "two_roots"),
        ("", "no_link"),
        ('<link name="a"/><link name="a"/>', "duplicate_link"),
        ("<link/>", "unnamed_link"),
        ('<link name="a"/><xacro:arm xmlns:xacro="x"/>', "xacro"),
        (link('<inertial><mass value="0"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'), "zero_mass"),
        (link('<inertial><mass value="1"/></inertial>'), "zero_inertia"),
        (link('<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="3"/></inertial>'), "impossible_inertia"),
        (link('<inertial><mass value="heavy"/></inertial>'), "not_a_number"),
        ('<material name="red"><color rgba="1 0 0"/></material>' + link(""), "not_a_number"),
        (link("<visual/>"), "no_geometry"),
        (link("<visual><geometry/></visual>"), "no_geometry"),
        (link('<collision><geometry><box size="1 0 1"/></geometry></collision>'), "no_size"),
        (link('<visual><geometry><box size="1 1"/></geometry></visual>'), "not_a_number"),
        (link("<visual><geometry><teapot/></geometry></visual>"), "not_a_number"),
        (link('<visual><geometry><mesh filename="missing.stl"/></geometry></visual>'), "missing_mesh"),
        (link("<visual><geometry><mesh/></geometry></visual>"), "missing_mesh"),
        (link('<visual><geometry><mesh filename="package://no/a.stl"/></geometry></visual>'), "unknown_package"),
        (
            link('<visual><geometry><box size="1 1 1"/></geometry><material name="pink"/></visual>'),
            "unknown_material",
        ),
    ],
)
def test_each_defect_has_its_name(tmp_path, body, kind):
    assert kind in kinds(checked(tmp_path, body))


def test_what_moves_and_collides_without_a_mass_is_a_warning(tmp_path):
    solid = '<link name="b"><collision><geometry><sphere radius="1"/></geometry></collision></link>'
    report = checked(tmp_path, '<link name="a"/>' + solid + joint(LIMIT))
    assert kinds(report) == ["no_inertia"]
    assert report.ok


def test_all_defects_are_named_not_only_the_first(tmp_path):
    shapes = '<visual><geometry><mesh filename="{}.stl"/></geometry></visual>'
    body = link(shapes.format("one") + shapes.format("two")) + '<link name="b"/>' + joint("", child="z")
    report = checked(tmp_path, body, frames=["tool0", "camera"])
    assert (
        kinds(report)
        == ["unknown_child", "two_roots", "no_limit", "missing_mesh", "missing_mesh"] + ["missing_frame"] * 2
    )
    with pytest.raises(RobotModelError, match=r"7 errors.*one\.stl.*two\.stl.*tool0.*camera"):
        report.require_ok()


def test_meshes_are_opened_and_collada_is_noted(tmp_path):
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "good.stl")
    (tmp_path / "broken.stl").write_bytes((tmp_path / "good.stl").read_bytes()[:200])
    (tmp_path / "scene.dae").touch()
    meshes = "".join(
        f'<visual><geometry><mesh filename="{file}"/></geometry></visual>'
        for file in ("good.stl", "broken.stl", "scene.dae")
    )
    report = checked(tmp_path, link(meshes))
    assert [(defect.kind, defect.severity) for defect in report.defects] == [
        ("broken_mesh", "error"),
        ("dae_mesh", "warning"),
    ]


def test_packages_are_searched_where_the_user_says(tmp_path):
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "part.stl")
    (tmp_path / "elsewhere/shapes").mkdir(parents=True)
    (tmp_path / "part.stl").rename(tmp_path / "elsewhere/shapes/part.stl")
    body = link('<visual><geometry><mesh filename="package://shapes/part.stl"/></geometry></visual>')
    assert kinds(checked(tmp_path, body)) == ["unknown_package"]
    assert kinds(checked(tmp_path, body, package_dirs=[tmp_path / "elsewhere"])) == []


def test_an_external_entity_is_a_defect_and_nothing_else_is_looked_at(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text('<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/hostname">]><robot name="r">&x;</robot>')
    report = check_urdf(path)
    assert kinds(report) == ["document_type"]
    assert not report.ok


def test_a_file_that_cannot_be_read_is_a_defect(tmp_path):
    assert kinds(check_urdf(tmp_path / "missing.urdf")) == ["unreadable"]
    (tmp_path / "noise.urdf").write_text("<robot")
    assert kinds(check_urdf(tmp_path / "noise.urdf")) == ["unreadable"]


def test_a_report_survives_the_trip_between_processes():
    report = check_urdf(YOUBOT)
    assert pickle.loads(pickle.dumps(report)) == report


def damaged(rng):
    """The youBot with one to three random elements or attributes removed, doubled or overwritten."""
    root = copy.deepcopy(read_urdf(YOUBOT))
    for _ in range(rng.integers(1, 4)):
        parents = [element for element in root.iter() if isinstance(element.tag, str) and len(element)]
        parent = parents[rng.integers(len(parents))]
        child = parent[rng.integers(len(parent))]
        action = rng.integers(4)
        if action == 0:
            parent.remove(child)
        elif action == 1:
            parent.append(copy.deepcopy(child))
        elif child.attrib:
            name = list(child.attrib)[rng.integers(len(child.attrib))]
            child.attrib.pop(name)
            if action == 2:
                child.set(name, str(rng.choice(["", "x", "0", "-1", "1 2", "nan", "arm_link_2", "1e999"])))
    return urdf_text(root)


def test_a_damaged_robot_never_ends_in_a_foreign_exception(tmp_path):
    rng, path, usable = np.random.default_rng(3), tmp_path / "damaged.urdf", 0
    for _ in range(80):
        path.write_text(damaged(rng))
        report = check_urdf(path)
        try:
            robot = Robot(RobotDescription("damaged", path))
            robot.visual_shapes(robot.configuration())
        except InputError:
            assert not report.ok
        else:
            usable += report.ok
    assert usable > 10
