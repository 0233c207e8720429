"""Several parts in one room: each is fetched and delivered, a silent one ends alone, bad tasks are refused."""

import json

import numpy as np
import pytest

from rfcompass.recordings import is_run, is_task, open_trace

LEGS = [f"table_leg_{number}" for number in (1, 2, 3, 4)]
QUIET = ("--proximity", "noisy_distance", "--sigma", 0.02, "--database", ":memory:", "--json")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("task") / "lack"


@pytest.fixture
def task(run, folder):
    """Answer of one task, asked for once."""
    kept = folder.parent / "answer.json"
    if not folder.exists():
        ran = run("fetch", "--all-of", "LACK", "--seed", 3, "--out", folder, *QUIET)
        assert ran.code == 0, ran.err
        kept.write_text(ran.out)
    return json.loads(kept.read_text())


def lines(folder):
    return [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]


def test_all_legs_of_the_table_are_delivered_in_order(task):
    assert [answer["part"] for answer in task["parts"]] == LEGS
    assert all(answer["delivered"] and answer["grasp"]["held"] for answer in task["parts"])
    assert [(a["part"], a["action"]) for a in task["actions"]] == [
        (leg, verb) for leg in LEGS for verb in ("navigate", "localise", "grasp", "deliver")
    ]
    assert all(action["done"] and len(action["tags"]) == 4 for action in task["actions"])


def test_a_part_ends_where_it_was_to_go_as_the_robot_believes_and_truly_within_slip_and_estimate(task):
    for answer in task["parts"]:
        put = answer["put_down"]
        assert put["short_m"] < 1e-6
        assert np.allclose(put["part"][:2], put["goal"][:2])
        assert put["carried_over_floor_m"] > 0.05
        # Slip of 4 mm and half a degree a drive, over some forty drives and up to four metres.
        assert put["simulated"]["centre_error_m"] < 0.25
        assert abs(put["simulated"]["drop_m"]) < 0.01


def test_the_events_hold_the_tuple_of_every_localisation(task, folder):
    events = lines(folder)
    found = [event for event in events if "location" in event]
    assert len(found) == sum(answer["stops_made"] for answer in task["parts"])
    assert all(set(event["location"]) == {"phi_rad", "D_m", "theta_rad"} for event in found)
    for answer in task["parts"]:
        last = [event["location"] for event in found if event["part"] == answer["part"]][-1]
        assert last == {
            "phi_rad": answer["bearing_rad"],
            "D_m": answer["distance_m"],
            "theta_rad": answer["theta_rad"],
        }
    verbs = [event["action"] for event in events if event["part"] == LEGS[0]]
    assert sorted(set(verbs), key=verbs.index) == ["navigate", "localise", "grasp", "deliver"]


def test_every_part_leaves_a_run_folder_that_other_commands_read(run, task, folder):
    assert is_task(folder)
    assert all(is_run(folder / leg) for leg in LEGS)
    stops = [stop for leg in LEGS for stop in open_trace(folder / leg / "trace").stop_ids]
    assert stops == list(range(len(LEGS), len(LEGS) + len(stops)))  # one odometry, one count; the survey came first
    answer = task["parts"][2]
    options = ("--last", answer["stops"], "--estimator", "consistency", "--database", ":memory:", "--json")
    again = run("locate", folder / LEGS[2] / "trace", "--part", LEGS[2], *options).json
    assert again["centre_m"] == answer["centre_m"]


def test_the_page_of_the_task_plays_it_from_part_to_part(task, folder):
    page = (folder / "view.html").read_text(encoding="utf-8")
    assert all(f">{leg}</a>" in page for leg in LEGS)  # the time can be set to where each part begins
    assert "table_leg_4</td><td" in page


