"""`rfcompass reach` leaves a map that planners can read, and a page."""

import numpy as np
import pytest

from planners import load_task_map
from rfcompass.robots.layouts import data_folder
from rfcompass.robots.packages import extra_folder

COARSE = ("--spacing", 0.08, "--headings", 2)


def test_a_map_is_written_with_a_page_and_not_overwritten(run, tmp_path):
    file = tmp_path / "map.npz"
    ran = run("reach", *COARSE, "--out", file, "--json")
    assert ran.code == 0, ran.err
    made = load_task_map(file)
    assert made.reached.shape == (*ran.json["voxels"], 2)
    assert made.reached.sum() == ran.json["reached"] > 0
    assert ran.json["share"] == pytest.approx(made.reached.mean())
    assert "can grasp from above" in (tmp_path / "map.html").read_text(encoding="utf-8")
    again = run("reach", *COARSE, "--out", file, "--json")
    assert (again.code, again.json["failure"]["kind"]) == (2, "InputError")


def test_solid_tags_take_grasps_away(run, tmp_path):
    maps = []
    for name, options in (("plain", ()), ("solid", ("--solid-tags",))):
        ran = run("reach", "--spacing", 0.03, "--headings", 2, *options, "--out", tmp_path / f"{name}.npz")
        assert ran.code == 0, ran.err
        maps.append(load_task_map(tmp_path / f"{name}.npz").reached)
    assert not (maps[1] & ~maps[0]).any()
    assert maps[1].sum() < maps[0].sum()
    assert np.isfinite(maps[0].mean())


@pytest.mark.slow
@pytest.mark.skipif(extra_folder() is None, reason="the robots extra is not installed")
def test_an_arm_with_closed_fingers_and_links_that_always_touch_has_a_map_too(run, tmp_path):
    file = tmp_path / "map.npz"
    ran = run("reach", "--robot", "panda", "--spacing", 0.2, "--headings", 1, "--out", file, "--json")
    assert ran.code == 0, ran.err
    assert ran.json["share"] > 0.3
    assert (tmp_path / "map.html").is_file()


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        (("--robot", "nobody"), "UnknownRobot"),
        (("--lowest", 0.2, "--highest", 0.1), "InputError"),
        (("--out", "nowhere/map.npz", *COARSE), "InputError"),
    ],
)
def test_bad_input_is_named_and_leaves_nothing(run, tmp_path, monkeypatch, options, kind):
    monkeypatch.chdir(tmp_path)
    ran = run("reach", *options, "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, kind)
    assert list(tmp_path.iterdir()) == []


def test_a_robot_without_a_tool_cannot_grasp(run, tmp_path):
    ran = run("reach", "--robot", data_folder() / "youbot.urdf", "--out", tmp_path / "map.npz", "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, "RobotModelError")
    assert "tool" in ran.json["failure"]["message"]
