"""What travels between the runner and its workers: the study's part of the work once, and trials in batches."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module

import numpy as np

from rfcompass.arrays import BoolArray
from rfcompass.errors import StudyError
from rfcompass.evaluation.records import TrialRecord
from rfcompass.studies.metric import Metric
from rfcompass.studies.study import Cell, Study, Trial

# Ours: a batch takes about this long, so that what it costs to send one is small and what a kill loses too.
BATCH_SECONDS = 0.25
BATCH_TRIALS = 1000

_PACE = 0.3  # weight of the newest trial in what the next one of its cell is expected to take


@dataclass(frozen=True, slots=True)
class TrialWork:
    """What a worker needs to know of a study; the trial function goes by its name, and is imported there.

    Attributes:
        study: Name of the study.
        module: Module of the trial function.
        function: Its name in there.
        metrics: What it must return.
    """

    study: str
    module: str
    function: str
    metrics: tuple[Metric, ...]

    @classmethod
    def of(cls, study: Study) -> "TrialWork":
        """Take from a study what can travel.

        Raises:
            StudyError: If another process could not import the trial function.
        """
        module = getattr(study.trial, "__module__", None)
        function = getattr(study.trial, "__qualname__", None)
        work = cls(study.name, str(module), str(function), study.metrics)
        if module == "__main__" or "<" in str(function) or _found(work) is not study.trial:
            raise StudyError(
                f"study {study.name}: worker processes import the trial function by its name, and there is none "
                f"at {module}.{function}; define it at the top of a module",
                study=study.name,
            )
        return work

    def trial(self) -> Trial:
        """Import the trial function."""
        found: Trial = getattr(import_module(self.module), self.function)
        return found


@dataclass(frozen=True, slots=True)
class Batch:
    """Some trials, run one after the other by one worker; all three have one entry for each.

    Attributes:
        numbers: Number of the trial in the grid, all cells of a seed before the next seed.
        cells: Its cell.
        seeds: Its seed.
    """

    numbers: tuple[int, ...]
    cells: tuple[Cell, ...]
    seeds: tuple[int, ...]

    def __len__(self) -> int:
        """Return the number of trials."""
        return len(self.numbers)

    def after(self, done: int) -> "Batch":
        """Return the rest after the first few trials."""
        return Batch(self.numbers[done:], self.cells[done:], self.seeds[done:])


@dataclass(frozen=True, slots=True)
class Finished:
    """A batch that has been run: the number and the record of each trial."""

    numbers: tuple[int, ...]
    records: tuple[TrialRecord, ...]


class Schedule:
    """Which trials are still to run, cut into batches of about the same time.

    Memory is one truth value for each trial. Trials of one cell tend to take the same time, so that each cell has
    an expectation of its own, and a trial of a cell that was never tried counts as a whole batch.

    Args:
        study: The study.
        seeds: Seeds that are asked for.
        pending: Trials to run, shape (seeds, cells); ticked off as they finish.
    """

    def __init__(self, study: Study, seeds: Sequence[int], pending: BoolArray) -> None:
        self._cells, self._seeds, self._pending = study.cells, seeds, pending
        self._expected_s = np.full(len(self._cells), math.nan)

    def __bool__(self) -> bool:
        """Tell whether there is anything left."""
        return bool(self._pending.any())

    def batches(self) -> Iterator[Batch]:
        """Cut the trials that are left now into batches, each only when it is asked for."""
        numbers: list[int] = []
        expected_s = 0.0
        for number in self._numbers():
            trial_s = self._expectation_s(number)
            if numbers and (expected_s + trial_s > BATCH_SECONDS or len(numbers) == BATCH_TRIALS):
                yield self._batch(numbers)
                numbers, expected_s = [], 0.0
            numbers.append(number)
            expected_s += trial_s
        if numbers:
            yield self._batch(numbers)

    def tick(self, number: int, record: TrialRecord) -> None:
        """Tick off a trial and learn from its time."""
        self._pending.flat[number] = False
        cell = number % len(self._cells)
        before_s = self._expected_s[cell]
        newest_s = record.runtime_s
        self._expected_s[cell] = (
            newest_s if math.isnan(before_s) else before_s + _PACE * (newest_s - before_s)
        )  # fmt: skip

    def _numbers(self) -> Iterator[int]:
        for place in np.flatnonzero(self._pending.any(axis=1)):
            for cell in np.flatnonzero(self._pending[place]):
                yield int(place) * len(self._cells) + int(cell)

    def _expectation_s(self, number: int) -> float:
        expected_s = float(self._expected_s[number % len(self._cells)])
        return BATCH_SECONDS if math.isnan(expected_s) else expected_s

    def _batch(self, numbers: Sequence[int]) -> Batch:
        places = [divmod(number, len(self._cells)) for number in numbers]
        cells = tuple(self._cells[cell] for _, cell in places)
        return Batch(tuple(numbers), cells, tuple(self._seeds[place] for place, _ in places))


def _found(work: TrialWork) -> object:
    try:
        return work.trial()
    except (ImportError, AttributeError):
        return None
