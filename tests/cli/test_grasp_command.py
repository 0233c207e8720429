"""`rfcompass grasp` plans for what `locate` printed, says why if it cannot, and names what is wrong with its input."""

import json

import numpy as np
import pytest

from rfcompass.arrays import plain
from rfcompass.cli.estimates import estimate_json
from rfcompass.types import PartEstimate

LEG = "table_leg_3"


def stored(folder, *, samples=True, **changed):
    """A run folder with an estimate."""
    mean, covariance = np.array([0.42, 0.03, 1.4]), np.diag([1e-5, 1e-5, 1e-3])
    estimate = PartEstimate(LEG, mean[:2], 1.4, "posterior", 3, 0.025, covariance)
    content = plain({**estimate_json(estimate, "auto"), **changed})
    folder.mkdir(exist_ok=True)
    (folder / "estimate.json").write_text(json.dumps(content), encoding="utf-8")
    if samples:
        draws = np.random.default_rng(0).multivariate_normal(mean, covariance, 300)
        np.savez(folder / "samples.npz", samples=draws)
    return folder


def test_a_run_folder_is_planned_and_the_plan_written_once(run, tmp_path):
    folder, out = stored(tmp_path / "run"), tmp_path / "plan.json"
    ran = run("grasp", folder, "--out", out, "--json")
    assert ran.code == 0, ran.err
    plan = ran.json
    assert plan == json.loads(out.read_text(encoding="utf-8"))
    assert plan["defects"] == []
    assert 0.5 < plan["success_probability"] <= 1
    assert [row["stage"] for row in plan["stages"]] == ["reach", "approach", "close", "lift", "retreat"]
    assert len(plan["configuration"]) == len(plan["joint_names"]) == 7
    assert all(row["apart"] for row in plan["certificates"])
    assert sum(plan["reasons"].values()) == sum(row["rejection"] is not None for row in plan["candidates"])
    again = run("grasp", folder, "--out", out, "--json")
    assert (again.code, again.json["failure"]["kind"]) == (2, "InputError")


def test_a_file_without_samples_or_height_will_do_and_people_get_a_table(run, tmp_path):
    folder = stored(tmp_path / "run", samples=False)
    file = folder / "estimate.json"
    content = json.loads(file.read_text(encoding="utf-8"))
    del content["height_m"]
    file.write_text(json.dumps(content), encoding="utf-8")
    ran = run("grasp", file, "--part", LEG)
    assert ran.code == 0, ran.err
    assert "success 0." in ran.out or "success 1.00" in ran.out
    assert "approach" in ran.out
    assert "rejected" in ran.err


@pytest.mark.parametrize(
    ("changed", "kind"),
    [
        ({"theta_rad": None, "covariance": None}, "orientation_unknown"),
        ({"centre_m": [3.0, 0.0], "covariance": None}, "unreachable"),
        ({"height_m": -0.5}, "part_in_the_floor"),
    ],
)
def test_no_grasp_is_exit_1_with_the_reason_and_what_was_tried(run, tmp_path, changed, kind):
    ran = run("grasp", stored(tmp_path / "run", samples=False, **changed), "--json")
    assert ran.code == 1, ran.err
    assert ran.json["failure"]["kind"] == kind
    assert kind in ran.err
    if kind == "unreachable":
        assert ran.json["drive_to"] is not None
        assert ran.json["reasons"]["unreachable"] > 0


def test_a_robot_by_name_grasps_too(run, tmp_path):
    folder = stored(tmp_path / "run", samples=False, centre_m=[0.5, 0.0], theta_rad=1.5708)
    ran = run("grasp", folder, "--robot", "ur5e_2f85", "--json")
    assert ran.code == 0, ran.err
    assert ran.json["joint_names"][0] == "shoulder_pan_joint"
    assert ran.json["defects"] == []
    assert ran.json["aperture_m"] == pytest.approx(0.085)


