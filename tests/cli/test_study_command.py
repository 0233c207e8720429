"""`study run` hands its options to the runner, whose own tests say what they do."""

from pathlib import Path

import pytest

from rfcompass.studies import registry
from rfcompass.studies.folder import read_rows


@pytest.fixture(autouse=True)
def _toys(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "studies")
    monkeypatch.setattr(registry, "STUDIES", ("toy_registry:FIRST", "toy_registry:HOSTILE"))


def test_a_study_goes_on_after_a_trial_that_hangs_and_counts_it(run, tmp_path):
    ran = run("study", "run", "hostile", "--trials", 4, "--trial-seconds", 1.5, "--out", tmp_path, "--json")
    assert ran.code == 0
    assert {row["failures"] for row in ran.json["rows"]} == {1}
    assert read_rows(tmp_path).column("failure_kind").to_pylist() == [None, None, "timed_out", None]


def test_a_resumed_run_adds_what_is_missing(run, tmp_path):
    here = ("--backend", "sequential", "--out", tmp_path)
    assert run("study", "run", "first", "--trials", 2, *here).code == 0
    assert run("study", "run", "first", "--trials", 3, *here).code == 2
    assert run("study", "run", "first", "--trials", 3, "--resume", *here).code == 0
    assert read_rows(tmp_path).num_rows == 12


@pytest.mark.parametrize(
    "wrong",
    [
        ("--trial-seconds", 0),
        ("--trial-megabytes", -5),
        ("--scheduler", "tcp://192.0.2.7:8786"),
        ("--backend", "pigeon"),
    ],
)
def test_what_cannot_be_is_bad_input_and_leaves_nothing(run, tmp_path, wrong):
    ran = run("study", "run", "first", "--out", tmp_path / "out", "--json", *wrong)
    assert (ran.code, ran.json["failure"]["kind"]) == (2, "StudyError")
    assert not (tmp_path / "out").exists()
