"""Places to mount tags lie on the robot, at their pitch, and a bad file says where it is bad."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError, RobotModelError
from rfcompass.robots import MountPatch, YouBot, load_layout, load_mounts, write_layout

SHEET = MountPatch(
    "sheet", "base_link", np.zeros(3), np.array([[0.3, 0, 0], [0, 0.1, 0]]), np.array([0, 0, 1.0]), "hand"
)
GOOD = {
    "name": "front", "link": "base_link", "corner_m": [0, 0, 0], "edges_m": [[0.2, 0, 0], [0, 0, 0]],
    "dipole": [0, 0, 1], "role": "base_front",
}  # fmt: skip


@given(pitch_m=st.floats(0.01, 0.5))
def test_places_cover_a_patch_from_edge_to_edge_and_no_farther_apart_than_asked(pitch_m):
    places_m = SHEET.places_m(pitch_m)
    assert places_m.min(axis=0).tolist() == [0, 0, 0]
    assert places_m.max(axis=0) == pytest.approx([0.3, 0.1, 0])
    for axis in (0, 1):
        assert np.diff(np.unique(places_m[:, axis].round(9))).max() <= pitch_m + 1e-9


def test_a_patch_with_one_edge_is_a_strip():
    strip = MountPatch(
        "strip", "base_link", np.zeros(3), np.array([[0.3, 0, 0], [0, 0, 0]]), np.array([0, 0, 1.0]), "hand"
    )
    assert strip.places_m(0.1)[:, 0] == pytest.approx([0.0, 0.1, 0.2, 0.3])


def test_the_youbots_mounts_are_on_links_of_the_youbot():
    mounts, robot = load_mounts("youbot"), YouBot()
    assert {patch.link for patch in mounts.patches} <= set(robot.kinematics.link_names)
    candidates = mounts.candidates(0.05)
    assert len(set(candidates.epcs)) == len(candidates.epcs) > 50


@pytest.mark.parametrize("name", ["designed6", "designed9", "text6"])
def test_shipped_layouts_keep_nine_centimetres_between_tags_at_the_scan_posture(name):
    robot = YouBot(name)
    points_m = robot.tag_positions(robot.posture("scan")).points_m
    apart_m = np.linalg.norm(points_m[:, None] - points_m[None], axis=2)
    assert apart_m[np.triu_indices(len(points_m), 1)].min() >= 0.09 - 1e-9


def test_a_layout_survives_writing_and_reading(tmp_path):
    layout = YouBot().layout
    read = load_layout(write_layout(layout, tmp_path / "layout.json", "again"))
    assert read.epcs == layout.epcs
    assert read.roles == layout.roles
    assert dict(read.counterparts) == dict(layout.counterparts)
    assert np.array_equal(read.points_m, layout.points_m)
    assert np.array_equal(read.dipoles, layout.dipoles)


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"patches": []}, InputError),
        ({"patches": [{**GOOD, "role": "roof"}]}, InputError),
        ({"patches": [{**GOOD, "edges_m": [[1, 0, 0]]}]}, RobotModelError),
        ({"patches": [{**GOOD, "corner_m": [0, 0]}]}, RobotModelError),
        ({"patches": [GOOD], "spacing_m": -1.0}, InputError),
        ({"patches": [GOOD], "spacing_m": "wide"}, RobotModelError),
        ({"schema": "rfcompass-mounts/2"}, RobotModelError),
    ],
)
def test_a_bad_file_of_mounts_is_refused_by_name(tmp_path, change, error):
    file = tmp_path / "mounts.json"
    file.write_text(json.dumps({"schema": "rfcompass-mounts/1", **change}))
    with pytest.raises(error, match=r"mounts\.json"):
        load_mounts(file)


def test_a_robot_without_mounts_is_refused():
    with pytest.raises(RobotModelError):
        load_mounts("r2d2")