VAGUE = {"covariance": np.diag([1.2e-2**2, 1.2e-2**2, np.deg2rad(6.0) ** 2]).tolist()}
GOOD = {
    "alpha_m": 0.01,
    "beta": 0.0,
    "bias_m": 0.005,
    "comparison_m": 0.02,
    "anchor_pairs": 36,
    "rank_correlation": 0.9,
}


@pytest.mark.slow
def test_a_vague_estimate_should_be_measured_again_with_a_good_meter_only(run, tmp_path):
    file = stored(tmp_path / "run", samples=False, diagnostics=GOOD, **VAGUE) / "estimate.json"
    plan = run("grasp", file, "--measure-again", "--json").json
    advice = plan["measure_again"]
    assert advice["worth_it"]
    assert advice["success_now"] == plan["success_probability"]
    assert advice["success_after"] > advice["success_now"] + 0.05
    assert len(advice["stop"]["joints"]) == len(plan["joint_names"])
    told = run("grasp", file, "--measure-again")
    assert f"would rise from {advice['success_now']:.2f} to {advice['success_after']:.2f}" in told.out
    bad = {**GOOD, "alpha_m": 1.0, "comparison_m": 1.0, "bias_m": 0.2}
    file = stored(tmp_path / "bad", samples=False, diagnostics=bad, **VAGUE) / "estimate.json"
    assert run("grasp", file, "--measure-again", "--json").json["measure_again"] == {"worth_it": False}
    assert "grasp now" in run("grasp", file, "--measure-again").out


def test_advice_is_given_on_request_only_and_needs_to_know_how_sure_the_estimate_is(run, tmp_path):
    folder = stored(tmp_path / "run", samples=False, covariance=None)
    assert "measure_again" not in run("grasp", folder, "--json").json
    assert "does not say how sure it is" in run("grasp", folder, "--measure-again").out


def test_advice_for_tags_that_the_part_does_not_have_is_refused(run, tmp_path):
    ran = run("grasp", stored(tmp_path / "run"), "--measure-again", "--tags", 9, "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, "PartError")


def scene(tmp_path, **obstacle):
    file = tmp_path / "scene.json"
    thing = {"name": "crate", "box_m": [0.3, 0.3, 0.3], "position_m": [1.0, 1.0, 0.15], "material": "wood", **obstacle}
    content = {"schema": "rfcompass-scene/1", "name": "crates", "room": None, "obstacles": [thing],
               "materials": {"wood": {"permittivity": 2.0}}}  # fmt: skip
    file.write_text(json.dumps(content), encoding="utf-8")
    return file


def test_what_stands_around_counts_from_where_the_base_is(run, tmp_path):
    folder, file = stored(tmp_path / "run"), scene(tmp_path)
    assert run("grasp", folder, "--scene", file, "--json").code == 0
    blocked = run("grasp", folder, "--scene", file, "--base", 1.0, 1.0, 0.5, "--json")
    assert (blocked.code, blocked.json["failure"]["kind"]) == (1, "start_collision")


def test_a_run_that_ended_without_an_estimate_is_no_answer(run, tmp_path):
    (tmp_path / "estimate.json").write_text('{"failure": {"kind": "TagNeverHeard", "message": "none"}}')
    ran = run("grasp", tmp_path, "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (1, "NoEstimate")


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        (("--part", "table_leg_1"), "EstimateError"),
        (("--robot", "nobody"), "UnknownRobot"),
        (("--start", "asleep"), "RobotModelError"),
        (("--scene", "nowhere.json"), "SceneError"),
    ],
)
def test_bad_options_are_exit_2_and_named(run, tmp_path, options, kind):
    ran = run("grasp", stored(tmp_path / "run"), *options, "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, kind)


@pytest.mark.parametrize(
    ("changed", "kind"),
    [
        ({"covariance": [[None] * 3] * 3}, "ShapeError"),
        ({"part": "no_such_part"}, "UnknownPart"),
        ({"centre_m": "here"}, "EstimateError"),
    ],
)
def test_bad_estimates_are_exit_2_and_named(run, tmp_path, changed, kind):
    ran = run("grasp", stored(tmp_path / "run", samples=False, **changed), "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, kind)
