"""`rfcompass search`: its answer, its folder, and what it refuses."""

import json

import pytest

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from rfcompass.recordings.search_folder import is_search
from rfcompass.simulation.piles import open_pile

SMALL = ("--items", 4, "--way", "covered", "--seed", 1)


def test_a_search_leaves_a_folder_that_says_what_it_printed(run, tmp_path):
    out = tmp_path / "search"
    ran = run("search", *SMALL, "--tagged", 2, "--out", out, "--json")
    assert ran.code == (0 if ran.json["found"] else 1), ran.err
    told = json.loads((out / "search.json").read_text(encoding="utf-8"))
    assert {key: told[key] for key in ("outcome", "actions", "elapsed_s")} == {
        key: ran.json[key] for key in ("outcome", "actions", "elapsed_s")
    }
    events = [json.loads(line) for line in (out / "events.jsonl").read_text(encoding="utf-8").splitlines()]
    assert events == told["steps"]
    asked = json.loads((out / "run.json").read_text(encoding="utf-8"))
    assert (asked["policy"], asked["seed"], asked["tagged"]) == ("ours", 1, 2)
    survey = run("survey", out / "trace", "--method", "sar", "--json").json  # what was heard can be located again
    assert 1 <= len(survey["tags"]) <= asked["tags_dealt"]
    report = (out / "report.html").read_text(encoding="utf-8")
    assert "simulated, covered, 4 distractors, 1 pile(s), seed 1" in report
    assert len(events) == ran.json["actions"]
    assert open_pile(out / "pile.json").seed == 1
    for page in ("view.html", "report.html"):
        text = (out / page).read_text(encoding="utf-8")
        assert "https://" not in text.replace("https://www.w3.org", "").split("<script")[0]
    assert is_search(out)
    assert run("view", out, "--json").json["page"] == str(out / "view.html")

    again = run("search", *SMALL, "--out", out, "--json")
    assert (again.code, again.json["failure"]["kind"]) == (2, "TraceError")
    assert json.loads((out / "search.json").read_text(encoding="utf-8")) == told


def test_a_target_that_is_not_there_is_no_answer_with_the_maps_verdict(run, tmp_path):
    ran = run("search", *SMALL, "--absent", "--out", tmp_path / "run", "--json")
    assert ran.code == 1
    assert ran.json["failure"]["kind"] == ran.json["outcome"] != "found"
    assert ran.json["failure"]["hidden_m3"] == ran.json["hidden_m3"] >= 0
    assert 0 <= ran.json["room_m3"] <= ran.json["hidden_m3"]
    assert "l are left in which it could lie" in ran.err
    assert (tmp_path / "run" / "view.html").is_file()


@pytest.mark.parametrize(
    ("options", "word"),
    [(("--policy", "best"), "fusebot"), (("--tagged", -1), "--tagged"), (("--piles", 4), "--piles")],
)
def test_what_cannot_be_is_refused_and_nothing_written(run, tmp_path, options, word):
    ran = run("search", *SMALL, *options, "--out", tmp_path / "run")
    assert ran.code == 2
    assert word in ran.err
    assert not (tmp_path / "run").exists()


def test_tags_that_nothing_can_carry_are_not_counted(run, tmp_path):
    ran = run("search", *SMALL, "--tagged", 50, "--out", tmp_path / "run", "--json")
    assert ran.json["tagged"] < 5
    assert f"only {ran.json['tagged']} distractors" in ran.err


def test_a_folder_that_cannot_be_is_refused_before_a_pile_is_made(run, tmp_path, monkeypatch):
    def make_pile(*asked):
        raise AssertionError("too late")

    monkeypatch.setattr("rfcompass.simulation.piles.make_pile", make_pile)
    (tmp_path / "afile").write_text("mine", encoding="utf-8")
    ran = run("search", *SMALL, "--out", tmp_path / "afile" / "sub", "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, "TraceError")
    assert "is no folder" in ran.err
