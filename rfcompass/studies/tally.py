"""What a run says while it goes on and at its end."""

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from rfcompass.evaluation.records import TrialRecord


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


class Tally:
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
