"""Runs a study: every trial that has no row yet, on as many workers as asked, and no trial twice."""

import logging
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import TypeAlias

import joblib
import numpy as np

from rfcompass.arrays import BoolArray
from rfcompass.errors import StudyError
from rfcompass.studies.backends import PROCESS_BACKENDS, lost_workers, parallel_backend, results
from rfcompass.studies.batch import Batch, Finished, Schedule, TrialWork
from rfcompass.studies.compaction import join_small_shards
from rfcompass.studies.folder import open_folder
from rfcompass.studies.limits import NO_LIMITS, TrialLimits
from rfcompass.studies.rows import RowWriter, finished_trials
from rfcompass.studies.study import Study
from rfcompass.studies.tally import Progress, ProgressCallback, RunSummary, Tally
from rfcompass.studies.trial import run_trial
from rfcompass.studies.trial_process import run_batch, stop_idle_processes

__all__ = ["Progress", "ProgressCallback", "RunSummary", "run_study"]

Run: TypeAlias = Callable[[Batch], Finished]

_LOSSES = 5  # times in a row that workers may be lost without a single row in between

_log = logging.getLogger(__name__)


def run_study(  # noqa: PLR0913  # what the command line offers
    study: Study,
    out: Path | str,
    *,
    trials: int | None = None,
    workers: int = 1,
    backend: str = "loky",
    scheduler: str | None = None,
    limits: TrialLimits = NO_LIMITS,
    resume: bool = False,
    progress: ProgressCallback | None = None,
) -> RunSummary:
    """Run the trials of a study and leave their rows in a folder.

    The rows do not depend on the number of workers, on the order of the trials or on interruptions: a trial draws
    all its random numbers from its own seed, and worker processes compute with one thread each, because the
    threads of a linear algebra library decide the last bits of a sum. An interrupted run (KeyboardInterrupt)
    keeps every row that has arrived; a killed one loses at most the last seconds, never a part of a file. Memory
    here grows with the number of trials by one truth value each. Where a worker is killed, its trials run again.

    Args:
        study: What to run.
        out: Folder for `study.json` and the shards in `rows/`.
        trials: Seeds for each cell; all that the study declares if None.
        workers: Number of worker processes; a cluster at an address uses all that it has.
        backend: `"loky"` for processes on this machine, `"dask"` or `"ray"` for a cluster, `"threading"` for threads,
            `"sequential"` for no worker at all (for debugging); the latter two compute in the calling process and
            with its threads, unless trials are limited.
        scheduler: Address of the cluster; one is started on this machine if None.
        limits: Time and memory of each trial. One that wants more is ended, and is a row with that failure.
        resume: Go on in a folder that holds rows of this study.
        progress: Called after each trial, and once before the first.

    Raises:
        StudyError: If the folder holds something else, workers, backend, scheduler or trials are not possible, the
            trial function cannot be imported by a worker, or workers are killed faster than they finish a trial.
        MissingExtra: If the cluster's software is not installed.
    """
    out = Path(out)
    seeds = study.first_seeds(trials)
    asked = _asked(study, seeds)
    run = _how(study, backend, limits)
    with parallel_backend(backend, workers, scheduler), _no_process_left():
        rows = open_folder(study, seeds, out, resume=resume)
        pending = asked & ~finished_trials(study, seeds, rows)
        tally = Tally(total=int(asked.sum()), found=int(asked.sum() - pending.sum()), progress=progress)
        schedule = Schedule(study, seeds, pending)
        with _writing(RowWriter(study, rows)) as writer, closing(_finished(schedule, run, backend)) as batches:
            for batch in batches:
                for number, record in zip(batch.numbers, batch.records, strict=True):
                    schedule.tick(number, record)
                    writer.add(record)
                    tally.count(record)
        join_small_shards(rows)
    return tally.summary(out)


def _asked(study: Study, seeds: Sequence[int]) -> BoolArray:
    """Tell which trials of the grid exist, shape (seeds, cells)."""
    cells = study.cells
    shape = (len(seeds), len(cells))
    if study.applies is None:
        return np.ones(shape, dtype=np.bool_)
    applies = study.applies
    each = (applies(cell, seed) for seed in seeds for cell in cells)
    exists: BoolArray = np.fromiter(each, dtype=np.bool_, count=shape[0] * shape[1]).reshape(shape)
    if not exists.any():
        raise StudyError(f"study {study.name}: no trial applies; is its data there?", study=study.name)
    return exists


def _how(study: Study, backend: str, limits: TrialLimits) -> Run:
    """Run batches in processes of their own, or right where they are asked for."""
    if backend in PROCESS_BACKENDS or limits:
        return partial(run_batch, TrialWork.of(study), limits)
    return partial(_run_here, study)


def _run_here(study: Study, batch: Batch) -> Finished:
    each = zip(batch.cells, batch.seeds, strict=True)
    records = (run_trial(study.name, study.trial, study.metrics, cell, seed) for cell, seed in each)
    return Finished(batch.numbers, tuple(records))


def _finished(schedule: Schedule, run: Run, backend: str) -> Generator[Finished, None, None]:
    """Run what is left and yield batches as they finish; begin anew with what is left where workers are lost."""
    work, losses = joblib.delayed(run), 0
    while schedule:
        try:
            with closing(results(backend, (work(batch) for batch in schedule.batches()))) as batches:
                for batch in batches:
                    losses = 0
                    yield batch
        except lost_workers() as error:
            losses += 1
            if losses == _LOSSES:
                raise StudyError(f"workers were lost {losses} times without a row in between: {error}") from error
            _log.warning("workers were lost, their trials run again: %s", error)


@contextmanager
def _writing(writer: RowWriter) -> Iterator[RowWriter]:
    """Write what has arrived at the end, be it reached or not."""
    try:
        yield writer
    finally:
        writer.flush()


@contextmanager
def _no_process_left() -> Iterator[None]:
    """Stop the trials' processes that this process has started itself; those of workers end with them."""
    try:
        yield
    finally:
        stop_idle_processes()
