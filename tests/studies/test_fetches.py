"""The study of whole fetches: every end is a row, and an end without an answer has no errors."""

import pytest

from rfcompass.errors import OutOfReach
from rfcompass.studies import fetches
from rfcompass.studies.fetch_modes import NOISY_DISTANCE, Mode, fetch_mode
from rfcompass.studies.fetches import FETCHES, FETCHES_ON_A_MAP, fetch_on_map_trial, fetch_trial
from rfcompass.studies.fetching import SimulatedFetch


def cell(**values):
    return {"sight": "in sight", "way": "distances, 5 % noise", "tags": 4, **values}


def test_a_fetch_is_judged_at_its_last_stop():
    row = fetch_trial(cell(), 3, None)
    assert row["answered"]
    assert row["found"] == (row["centre_error_m"] <= 0.10)
    assert row["stops"] >= 5
    assert row["held"]
    assert row["held_at_once"] == (row["tries"] == 1.0)
    assert 0.0 < row["drive_s"] < row["total_s"] - row["scan_s"]  # the rest is the arm's


def test_one_tag_is_located_and_not_grasped():
    row = fetch_trial(cell(tags=1), 3, None)
    assert row["answered"]
    assert (row["held"], row["tries"], row["chance"]) == (False, None, None)


def test_an_end_without_an_answer_is_a_row_with_its_reason(monkeypatch):
    def ends(self):
        raise OutOfReach("too far")
        yield

    monkeypatch.setattr(SimulatedFetch, "steps", ends)
    row = fetch_trial(cell(), 3, None)
    assert row == {"centre_error_m": None, "theta_error_rad": None, "found": False, "stops": 0.0,
                   "ended": "OutOfReach", "answered": False, "held": False, "held_at_once": False, "tries": None,
                   "chance": None, "drive_s": None, "scan_s": None, "total_s": None}  # fmt: skip


def test_the_paper_and_we_differ_in_track_meter_and_estimator():
    paper, best = fetch_mode(Mode.PAPER), fetch_mode(Mode.BEST)
    assert (len(paper.radio.legs_m), len(best.radio.legs_m)) == (1, 2)
    assert (paper.meter.kind, best.meter.kind) == ("pinit_dtw", "auto")
    assert type(paper.localizer) is not type(best.localizer)
    assert fetch_mode(Mode.BEST, "rssi").meter.kind == "rssi"


def test_without_a_radio_there_is_no_meter_and_no_scene():
    mode = fetch_mode(Mode.BEST, NOISY_DISTANCE)
    assert mode.radio is None
    assert mode.meter is None
    assert mode.in_scene(scene="room_nlos") is mode
    assert fetch_mode(Mode.BEST).in_scene(scene="room_nlos").radio.scene == "room_nlos"


@pytest.mark.parametrize("one", FETCHES.cells, ids=str)
def test_distances_with_noise_are_tried_in_sight_only(one):
    assert FETCHES.applies(one, 1000) == (one["way"] != "distances, 5 % noise" or one["sight"] == "in sight")


def test_on_a_map_furniture_is_solid_and_the_robot_knows_where_it_stands_from_its_tags(monkeypatch):
    tasks = []
    monkeypatch.setattr(fetches, "_fetched", lambda task: tasks.append(task) or {})
    fetch_on_map_trial(cell(), 3, None)
    fetch_trial(cell(way="best"), 3, None)
    mapped, straight = tasks
    assert (mapped.map_pose, straight.map_pose) == ("radio", None)
    assert mapped.radio == straight.radio


@pytest.mark.parametrize("one", FETCHES_ON_A_MAP.cells, ids=str)
def test_fewer_hidden_rooms_are_tried_on_a_map(one):
    hidden = one["sight"] == "hidden"
    assert FETCHES_ON_A_MAP.applies(one, 1029) == (not hidden or one["tags"] == 4)
    assert FETCHES_ON_A_MAP.applies(one, 1030) is not hidden
