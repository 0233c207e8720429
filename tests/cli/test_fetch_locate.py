"""The first whole job, and what it leaves behind."""

import json
from pathlib import Path

import numpy as np
import pytest

from rfcompass.errors import OutOfReach
from rfcompass.recordings import open_trace
from rfcompass.recordings.parts import PartDatabase

META_KEYS = {
    "schema", "source", "license", "reader", "frame", "geometry", "phase_sign", "phase_modulus", "dimensions", "tags",
    "robot", "tag_layout",
}  # fmt: skip


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def fetched(tmp_path_factory):
    return tmp_path_factory.mktemp("fetch") / "run"


@pytest.fixture
def answer(run, fetched):
    """Answer of one fetch; later uses read it from the run folder."""
    if not fetched.exists():
        ran = run("fetch", "table_leg_3", "--seed", 3, "--out", fetched, "--database", ":memory:", "--json")
        assert ran.code == 0, ran.err
    return json.loads((fetched / "estimate.json").read_text())


def test_a_fetch_answers_in_the_agreed_shape(answer):
    shape = {"part", "centre_m", "theta_rad", "bearing_rad", "distance_m", "covariance", "region", "probability"}
    assert shape | {"method", "proximity", "stops", "outliers"} <= set(answer)
    assert answer["part"] == "table_leg_3"
    assert isinstance(answer["outliers"], int)
    assert answer["comparator"]["verdict"] in ("good", "fair", "poor", "useless")
    assert answer["comparator"]["pairs"] <= 36


def test_a_run_folder_is_complete_and_its_page_stands_alone(answer, fetched):
    names = {path.name for path in fetched.iterdir()}
    assert {"run.json", "events.jsonl", "trace", "estimate.json", "partition.png", "approach.png", "view.html"} <= names
    assert "src=" not in (fetched / "view.html").read_text().split("MeshCat.Viewer")[0][:500]
    assert json.loads((fetched / "run.json").read_text())["seed"] == 3


def test_the_first_program_of_the_readme_runs_on_what_a_fetch_leaves(answer, fetched, monkeypatch, capsys, tmp_path):
    text = (Path(__file__).resolve().parents[2] / "README.md").read_text(encoding="utf-8")
    program = text.split("```python\n", 1)[1].split("```", 1)[0]
    monkeypatch.setenv("RFCOMPASS_PARTS", ":memory:")
    monkeypatch.chdir(tmp_path)
    exec(program.replace("runs/fetch-table_leg_3-0/trace", str(fetched / "trace")), {})
    assert "[" in capsys.readouterr().out
    assert (tmp_path / "grasp.html").stat().st_size > 100_000


def test_the_same_seed_leaves_the_same_run_folder(run, answer, fetched, tmp_path):
    ran = run("fetch", "table_leg_3", "--seed", 3, "--out", tmp_path / "again", "--database", ":memory:")
    assert ran.code == 0
    assert contents(fetched) == contents(tmp_path / "again")


def test_the_trace_of_a_run_holds_no_truth(answer, fetched):
    trace = open_trace(fetched / "trace")
    base = trace.stops.base_poses[0]
    assert np.array_equal(base, [0.0, 0.0, 0.0])  # odometry starts at zero, wherever the robot truly was
    meta = json.loads((fetched / "trace" / "meta.json").read_text())
    assert set(meta) == META_KEYS
    assert {key for tag in meta["tags"] for key in tag} == {"epc", "body", "link", "point_m", "dipole"}
    with PartDatabase(":memory:") as database:
        known = database.part("table_leg_3").tags
    of_part = {tag["epc"]: tag for tag in meta["tags"] if tag["body"] != "robot"}
    assert of_part
    for epc, tag in of_part.items():
        row = known.epcs.index(epc)
        assert (tag["body"], "link" in tag) == ("table_leg_3", False)
        # In the part's own frame, as anybody can look it up; where the part lies is said nowhere.
        assert (tag["point_m"], tag["dipole"]) == (known.points_m[row].tolist(), known.dipoles[row].tolist())


