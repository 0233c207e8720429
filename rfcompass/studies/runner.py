"""Runs a study: every trial that has no row yet, on as many workers as asked, and no trial twice."""

import time
import warnings
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeAlias

import joblib
import numpy as np

from rfcompass.arrays import BoolArray
from rfcompass.errors import StudyError
from rfcompass.evaluation.records import TrialRecord
from rfcompass.studies.backends import parallel_backend
from rfcompass.studies.folder import open_folder
from rfcompass.studies.rows import RowWriter, finished_trials
from rfcompass.studies.study import Study
from rfcompass.studies.trial import run_trial


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a run is.

    Attributes:
        done: Trials that have a row, also from earlier runs.
        total: Trials that are asked for.
        failed: Trials of this run that failed.
        elapsed_s: Time since this run began [s].
        left_s: Time left at the mean pace so far [s]; None before the first trial.
    """

    done: int
    total: int
    failed: int
    elapsed_s: float
    left_s: float | None


@dataclass(frozen=True, slots=True)
class RunSummary:
    """What a run did.

    Attributes:
        out: Folder of the rows.
        total: Trials that were asked for.
        found: Trials that had a row before.
        run: Trials of this run.
        failures: Number of failed trials of this run, by kind.
        elapsed_s: Time it took [s].
    """

    out: Path
    total: int
    found: int
    run: int
    failures: dict[str, int]
    elapsed_s: float


ProgressCallback: TypeAlias = Callable[[Progress], object]


def run_study(
    study: Study,
    out: Path | str,
    *,
    trials: int | None = None,
    workers: int = 1,
    backend: str = "loky",
    resume: bool = False,
    progress: ProgressCallback | None = None,
) -> RunSummary:
    """Run the trials of a study and leave their rows in a folder.

    The rows do not depend on the number of workers, on the order of the trials or on interruptions: a trial draws
    all its random numbers from its own seed, and worker processes compute with one thread each, because the
    threads of a linear algebra library decide the last bits of a sum. An interrupted run (KeyboardInterrupt)
    keeps every row that has arrived; a killed one loses at most the last seconds, never a part of a file.

    Args:
        study: What to run.
        out: Folder for `study.json` and the shards in `rows/`.
        trials: Seeds for each cell; all that the study declares if None.
        workers: Number of worker processes.
        backend: `"loky"` for processes on this machine, `"threading"` for threads, `"sequential"` for no worker at
            all (for debugging); the latter two compute with the threads of the calling process.
        resume: Go on in a folder that holds rows of this study.
        progress: Called after each trial, and once before the first.

    Raises:
        StudyError: If the folder holds something else, or workers, backend or trials are not possible.
    """
    out = Path(out)
    seeds = study.first_seeds(trials)
    asked = _asked(study, seeds)
    with parallel_backend(backend, workers):
        rows = open_folder(study, seeds, out, resume=resume)
        pending = asked & ~finished_trials(study, seeds, rows)
        tally = _Tally(total=int(asked.sum()), found=int(asked.sum() - pending.sum()), progress=progress)
        with _writing(RowWriter(study, rows)) as writer, _stopping(_records(study, seeds, pending)) as records:
            for record in records:
                writer.add(record)
                tally.count(record)
    return tally.summary(out)


class _Tally:
    """Counts what comes in and tells whoever wants to know."""

    def __init__(self, total: int, found: int, progress: ProgressCallback | None) -> None:
        self._total, self._found, self._progress = total, found, progress
        self._start = time.monotonic()
        self._run = 0
        self._failures: Counter[str] = Counter()
        self._tell()

    def count(self, record: TrialRecord) -> None:
        """Count one more trial."""
        self._run += 1
        if record.failure is not None:
            self._failures[record.failure.kind] += 1
        self._tell()

    def summary(self, out: Path) -> RunSummary:
        """Sum up at the end."""
        return RunSummary(
            out, self._total, self._found, self._run, dict(sorted(self._failures.items())), self._elapsed()
        )

    def _tell(self) -> None:
        if self._progress is not None:
            done, elapsed = self._found + self._run, self._elapsed()
            left = elapsed / self._run * (self._total - done) if self._run else None
            self._progress(Progress(done, self._total, self._failures.total(), elapsed, left))

    def _elapsed(self) -> float:
        return time.monotonic() - self._start


def _asked(study: Study, seeds: Sequence[int]) -> BoolArray:
    """Tell which trials of the grid exist, shape (seeds, cells)."""
    if study.applies is None:
        return np.ones((len(seeds), len(study.cells)), dtype=np.bool_)
    exists = np.array([[study.applies(cell, seed) for cell in study.cells] for seed in seeds], dtype=np.bool_)
    if not exists.any():
        raise StudyError(f"study {study.name}: no trial applies; is its data there?", study=study.name)
    return exists


def _records(study: Study, seeds: Sequence[int], pending: BoolArray) -> Generator[TrialRecord, None, None]:
    """Run the pending trials, all cells of a seed before the next seed, and yield them as they finish."""
    work = joblib.delayed(partial(run_trial, study.name, study.trial, study.metrics))
    cells = study.cells
    calls = (work(cells[cell], seeds[place]) for place in range(len(seeds)) for cell in np.flatnonzero(pending[place]))
    yield from joblib.Parallel(return_as="generator_unordered")(calls)


@contextmanager
def _stopping(records: Generator[TrialRecord, None, None]) -> Iterator[Generator[TrialRecord, None, None]]:
    """Stop the workers at the end, be it reached or not."""
    try:
        yield records
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # joblib's, that trials under way are lost: so is an interrupt
            records.close()


@contextmanager
def _writing(writer: RowWriter) -> Iterator[RowWriter]:
    """Write what has arrived at the end, be it reached or not."""
    try:
        yield writer
    finally:
        writer.flush()
