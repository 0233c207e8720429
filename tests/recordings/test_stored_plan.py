"""A stored plan comes back with its motions and its candidates, and what is no plan is named."""

import json

import numpy as np
import pytest

from rfcompass.errors import PlanFileError, SceneError
from rfcompass.geometry import Pose2
from rfcompass.recordings import read_plan, read_plan_setting
from rfcompass.types.scene_json import scene_from_json

POSE = np.eye(4).tolist()
STORED = {
    "part": "table_leg_3",
    "success_probability": 0.9,
    "success_sd": 0.01,
    "risks": {"hand_hits_part": 0.1},
    "joint_names": ["a", "b"],
    "configuration": [0.2, 0.3],
    "T_base_hand": POSE,
    "T_part_hand": POSE,
    "aperture_m": 0.075,
    "closed_m": 0.05,
    "clearance_m": 0.004,
    "drive_to": [1.0, 2.0, 0.5],
    "stages": [
        {"stage": "approach", "times_s": [0.0, 1.0], "joints": [[0.1, 0.1], [0.2, 0.3]], "bases": [[0, 0, 0]] * 2},
        {"stage": "lift", "times_s": [0.0], "joints": [[0.2, 0.2]], "bases": [[0, 0, 0]]},
        {"stage": "retreat", "times_s": [0.0], "joints": [[0.0, 0.2]], "bases": [[0, 0, 0]]},
    ],
    "candidates": [
        {"T_part_hand": POSE, "score": 0.9, "rejection": None, "message": None},
        {"T_part_hand": POSE, "score": None, "rejection": "too_wide", "message": "80 mm"},
    ],
    "defects": [],
}


def stored(tmp_path, content):
    file = tmp_path / "plan.json"
    file.write_text(content if isinstance(content, str) else json.dumps(content))
    return file


def test_a_plan_comes_back(tmp_path):
    plan = read_plan(stored(tmp_path, STORED))
    assert (plan.part_id, plan.success_probability, plan.closed_m) == ("table_leg_3", 0.9, 0.05)
    assert (plan.base.x_m, plan.base.y_m, plan.base.theta_rad) == (1.0, 2.0, 0.5)
    assert [stage.stage for stage in plan.stages] == ["approach", "lift", "retreat"]
    assert plan.stages[0].names == ("a", "b")
    assert plan.approach.tolist() == [[0.1, 0.1], [0.2, 0.3]]
    assert plan.retreat.tolist() == [[0.2, 0.2], [0.0, 0.2]]
    assert plan.reasons == {"too_wide": 1}
    assert plan.candidates[0].score == 0.9
    assert plan.risks == (("hand_hits_part", 0.1),)


def test_a_plan_that_was_read_is_no_certificate(tmp_path):
    assert "no record of how the inverse kinematics was solved" in read_plan(stored(tmp_path, STORED)).defects


@pytest.mark.parametrize("key", [key for key in STORED if key != "defects"])
def test_a_missing_key_is_named(tmp_path, key):
    with pytest.raises(PlanFileError, match=f"{key} is missing") as failure:
        read_plan(stored(tmp_path, {name: value for name, value in STORED.items() if name != key}))
    assert failure.value.numbers["key"] == key


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("{", "cannot be read as JSON"),
        ("[]", "is no grasp plan"),
        ({"failure": {"kind": "too_wide", "message": "80 mm"}}, "a failure, too_wide: 80 mm"),
        ({**STORED, "configuration": "text"}, "is no grasp plan"),
        ({**STORED, "configuration": [0.1]}, "is no grasp plan"),
        ({**STORED, "stages": [{**STORED["stages"][0], "stage": "dance"}]}, "dance"),
        ({**STORED, "risks": []}, "is no grasp plan"),
        ({**STORED, "T_base_hand": [[1.0]]}, "is no grasp plan"),
    ],
)
def test_what_is_no_plan_is_refused(tmp_path, content, told):
    with pytest.raises(PlanFileError, match=told):
        read_plan(stored(tmp_path, content))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(PlanFileError, match=r"nowhere\.json"):
        read_plan(tmp_path / "nowhere.json")


SCENE = {"schema": "rfcompass-scene/1", "name": "bare", "room": None, "obstacles": [], "materials": {}}


def test_what_a_plan_was_made_for_comes_back(tmp_path):
    file = stored(tmp_path, {**STORED, "robot": "ur5e_2f85", "scene": SCENE, "base": [1.0, 2.0, 0.5]})
    setting = read_plan_setting(file)
    assert (setting.robot, setting.base) == ("ur5e_2f85", Pose2(1.0, 2.0, 0.5))
    assert setting.scene == scene_from_json(SCENE)
    assert read_plan(file).part_id == "table_leg_3"


def test_a_plan_of_an_older_version_does_not_say_what_it_was_made_for(tmp_path):
    setting = read_plan_setting(stored(tmp_path, STORED))
    assert (setting.robot, setting.scene, setting.base) == (None, None, Pose2())


@pytest.mark.parametrize(
    ("changed", "error"),
    [({"robot": 3}, PlanFileError), ({"base": [1.0]}, PlanFileError), ({"base": "here"}, PlanFileError),
     ({"scene": {"schema": "none"}}, SceneError)],
)  # fmt: skip
def test_a_setting_that_is_ill_typed_is_refused(tmp_path, changed, error):
    with pytest.raises(error):
        read_plan_setting(stored(tmp_path, {**STORED, **changed}))