def test_locate_finds_in_the_trace_what_fetch_found(run, answer, fetched):
    options = ("--part", "table_leg_3", "--last", answer["stops"], "--database", ":memory:", "--json")
    found = run("locate", fetched / "trace", *options).json
    assert found["centre_m"] == answer["centre_m"]
    assert found["theta_rad"] == answer["theta_rad"]
    assert found["proximity"] == answer["proximity"] == "sar_nearfield"


def test_without_a_radio_the_distances_are_known_up_to_noise(run, tmp_path):
    options = ("--proximity", "noisy_distance", "--sigma", 0.0, "--seed", 3, "--out", tmp_path / "run")
    ran = run("fetch", "table_leg_3", *options, "--database", ":memory:", "--json")
    assert ran.json["proximity"] == "noisy_distance"
    assert ran.json["simulated_error"]["centre_m"] < 0.05


def test_the_papers_way_ends_with_an_answer_or_a_typed_reason(run, tmp_path):
    options = ("--mode", "paper", "--seed", 3, "--out", tmp_path / "run")
    ran = run("fetch", "table_leg_3", *options, "--database", ":memory:", "--json")
    assert ran.code in (0, 1)
    assert ran.code == 0 or ran.json["failure"]["kind"] in ("Infeasible", "OutOfReach", "TagNeverHeard")
    assert open_trace(tmp_path / "run" / "trace").meta.geometry == "bistatic"


def test_view_leads_to_the_page_of_a_run(run, answer, fetched):
    ran = run("view", fetched, "--json")
    assert ran.code == 0
    assert ran.json["page"] == str(fetched / "view.html")


def test_a_run_is_not_overwritten_unasked(run, answer, fetched):
    ran = run("fetch", "table_leg_3", "--seed", 3, "--out", fetched, "--database", ":memory:", "--json")
    assert ran.code == 2


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        (("table_leg_9",), "UnknownPart"),
        (("table_leg_3", "--robot", "r2d2"), "UnknownRobot"),
        (("table_leg_3", "--tags", "7"), "PartError"),
        (("table_leg_3", "--proximity", "guess"), "UnknownMeter"),
        (("table_leg_3", "--scene", "moon"), "SceneError"),
        (("table_leg_3", "--scene", "room_los", "--occluded"), "InputError"),
        (("table_leg_3", "--proximity", "noisy_distance", "--others"), "InputError"),
        (("table_leg_3", "--proximity", "noisy_distance", "--mode", "paper"), "InputError"),
    ],
)
def test_what_does_not_exist_is_bad_input_and_leaves_nothing(run, tmp_path, options, kind):
    ran = run("fetch", *options, "--out", tmp_path / "run", "--database", ":memory:", "--json")
    assert ran.code == 2
    assert ran.json["failure"]["kind"] == kind
    assert list(tmp_path.iterdir()) == []


def test_locate_needs_a_trace_with_a_robot_and_a_part_that_was_heard(run, sweep, answer, fetched):
    ran = run("locate", sweep, "--part", "table_leg_3", "--database", ":memory:", "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, "TraceError")
    ran = run("locate", fetched / "trace", "--part", "table_leg_1", "--database", ":memory:", "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (1, "TagNeverHeard")


def test_a_fetch_that_fails_keeps_what_it_heard(run, tmp_path, monkeypatch):
    def out_of_reach(*arguments):
        raise OutOfReach("the hand cannot get there", miss_m=0.1)

    monkeypatch.setattr("planners.fetch.hand_over", out_of_reach)
    folder = tmp_path / "run"
    ran = run("fetch", "table_leg_3", "--seed", 3, "--out", folder, "--database", ":memory:", "--json")
    assert ran.code == 1
    assert ran.json == json.loads((folder / "estimate.json").read_text())
    assert ran.json["failure"]["kind"] == "OutOfReach"
    assert len(open_trace(folder / "trace").stop_ids) >= 1
