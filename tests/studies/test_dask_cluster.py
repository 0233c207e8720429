"""A Dask cluster gives the rows that this machine gives; it starts once for all tests, with two worker processes."""

import pytest
from toy_study import hostile_toy_trial, killing_toy_trial, toy_study

from rfcompass.errors import StudyError
from rfcompass.studies.folder import read_rows
from rfcompass.studies.limits import TrialLimits
from rfcompass.studies.rows import stable_columns
from rfcompass.studies.runner import run_study

distributed = pytest.importorskip("distributed", reason="the extra dask is not installed")


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    marks = tmp_path_factory.mktemp("marks")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TOY_MARKS", str(marks))  # before the workers start, who inherit it
        with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
            yield cluster


def rows_on(out, study=None, **how):
    run_study(study or toy_study(), out, **how)
    return stable_columns(read_rows(out))


def test_rows_are_equal_on_loky_on_dask_and_in_this_process(tmp_path, cluster):
    limits = TrialLimits(seconds=60.0)  # so that the sequential one computes with one thread too
    dask = rows_on(tmp_path / "dask", backend="dask", scheduler=cluster.scheduler_address)
    assert dask.equals(rows_on(tmp_path / "loky", workers=2))
    assert dask.equals(rows_on(tmp_path / "sequential", backend="sequential", limits=limits))


def test_one_worker_of_a_cluster_of_its_own_is_enough(tmp_path):
    rows = rows_on(tmp_path / "dask", backend="dask", workers=1)
    assert rows.equals(rows_on(tmp_path / "loky", workers=1))


def test_killed_workers_cost_no_trial(tmp_path, cluster):
    study = toy_study(trial=killing_toy_trial)
    rows = rows_on(tmp_path / "dask", study, backend="dask", scheduler=cluster.scheduler_address)
    assert rows.equals(rows_on(tmp_path / "loky", workers=2))


def test_limits_hold_on_a_cluster(tmp_path, cluster):
    study = toy_study(trial=hostile_toy_trial, factors={"noise_m": (0.1,), "method": ("bold",)}, seeds=range(2, 6))
    limits = TrialLimits(seconds=3.0, megabytes=150.0)
    rows = rows_on(tmp_path, study, backend="dask", scheduler=cluster.scheduler_address, limits=limits)
    kinds = rows.column("failure_kind").to_pylist()
    assert kinds == ["timed_out", None, "out_of_memory", "process_died"]


@pytest.mark.parametrize(
    ("scheduler", "says"),
    [("nonsense", "is no address"), ("pigeon://a:1", "is no address"), ("tcp://127.0.0.1:9", "no Dask scheduler")],
)
def test_an_address_without_a_scheduler_is_refused_and_nothing_is_written(tmp_path, scheduler, says):
    with pytest.raises(StudyError, match=says) as caught:
        run_study(toy_study(), tmp_path / "out", backend="dask", scheduler=scheduler)
    assert caught.value.numbers["scheduler"] == scheduler
    assert not (tmp_path / "out").exists()
