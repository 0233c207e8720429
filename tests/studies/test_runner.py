import itertools
import os
import random
import subprocess
import sys
import time
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from pathlib import Path

import pytest
from joblib.externals.loky import get_reusable_executor
from toy_study import killing_toy_trial, toy_study, toy_trial

from rfcompass.errors import StudyError
from rfcompass.studies import runner
from rfcompass.studies.folder import read_rows
from rfcompass.studies.rows import RowWriter, stable_columns
from rfcompass.studies.runner import run_study

HERE = {"backend": "sequential"}


def rows_of(out):
    return stable_columns(read_rows(out))


def in_small_shards(monkeypatch, shard_rows):
    monkeypatch.setattr(runner, "RowWriter", lambda study, folder: RowWriter(study, folder, shard_rows))


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    out = tmp_path_factory.mktemp("expected")
    run_study(toy_study(), out, **HERE)
    return rows_of(out)


def test_every_trial_has_one_row_and_failures_do_not_stop_the_study(tmp_path):
    summary = run_study(toy_study(), tmp_path, **HERE)
    assert (summary.total, summary.found, summary.run) == (32, 0, 32)
    assert summary.failures == {"TooFewReads": 2}  # seed 3, method shy, two noises
    rows = read_rows(tmp_path).to_pylist()
    assert [(row["cell"], row["seed"]) for row in rows] == list(itertools.product(range(4), range(8)))
    assert [row["failure_kind"] for row in rows].count(None) == 30
    assert all(row["error_m"] is None for row in rows if row["failure_kind"])


def test_rows_are_equal_to_the_last_bit_for_any_number_of_worker_processes(tmp_path, monkeypatch):
    tables = []
    for workers in (1, 2):
        in_small_shards(monkeypatch, 3 * workers)
        summary = run_study(toy_study(), tmp_path / str(workers), workers=workers)
        assert summary.run == 32
        tables.append(rows_of(tmp_path / str(workers)))
    assert tables[0].equals(tables[1])


@pytest.mark.parametrize("seed", range(4))
def test_a_resume_after_shards_are_lost_gives_the_same_rows(tmp_path, monkeypatch, expected, seed):
    in_small_shards(monkeypatch, 3)
    run_study(toy_study(), tmp_path, **HERE)
    shards = sorted((tmp_path / "rows").iterdir())
    lost = random.Random(seed).sample(shards, 4)
    for shard in lost[:2]:
        shard.unlink()
    for shard in lost[2:]:
        shard.write_bytes(shard.read_bytes()[: 100 * seed])
    summary = run_study(toy_study(), tmp_path, resume=True, **HERE)
    assert summary.found + summary.run == 32
    assert 10 <= summary.run <= 12
    assert rows_of(tmp_path).equals(expected)


@pytest.mark.parametrize(("backend", "workers"), [("sequential", 1), ("threading", 2)])
def test_an_interrupt_keeps_what_has_arrived_and_a_resume_does_the_rest(tmp_path, expected, backend, workers):
    def interrupt(progress):
        if progress.done == 11:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(toy_study(), tmp_path, backend=backend, workers=workers, progress=interrupt)
    assert read_rows(tmp_path).num_rows == 11
    summary = run_study(toy_study(), tmp_path, resume=True, **HERE)
    assert (summary.found, summary.run) == (11, 21)
    assert rows_of(tmp_path).equals(expected)


def test_a_run_killed_at_any_moment_goes_on_where_it_was(tmp_path, expected):
    code = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from functools import partial\n"
        "from toy_study import slow_toy_trial, toy_study\n"
        "from rfcompass.studies import runner\n"
        "runner.RowWriter = partial(runner.RowWriter, shard_rows=2)\n"
        f"runner.run_study(toy_study(trial=slow_toy_trial), {str(tmp_path)!r}, backend='sequential')\n"
    )
    victim = subprocess.Popen([sys.executable, "-c", code])
    while len(list(tmp_path.glob("rows/*.parquet"))) < 3:
        assert victim.poll() is None, "ended before it could be killed"
        time.sleep(0.01)
    victim.kill()
    victim.wait()
    summary = run_study(toy_study(), tmp_path, resume=True, **HERE)
    assert summary.found >= 6
    assert summary.found + summary.run == 32
    assert rows_of(tmp_path).equals(expected)


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_a_run_killed_at_five_random_moments_gives_the_same_rows(tmp_path, workers):
    run_study(toy_study(), tmp_path / "expected", trials=100, **HERE)
    code = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from functools import partial\n"
        "from toy_study import slow_toy_trial, toy_study\n"
        "from rfcompass.studies import rows, runner\n"
        "rows.MANY = 2  # small shards are written, joined and removed all the time\n"
        "rows.join_small_shards = partial(rows.join_small_shards, many=2)\n"
        "runner.RowWriter = partial(runner.RowWriter, shard_rows=2)\n"
        f"runner.run_study(toy_study(trial=slow_toy_trial), {str(tmp_path / 'found')!r}, trials=100, "
        f"workers={workers}, resume=True)\n"
    )
    moments = random.Random(workers)
    for _ in range(5):
        before = set(tmp_path.glob("found/rows/*"))
        victim = subprocess.Popen([sys.executable, "-c", code], env={**os.environ, "OMP_NUM_THREADS": "1"})
        while not set(tmp_path.glob("found/rows/*")) - before:
            assert victim.poll() is None, "ended before it could be killed"
            time.sleep(0.001)
        time.sleep(moments.uniform(0.0, 0.3))
        victim.kill()
        victim.wait()
    summary = run_study(toy_study(), tmp_path / "found", trials=100, resume=True, **HERE)
    assert summary.found > 0
    assert summary.run > 0
    assert summary.found + summary.run == 400
    assert rows_of(tmp_path / "found").equals(rows_of(tmp_path / "expected"))


