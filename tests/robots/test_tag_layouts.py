"""Tag layouts and robot descriptions as JSON files: errors name the file and the key."""

import json

import pytest

from rfcompass.errors import DuplicateEpc, InputError, RobotModelError, UnknownRobot
from rfcompass.robots import Robot, known_layouts, load_layout
from rfcompass.robots.description import load_description
from rfcompass.robots.layouts import data_folder, find_layout

TAG = {"epc": "0" * 24, "link": "base_link", "point_m": [0.1, 0, 0], "dipole": [0, 0, 2], "role": "base_front"}
LAYOUT = {
    "schema": "rfcompass-tags/1",
    "tags": [TAG, {**TAG, "epc": "AB" * 12, "role": "hand_left"}],
    "counterparts": {"2": {"hand_left": 1, "hand_right": 0}},
}
ROBOT = {"schema": "rfcompass-robot/1", "name": "mine", "urdf": "robot.urdf", "base": "planar"}


def written(folder, content, name="file.json"):
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def with_tag(**changes):
    return {**LAYOUT, "tags": [{**TAG, **changes}]}


def test_a_layout_is_read_with_unit_dipoles_and_lower_case_epcs(tmp_path):
    layout = load_layout(written(tmp_path, LAYOUT))
    assert layout.epcs == ("0" * 24, "ab" * 12)
    assert layout.dipoles.tolist() == [[0, 0, 1], [0, 0, 1]]
    assert layout.with_role("hand_left") == (1,)
    assert layout.counterparts[2]["hand_left"] == 1


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("{", "is no JSON"),
        ("[" * 100_000, "is no JSON"),
        ([], "rfcompass-tags/1"),
        ({**LAYOUT, "schema": "rfcompass-tags/2"}, "rfcompass-tags/1"),
        ({"schema": "rfcompass-tags/1"}, "tags is missing"),
        ({**LAYOUT, "tags": [1]}, "no object"),
        ({**LAYOUT, "tags": {}}, "tags is of type dict"),
        (with_tag(epc="12"), "no 96-bit EPC"),
        (with_tag(epc=12), "epc is of type int"),
        (with_tag(link=None), "link is missing"),
        (with_tag(point_m=[0, 0]), "not three finite numbers"),
        (with_tag(point_m=[0, 0, 1e400]), "not three finite numbers"),
        (with_tag(dipole=[0, 0, 0]), "length zero"),
        (with_tag(role="captain"), "unknown roles"),
        ({**LAYOUT, "counterparts": {"2": {"hand_left": 2, "hand_right": 0}}}, "each from 0 to 1"),
        ({**LAYOUT, "counterparts": {"two": {"hand_left": 0, "hand_right": 0}}}, "counterparts of two"),
        ({**LAYOUT, "counterparts": {"2": {"hand_left": 0}}}, "hand_left and hand_right"),
    ],
)
def test_a_broken_layout_is_an_error_that_names_file_and_reason(tmp_path, content, reason):
    with pytest.raises(InputError, match=reason) as caught:
        load_layout(written(tmp_path, content))
    assert caught.value.numbers["file"] == str(tmp_path / "file.json")


def test_an_epc_that_stands_twice_is_refused(tmp_path):
    with pytest.raises(DuplicateEpc, match=r"file\.json") as caught:
        load_layout(written(tmp_path, {**LAYOUT, "tags": [TAG, TAG]}))
    assert caught.value.numbers["epc"] == "0" * 24


@pytest.mark.parametrize("name", known_layouts())
def test_every_shipped_layout_has_nine_or_six_tags_and_all_counterparts(name):
    layout = load_layout(find_layout(name))
    assert len(layout.epcs) in (6, 9)
    assert {"hand_left", "hand_right", "base_front"} < set(layout.roles)
    assert set(layout.counterparts) == {1, 2, 3, 4}


def test_layouts_of_one_robot_use_the_same_epcs_and_those_of_others_do_not():
    epcs = {name: set(load_layout(find_layout(name)).epcs) for name in known_layouts()}
    assert epcs["youbot_skew6"] < epcs["youbot_x4"] == epcs["youbot_l0"]
    assert not epcs["youbot_x4"] & (epcs["panda_x4"] | epcs["pr2_x4"] | epcs["tiago_x4"])


def test_a_layout_is_found_by_name_by_short_name_or_by_path(tmp_path):
    assert find_layout("youbot_l0") == find_layout("l0", "youbot")
    path = written(tmp_path, LAYOUT)
    assert find_layout(str(path)) == path
    with pytest.raises(UnknownRobot, match="youbot_x4"):
        find_layout(str(tmp_path / "missing.json"))


def test_a_robot_of_ones_own_is_three_files(tmp_path):
    (tmp_path / "robot.urdf").write_bytes((data_folder() / "youbot.urdf").read_bytes())
    written(tmp_path, LAYOUT, "tags.json")
    extra = {"tag_layout": "tags.json", "tool_frame": "arm_link_5", "closing_axis": [1, 0, 0]}
    robot = Robot(load_description(written(tmp_path, {**ROBOT, **extra}, "mine.json")))
    assert (robot.name, robot.is_mobile, robot.tool.frame) == ("mine", True, "arm_link_5")
    assert robot.description.layout_name == "tags"
    assert robot.tag_positions(robot.configuration()).points_m[0] == pytest.approx([0.1, 0, 0.084])


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"name": None}, "name is missing"),
        ({"base": "flying"}, "none of"),
        ({"tool_frame": 3}, "tool_frame is of type int"),
        ({"tool_frame": "x", "approach_axis": [0, 1, 0]}, "perpendicular"),
        ({"package_dirs": [1]}, "no string"),
        ({"postures": {"bent": [1]}}, "posture bent"),
        ({"postures": {"bent": {"a": "b"}}}, "posture bent"),
        ({"urdf": "package://nobody/robot.urdf"}, "no package 'nobody'"),
        ({"tag_layout": "missing.json"}, "missing.json: cannot be read"),
    ],
)
def test_a_broken_robot_description_is_an_error_with_a_reason(tmp_path, changes, reason):
    with pytest.raises(RobotModelError, match=reason):
        load_description(written(tmp_path, {**ROBOT, **changes}))
