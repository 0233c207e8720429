"""`rfcompass view` draws a stored grasp plan, and names what it cannot draw."""

import json

import numpy as np
import pytest

from rfcompass.robots import YouBot
from rfcompass.viz.live_window import LiveView

ROBOT = YouBot()
SCAN = ROBOT.posture("scan").joints.tolist()


def a_plan(tmp_path, **changes):
    """A plan file in which the hand stays where it is."""
    T_base_hand = ROBOT.tool_pose(ROBOT.posture("scan")).homogeneous.tolist()
    stages = [
        {"stage": stage, "times_s": [0.0, 1.0], "joints": [SCAN, SCAN], "bases": [[0, 0, 0]] * 2}
        for stage in ("reach", "approach", "close", "lift")
    ]
    rejected = {"T_part_hand": np.eye(4).tolist(), "score": None, "rejection": "too_wide", "message": "80 mm"}
    content = {
        "part": "table_leg_3", "success_probability": 0.9, "success_sd": 0.01, "risks": {},
        "joint_names": ROBOT.joint_names, "configuration": SCAN, "T_base_hand": T_base_hand,
        "T_part_hand": np.eye(4).tolist(), "aperture_m": 0.075, "closed_m": 0.05, "clearance_m": 0.004,
        "drive_to": [0, 0, 0], "stages": stages, "candidates": [rejected], **changes,
    }  # fmt: skip
    file = tmp_path / "plan.json"
    file.write_text(json.dumps(content))
    return file


def test_a_plan_becomes_a_page_beside_it(run, tmp_path):
    ran = run("view", a_plan(tmp_path), "--json")
    assert ran.code == 0, ran.err
    page = tmp_path / "plan.html"
    assert ran.json == {"page": str(page)}
    assert "rejected: too wide" in page.read_text(encoding="utf-8")


def an_estimate(folder, x_m=0.42):
    """An estimate file as `locate` prints it."""
    content = {"part": "table_leg_3", "centre_m": [x_m, 0.03], "theta_rad": 1.4, "stops": 1, "height_m": 0.025,
               "covariance": np.diag([1e-5, 1e-5, 1e-3]).tolist()}  # fmt: skip
    file = folder / "estimate.json"
    file.write_text(json.dumps(content))
    return file


def test_a_plan_that_was_stored_is_drawn_as_it_was_when_it_was_made(run, tmp_path):
    file, plan = an_estimate(tmp_path), tmp_path / "plan.json"
    ran = run("grasp", file, "--out", plan, "--page", tmp_path / "made.html", "--json")
    assert ran.code == 0, ran.err
    assert run("view", plan, "--estimate", file).code == 0
    made, read = (tmp_path / name for name in ("made.html", "plan.html"))
    assert f"rejected: {next(iter(ran.json['reasons'])).replace('_', ' ')}" in made.read_text(encoding="utf-8")
    assert made.read_bytes() == read.read_bytes()


def test_a_plan_knows_robot_and_scene_and_is_drawn_among_its_obstacles(run, tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    file, plan, scene = an_estimate(folder, x_m=0.5), tmp_path / "plan.json", tmp_path / "scene.json"
    crate = {"name": "crate", "box_m": [0.1, 0.1, 0.3], "position_m": [1.0, 1.6, 0.15], "material": "wood"}
    scene.write_text(json.dumps({"schema": "rfcompass-scene/1", "name": "crates", "room": None, "obstacles": [crate],
                                 "materials": {"wood": {"permittivity": 2.0}}}))  # fmt: skip
    where = ("--scene", scene, "--base", 1.0, 1.0, 0.2)
    ran = run("grasp", file, "--robot", "ur5e_2f85", *where, "--out", plan, "--page", tmp_path / "made.html", "--json")
    assert ran.code == 0, ran.err
    assert ran.json["robot"] == "ur5e_2f85"
    assert ran.json["base"] == pytest.approx([1.0, 1.0, 0.2])
    scene.unlink()
    assert run("view", plan, "--estimate", file).code == 0
    made, read = (tmp_path / name for name in ("made.html", "plan.html"))
    assert "obstacles" in made.read_text(encoding="utf-8")
    assert made.read_bytes() == read.read_bytes()


def test_why_there_is_no_grasp_is_drawn_too(run, tmp_path):
    ran = run("grasp", an_estimate(tmp_path, x_m=3.0), "--page", tmp_path / "why.html", "--json")
    assert ran.code == 1
    page = (tmp_path / "why.html").read_text(encoding="utf-8")
    for kind in ran.json["reasons"]:
        assert f"rejected: {kind.replace('_', ' ')}" in page


def test_the_estimate_brings_its_samples(run, tmp_path):
    file = tmp_path / "estimate.json"
    file.write_text(json.dumps({"part": "table_leg_3", "centre_m": [0.4, 0.0], "theta_rad": 0.1, "stops": 1}))
    np.savez(tmp_path / "samples.npz", samples=np.array([[0.4, 0.0, 0.1], [0.41, 0.0, 0.1]]))
    ran = run("view", a_plan(tmp_path), "--estimate", file)
    assert ran.code == 0, ran.err
    assert "belief/cloud" in (tmp_path / "plan.html").read_text(encoding="utf-8")


def test_a_plan_is_shown_live_on_request(run, tmp_path, monkeypatch):
    waited = []
    monkeypatch.setattr("webbrowser.open", lambda *_args, **_options: True)
    monkeypatch.setattr(LiveView, "wait", lambda live: waited.append(live) or live.close())
    ran = run("view", a_plan(tmp_path), "--show", "--json")
    assert ran.code == 0, ran.err
    assert len(waited) == 1
    assert set(ran.json) == {"page"}


@pytest.mark.parametrize(
    ("changes", "options", "kind"),
    [
        ({"part": "nothing"}, (), "UnknownPart"),
        ({}, ("--robot", "nobody"), "UnknownRobot"),
        ({"joint_names": list("abcdefg")}, (), "InputError"),
        ({"stages": 5}, (), "PlanFileError"),
    ],
)
def test_what_cannot_be_drawn_is_named(run, tmp_path, changes, options, kind):
    ran = run("view", a_plan(tmp_path, **changes), *options, "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, kind)
    assert not (tmp_path / "plan.html").exists()