def test_shown_live_a_task_leaves_the_same_folder(run, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda address, *_, **__: opened.append(address))
    monkeypatch.setattr("rfcompass.viz.live_task.time.sleep", lambda seconds: None)
    folders = [tmp_path / name for name in ("shown", "unseen")]
    for folder, show in zip(folders, (("--show",), ()), strict=True):
        ran = run("fetch", LEGS[2], "--deliver", "0.9,0.3,0.5", "--seed", 3, *show, "--out", folder, *QUIET)
        assert ran.code == 0, ran.err
    assert opened[0].startswith("http://127.0.0.1")
    assert opened[-1] == (folders[0] / "view.html").resolve().as_uri()
    for name in ("task.json", "events.jsonl", "view.html"):
        assert (folders[0] / name).read_bytes() == (folders[1] / name).read_bytes()


def test_a_task_is_overwritten_when_asked_only(run, task, folder, tmp_path):
    ran = run("fetch", "--all-of", "LACK", "--seed", 3, "--out", folder, *QUIET)
    assert (ran.code, ran.json["failure"]["kind"]) == (2, "TraceError")


def test_one_part_with_a_place_to_deliver_to_is_a_task_of_one(run, tmp_path):
    ran = run("fetch", LEGS[2], "--deliver", "0.9,0.3,0.5", "--seed", 3, "--out", tmp_path / "task", *QUIET)
    assert ran.code == 0, ran.err
    (answer,) = ran.json["parts"]
    assert answer["put_down"]["goal"] == [0.9, 0.3, 0.5]


def test_a_silent_part_ends_with_a_reason_and_the_others_are_still_fetched(run, tmp_path):
    options = ("--silent", LEGS[0], "--seed", 3, "--out", tmp_path / "task")
    ran = run("fetch", LEGS[0], LEGS[1], *options, *QUIET)
    assert ran.code == 1
    silent, other = ran.json["parts"]
    assert (silent["delivered"], silent["failure"]["kind"]) == (False, "TagNeverHeard")
    assert other["delivered"]
    assert [action["done"] for action in ran.json["actions"]] == [False] * 4 + [True] * 4
    ends = [event for event in lines(tmp_path / "task") if event["action"] == "end"]
    assert [(end["part"], end["failure"]["kind"]) for end in ends] == [(LEGS[0], "TagNeverHeard")]


@pytest.mark.slow
def test_by_radio_a_silent_part_is_looked_for_from_every_corner_and_the_others_are_delivered(run, tmp_path):
    options = ("--silent", LEGS[1], "--seed", 2, "--out", tmp_path / "task", "--database", ":memory:", "--json")
    ran = run("fetch", "--all-of", "LACK", "--no-map", *options)
    assert ran.code == 1
    by_name = {answer["part"]: answer for answer in ran.json["parts"]}
    assert by_name[LEGS[1]]["failure"]["kind"] == "TagNeverHeard"
    heard = open_trace(tmp_path / "task" / LEGS[1] / "trace")
    assert 2 <= len(heard.stop_ids) <= 9  # the far legs once, then at most four corners and four quarters
    assert all(by_name[leg]["delivered"] for leg in LEGS if leg != LEGS[1])


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        (("table_leg_1", "table_leg_9"), "UnknownPart"),
        (("table_leg_1", "table_leg_2", "table_leg_1"), "InputError"),
        (("table_leg_1", "--all-of", "LACK"), "InputError"),
        ((), "InputError"),
        (("--all-of", "BILLY"), "UnknownPart"),
        (("table_leg_1", "--deliver", "there"), "InputError"),
        (("table_leg_1", "--deliver", "1,2"), "InputError"),
        (("table_leg_1", "--deliver", "1,2,nan"), "InputError"),
        (("--all-of", "LACK", "--no-grasp"), "InputError"),
        (("--all-of", "LACK", "--tags", "1"), "InputError"),
        (("table_leg_1", "--silent", "table_leg_2"), "InputError"),
    ],
)
def test_a_task_that_cannot_be_is_bad_input_and_leaves_nothing(run, tmp_path, options, kind):
    ran = run("fetch", *options, "--out", tmp_path / "task", *QUIET)
    assert (ran.code, ran.json["failure"]["kind"]) == (2, kind)
    assert list(tmp_path.iterdir()) == []
