import json
import os
import sys

import joblib
import pytest
from toy_study import short_work, surroundings_trial, toy_study

from rfcompass.errors import MissingExtra, StudyError
from rfcompass.studies.backends import KNOWN, parallel_backend, results
from rfcompass.studies.folder import read_rows
from rfcompass.studies.metric import Metric
from rfcompass.studies.runner import run_study


def surroundings(out, **how):
    study = toy_study(trial=surroundings_trial, metrics=(Metric("remark", column="text"),), paper=(), seeds=range(5))
    run_study(study, out, **how)
    return [json.loads(text) for text in read_rows(out).column("remark").to_pylist()]


def test_one_worker_runs_trials_in_one_process_of_its_own_with_one_thread(tmp_path):
    seen = surroundings(tmp_path)
    assert len({one["process"] for one in seen}) == 1
    assert seen[0]["process"] != os.getpid()
    assert {one[name] for one in seen for name in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS")} == {"1"}


def test_two_workers_are_two_processes(tmp_path):
    processes = {one["process"] for one in surroundings(tmp_path, workers=2)}
    assert 1 <= len(processes - {os.getpid()}) <= 2


def test_sequential_stays_in_this_process(tmp_path):
    assert {one["process"] for one in surroundings(tmp_path, backend="sequential", workers=3)} == {os.getpid()}


@pytest.mark.parametrize("backend", ["sequential", "threading"])
def test_calls_are_taken_when_there_is_room(backend):
    taken = []

    def calls():
        for number in range(1000):
            taken.append(number)
            yield joblib.delayed(short_work)(number)

    with parallel_backend(backend, 2):
        found = results(backend, calls())
        next(found)
        assert len(taken) < 20
        found.close()


def test_a_backend_that_cannot_be_is_refused():
    with pytest.raises(StudyError, match="known: loky"):
        parallel_backend("pigeon", 1)
    with pytest.raises(StudyError, match="at least 1"):
        parallel_backend("loky", 0)
    with pytest.raises(StudyError, match="loky has no scheduler"):
        parallel_backend("loky", 1, "tcp://192.0.2.7:8786")
    assert {"loky", "dask", "ray"} < set(KNOWN)


@pytest.mark.parametrize(("backend", "package"), [("dask", "distributed"), ("ray", "ray")])
def test_a_missing_extra_is_named_and_nothing_is_written(tmp_path, monkeypatch, backend, package):
    monkeypatch.setitem(sys.modules, package, None)
    monkeypatch.delitem(sys.modules, f"rfcompass.studies.{backend}_cluster", raising=False)
    with pytest.raises(MissingExtra, match=rf"rfcompass\[{backend}\]") as caught:
        run_study(toy_study(), tmp_path / "out", backend=backend)
    assert caught.value.numbers["extra"] == backend
    assert not (tmp_path / "out").exists()
