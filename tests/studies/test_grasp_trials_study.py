"""Runs need no fewer attempts with a narrower hand; a seed gives them again; stored errors keep their pairs."""

import numpy as np
import pytest

from rfcompass.errors import StudyError
from rfcompass.evaluation.error_pairs import ErrorFamily, ErrorPairs
from rfcompass.evaluation.records import TrialRecord
from rfcompass.studies import grasp_trials, stored_errors
from rfcompass.studies.accuracy import ACCURACY
from rfcompass.studies.folder import open_folder, read_rows
from rfcompass.studies.grasp_trials import (
    GRASP_TRIALS,
    OPENINGS_M,
    PRINTED,
    RULES,
    SOURCES,
    WIDTH_M,
    error_source,
    grasp_trial,
    printed_factor_bounds,
)
from rfcompass.studies.rows import RowWriter, stable_columns
from rfcompass.studies.runner import run_study
from rfcompass.studies.stored_errors import RUN_VARIABLE, accuracy_run

MEDIANS = "the paper's medians"
ROWS = 12


@pytest.fixture(autouse=True)
def nothing_remembered(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(RUN_VARIABLE, raising=False)
    grasp_trials._stored_run.cache_clear()
    yield
    grasp_trials._stored_run.cache_clear()


@pytest.fixture
def stored(tmp_path):
    """A run of `accuracy` with made-up errors: θ is ten times the distance; one trial in four has no θ."""
    folder = tmp_path / "runs" / "accuracy"
    writer = RowWriter(ACCURACY, open_folder(ACCURACY, ACCURACY.seeds, folder, resume=False))
    for cell in ACCURACY.cells:
        for index in range(ROWS):
            metrics = dict.fromkeys((metric.name for metric in ACCURACY.metrics), None)
            for method in ("posterior", "paper"):
                metrics[f"{method}_centre_3_m"] = 0.002 * (index + 1) + 0.0001 * cell["tags"]
                metrics[f"{method}_theta_3_rad"] = 10 * metrics[f"{method}_centre_3_m"] if index % 4 else None
            metrics["spread_3_m"] = 0.001 * (ROWS - index)
            writer.add(TrialRecord("accuracy", cell, 1000 + index, metrics))
    writer.flush()
    return folder


def trial(opening_m, seed=1, source=MEDIANS, tags=2):
    cell = {"source": source, "tags": tags, "opening_m": opening_m}
    return grasp_trial(cell, seed, np.random.default_rng(seed))


def test_a_wider_hand_never_needs_more_attempts_and_a_kinder_threshold_neither():
    for seed in range(5):
        narrow, middle, wide = (trial(opening_m, seed) for opening_m in OPENINGS_M)
        for rule in RULES:
            assert narrow[f"tries_{rule}"] >= middle[f"tries_{rule}"] >= wide[f"tries_{rule}"] >= 1
        assert all(found["tries_half"] >= found["tries_whole"] for found in (narrow, middle, wide))


def test_a_trial_says_what_its_study_declares_and_says_it_again():
    found = trial(0.075)
    assert set(found) == {metric.name for metric in GRASP_TRIALS.metrics}
    assert found == trial(0.075)
    for rule in RULES:
        assert found[f"first_{rule}"] == (found[f"tries_{rule}"] == 1)
    assert (found["first_verdict"] == "holds") == found["first_geometry"]


def test_every_source_exists_with_the_papers_medians_or_stored_rows(stored):
    for name in SOURCES:
        for tags in (2, 4):
            source = error_source(name, tags)
            assert isinstance(source, ErrorFamily | ErrorPairs)
    assert error_source(MEDIANS, 2).distance_quantile_m(0.5) == pytest.approx(0.0276)
    assert error_source(MEDIANS, 2).shape > error_source("the paper's medians, Rayleigh", 2).shape


def test_stored_pairs_stay_together_and_those_without_orientation_are_counted(stored):
    pairs = error_source("ours, near tracks", 4)
    assert len(pairs) == ROWS - ROWS // 4
    assert pairs.incomplete == ROWS // 4
    np.testing.assert_allclose(pairs.theta_rad, 10 * pairs.distance_m)
    assert pairs.distance_m.min() > error_source("ours, near tracks", 2).distance_m.min()
    assert pairs.heading_rad is None
    assert error_source("the paper's rig", 2).spread_m is None


def test_the_surest_half_is_smaller(stored):
    whole, sure = (error_source(name, 2) for name in ("ours, far tracks", "ours, far tracks, surest half"))
    assert len(sure) == pytest.approx(len(whole) / 2, abs=1)
    assert sure.spread_m.max() < whole.spread_m.max()


def test_a_run_may_be_named_by_the_environment(stored, tmp_path, monkeypatch):
    assert accuracy_run() == stored
    moved = stored.rename(tmp_path / "elsewhere")
    monkeypatch.setenv(RUN_VARIABLE, str(moved))
    assert accuracy_run() == moved


def test_a_named_run_that_is_not_there_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv(RUN_VARIABLE, str(tmp_path / "nothing"))
    with pytest.raises(StudyError, match=RUN_VARIABLE):
        accuracy_run()


def test_without_a_run_of_accuracy_only_families_are_tried_and_the_log_says_so(tmp_path, caplog):
    applies = [cell["source"] for cell in GRASP_TRIALS.cells if GRASP_TRIALS.applies(cell, 1000)]
    assert set(applies) == {MEDIANS, "the paper's medians, Rayleigh"}
    assert caplog.text.count("no run of the study accuracy") == 1
    with pytest.raises(StudyError, match="no run"):
        error_source("ours, near tracks", 2)


def test_a_cell_without_a_single_pair_is_refused(stored):
    with pytest.raises(StudyError, match="both a place and an orientation"):
        stored_errors.stored_errors(stored, "near L", "comparisons", 2)


def test_rows_are_the_same_bits_on_any_worker(tmp_path):
    tables = []
    for workers in (1, 2):
        run_study(GRASP_TRIALS, tmp_path / str(workers), trials=2, workers=workers, backend="threading")
        tables.append(stable_columns(read_rows(tmp_path / str(workers), GRASP_TRIALS)))
    assert tables[0].num_rows == 2 * 2 * 2 * len(OPENINGS_M)
    assert tables[0].equals(tables[1])


def test_the_papers_figures_bound_the_threshold():
    bounds = printed_factor_bounds()
    assert bounds.low == pytest.approx(0.0276 / (0.10 - WIDTH_M))
    assert bounds.high == pytest.approx(0.0276 / (0.085 - WIDTH_M))
    for one in PRINTED:
        assert one.chance == (one.value if one.metric == "first" else pytest.approx(1 / one.value))


def test_the_papers_values_stand_beside_ours_in_their_cells():
    cell = {"source": MEDIANS, "tags": 2, "opening_m": 0.075}
    assert GRASP_TRIALS.paper_value(cell, "tries_geometry", "mean").value == 9.0
    assert GRASP_TRIALS.paper_value({**cell, "tags": 4}, "first_half", "share").value == 0.9
    assert GRASP_TRIALS.paper_value({**cell, "tags": 4}, "tries_half", "mean") is None
