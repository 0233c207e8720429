"""`rfcompass layout` leaves a layout that the robot can wear, and a picture."""

import json

import numpy as np
import pytest

from rfcompass.robots import YouBot


def test_a_designed_layout_can_be_worn_and_is_better_than_the_present_one_of_nine(run, tmp_path):
    file = tmp_path / "mine.json"
    ran = run("layout", "--tags", 9, "--out", file, "--database", ":memory:", "--json")
    assert ran.code == 0, ran.err
    assert ran.json["expected_error_m"] < ran.json["present_error_m"]
    assert (tmp_path / "mine.png").stat().st_size > 10_000
    worn = YouBot(str(file)).layout
    assert len(worn.epcs) == 9
    assert {"hand_left", "hand_right"} <= set(worn.roles)
    assert np.allclose(worn.points_m, [tag["point_m"] for tag in ran.json["tags"]])
    again = run("layout", "--tags", 9, "--out", file, "--database", ":memory:", "--json")
    assert (again.code, again.json["failure"]["kind"]) == (2, "InputError")


STRIP = {
    "name": "strip", "link": "base_link", "corner_m": [0.3, -0.05, 0], "edges_m": [[0, 0.1, 0], [0, 0, 0]],
    "dipole": [0, 0, 1], "role": "base_front",
}  # fmt: skip


@pytest.mark.parametrize(
    ("options", "code", "kind"),
    [
        (("--mounts", "strip.json"), 1, "NoRoomForTags"),
        (("--mounts", "nowhere.json"), 2, "RobotModelError"),
        (("--part", "table_leg_9"), 2, "UnknownPart"),
    ],
)
def test_what_cannot_be_designed_leaves_nothing(run, tmp_path, monkeypatch, options, code, kind):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "strip.json").write_text(json.dumps({"schema": "rfcompass-mounts/1", "patches": [STRIP]}))
    ran = run("layout", *options, "--out", tmp_path / "mine.json", "--database", ":memory:", "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (code, kind)
    assert [path.name for path in tmp_path.iterdir()] == ["strip.json"]


def test_lying_tags_of_a_part_are_warned_of(run, tmp_path, monkeypatch):
    monkeypatch.setattr("rfcompass.localization.lying_tags", lambda layout: layout.epcs)
    ran = run("layout", "--tags", 4, "--out", tmp_path / "mine.json", "--database", ":memory:", "--json")
    assert "lies flat" in ran.err
    assert len(json.loads((tmp_path / "mine.json").read_text())["tags"]) == 4