def test_workers_and_processes_that_are_killed_cost_no_trial(tmp_path, monkeypatch, caplog, expected):
    (tmp_path / "marks").mkdir()
    monkeypatch.setenv("TOY_MARKS", str(tmp_path / "marks"))
    get_reusable_executor().shutdown(wait=True)  # workers of earlier tests do not know this variable
    summary = run_study(toy_study(trial=killing_toy_trial), tmp_path / "out", workers=2)
    assert len(list((tmp_path / "marks").iterdir())) == 2 * 3  # seeds 1, 4 and 7: the worker, then the process
    assert summary.run == 32
    assert "workers were lost" in caplog.text
    assert rows_of(tmp_path / "out").equals(expected)


def test_workers_that_are_lost_without_end_end_the_run(tmp_path, monkeypatch):
    def lose(backend, calls):
        raise BrokenProcessPool("killed")
        yield

    monkeypatch.setattr(runner, "results", lose)
    with pytest.raises(StudyError, match="lost 5 times"):
        run_study(toy_study(), tmp_path, workers=2)


@pytest.mark.parametrize("trial", [lambda cell, seed, rng: {}, partial(toy_trial)])
def test_a_trial_that_workers_cannot_import_is_refused_before_anything_is_written(tmp_path, trial):
    with pytest.raises(StudyError, match="top of a module"):
        run_study(toy_study(trial=trial), tmp_path / "out", workers=2)
    assert not (tmp_path / "out").exists()


def test_a_resume_of_a_finished_run_does_nothing(tmp_path):
    run_study(toy_study(), tmp_path, **HERE)
    before = sorted((tmp_path / "rows").iterdir())
    summary = run_study(toy_study(), tmp_path, resume=True, **HERE)
    assert (summary.found, summary.run) == (32, 0)
    assert sorted((tmp_path / "rows").iterdir()) == before


def test_more_trials_are_added_to_those_that_are_there(tmp_path, expected):
    run_study(toy_study(), tmp_path, trials=3, **HERE)
    summary = run_study(toy_study(), tmp_path, trials=8, resume=True, **HERE)
    assert (summary.total, summary.found, summary.run) == (32, 12, 20)
    assert rows_of(tmp_path).equals(expected)


def test_progress_counts_up_to_the_end_and_knows_the_time_left(tmp_path):
    seen = []
    run_study(toy_study(), tmp_path, trials=2, progress=seen.append, **HERE)
    assert [progress.done for progress in seen] == list(range(9))
    assert {progress.total for progress in seen} == {8}
    assert seen[0].left_s is None
    assert seen[-1].left_s == 0.0
    assert all(progress.left_s > 0.0 for progress in seen[1:-1])


def test_a_grid_with_gaps_runs_the_trials_that_exist(tmp_path):
    study = toy_study(applies=lambda cell, seed: seed < (2 if cell["method"] == "bold" else 5))
    assert run_study(study, tmp_path, **HERE).total == 2 * (2 + 5)
    assert read_rows(tmp_path).num_rows == 14
    with pytest.raises(StudyError, match="no trial applies"):
        run_study(toy_study(applies=lambda cell, seed: False), tmp_path / "none", **HERE)


@pytest.mark.parametrize("wrong", [{"workers": 0}, {"backend": "pigeon"}, {"trials": 0}])
def test_what_cannot_run_writes_nothing(tmp_path, wrong):
    with pytest.raises(StudyError):
        run_study(toy_study(), tmp_path / "out", **wrong)
    assert not (tmp_path / "out").exists()
