"""Runs trials in a process of their own, so that none can stop, hang or starve the worker that wants its record.

A Python signal or thread cannot end a trial that hangs in compiled code, and a crash takes its process along. So the
worker only watches: it sends a batch, waits for the records, and kills the process where one is late or takes too
much memory. The process always computes with one thread, whatever the machine of the worker is set to.
"""

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from rfcompass.errors import StudyError
from rfcompass.evaluation.records import TrialFailure, TrialRecord
from rfcompass.studies.batch import Batch, Finished, TrialWork
from rfcompass.studies.limits import NO_LIMITS, TrialLimits
from rfcompass.studies.process_memory import LOOK_SECONDS, resident_bytes
from rfcompass.studies.trial_server import SEND_S
from rfcompass.studies.versions import software_versions

PROCESS_DIED = "process_died"

_SERVER = "rfcompass.studies.trial_server"
_THREADS = ("OMP", "OPENBLAS", "MKL", "BLIS", "NUMBA", "NUMEXPR")
_ONE_THREAD = {**{f"{name}_NUM_THREADS": "1" for name in _THREADS}, "VECLIB_MAXIMUM_THREADS": "1"}
_START_S = 600.0  # importing everything on a loaded machine with a cold file system
_TRIES = 2  # a process that ends under the same trial once was unlucky, twice is the trial's doing

_idle: list["TrialProcess"] = []


def run_batch(work: TrialWork, limits: TrialLimits, batch: Batch) -> Finished:
    """Run some trials in a process of their own and give a record for each, whatever happens to the process.

    Args:
        work: The study's part.
        limits: Limits of each trial.
        batch: The trials.

    Raises:
        StudyError: If the process cannot be started, or cannot import the trial.
    """
    records: list[TrialRecord] = []
    one_by_one, deaths = False, 0
    while len(records) < len(batch):
        rest = batch.after(len(records))
        one_by_one = one_by_one or len(rest) == 1
        with _lent(work, limits) as process:
            for some in process.records(rest, one_by_one=one_by_one):
                records += some
                deaths = 0
        if process.ended is None:
            break
        if not one_by_one:
            one_by_one = True  # any trial since the last record may have been the one: find out which
            continue
        deaths += process.ended.kind == PROCESS_DIED
        if process.ended.kind != PROCESS_DIED or deaths == _TRIES:
            place, deaths = len(records), 0
            cell, seed, versions = batch.cells[place], batch.seeds[place], software_versions()
            records.append(TrialRecord(work.study, cell, seed, {}, process.ended, process.waited_s, versions))
    return Finished(batch.numbers, tuple(records))


def stop_idle_processes() -> None:
    """Stop the processes that wait for the next batch; they would end by themselves after a minute."""
    while (process := _next_idle()) is not None:
        process.stop()


class TrialProcess:
    """One process that runs trials of one study.

    Attributes:
        ended: Why it ended, or None while it lives.
        waited_s: How long the newest record has been waited for [s].
    """

    def __init__(self, work: TrialWork, limits: TrialLimits) -> None:
        self.ended: TrialFailure | None = None
        self.waited_s = 0.0
        self._asked = (work, limits)
        self._limits = limits
        self._connection, theirs = multiprocessing.Pipe()
        with theirs:
            self._process = subprocess.Popen(  # noqa: S603  # our own module
                [sys.executable, "-P", "-m", _SERVER, str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=2,  # stdout is the report's
                env=_environment(),
                process_group=0,  # so that all it starts can be killed with it
            )
        self._start()
        self._baseline_bytes = resident_bytes(self._process.pid) if limits.bytes else 0

    def serves(self, work: TrialWork, limits: TrialLimits) -> bool:
        """Tell whether it can run this work: it lives, and trials before have left nothing big behind."""
        if (work, limits) != self._asked or self._process.poll() is not None:
            return False
        return limits.bytes is None or self._held_bytes() < self._baseline_bytes + limits.bytes

    def records(self, batch: Batch, *, one_by_one: bool) -> Iterator[list[TrialRecord]]:
        """Run a batch and yield the records of its trials, fewer if the process ends; then `ended` says why.

        Args:
            batch: The trials.
            one_by_one: Ask for each record as soon as there is one, so that it is known which trial runs.
        """
        held_bytes = self._held_bytes() if self._limits.bytes else 0
        with suppress(OSError):  # it ended while idle: the first answer says so
            self._connection.send((batch, one_by_one))
        left = len(batch)
        while left:
            some = self._next(held_bytes, 0.0 if one_by_one else SEND_S)
            if some is None:
                return
            left -= len(some)
            yield some

    def stop(self) -> None:
        """Kill the process with all that it has started."""
        with suppress(ProcessLookupError, PermissionError):  # macOS's word for a group of zombies
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        self._connection.close()

    def _start(self) -> None:
        self._connection.send(self._asked)
        try:
            problem = self._connection.recv() if self._connection.poll(_START_S) else "took too long to start"
        except (EOFError, OSError):
            problem = "ended before it began"
        if problem is not None:
            self.stop()
            work = self._asked[0]
            said = f"{problem.kind}: {problem.message}" if isinstance(problem, TrialFailure) else problem
            raise StudyError(
                f"study {work.study}: the process for {work.module}.{work.function} failed: {said}", study=work.study
            )

    def _next(self, held_bytes: int, patience_s: float) -> list[TrialRecord] | None:
        """Wait for some records; None if the process ended instead."""
        start = time.monotonic()
        try:
            while not self._connection.poll(self._look_s(patience_s + start - time.monotonic())):
                self.waited_s = time.monotonic() - start
                if (failure := self._broken_limit(held_bytes, patience_s)) is not None:
                    self.stop()
                    self.ended = failure
                    return None
            some: list[TrialRecord] = self._connection.recv()
        except (EOFError, OSError):
            self.waited_s = time.monotonic() - start
            self.stop()
            self.ended = self._death()
            return None
        return some

    def _look_s(self, patience_s: float) -> float | None:
        """How long to wait before the next look at the limits, None for ever [s]."""
        left_s = None if self._limits.seconds is None else max(0.0, self._limits.seconds + patience_s)
        if self._limits.bytes is None:
            return left_s
        return LOOK_SECONDS if left_s is None else min(left_s, LOOK_SECONDS)

    def _broken_limit(self, held_bytes: int, patience_s: float) -> TrialFailure | None:
        limits = self._limits
        if limits.seconds is not None and self.waited_s >= limits.seconds + patience_s:
            return limits.timed_out()
        if limits.bytes is not None and self._held_bytes() > held_bytes + limits.bytes:
            return limits.out_of_memory()
        return None

    def _death(self) -> TrialFailure:
        code = self._process.returncode
        if code == -signal.SIGALRM and self._limits.seconds is not None:
            return self._limits.timed_out()  # this worker slept longer than the trial may
        if code < 0:
            name = signal.Signals(-code).name
            return TrialFailure(PROCESS_DIED, f"its process ended twice, by {name}", json.dumps({"signal": name}))
        return TrialFailure(PROCESS_DIED, f"its process exited twice, with {code}", json.dumps({"exit_code": code}))

    def _held_bytes(self) -> int:
        return resident_bytes(self._process.pid)


@contextmanager
def _lent(work: TrialWork, limits: TrialLimits = NO_LIMITS) -> Iterator[TrialProcess]:
    """Lend a process, one that is idle if there is, and take it back unless it ended or was left half-way."""
    process = _taken(work, limits)
    try:
        yield process
    except BaseException:
        process.stop()
        raise
    if process.ended is None:
        _idle.append(process)


def _taken(work: TrialWork, limits: TrialLimits) -> TrialProcess:
    while (process := _next_idle()) is not None:
        if process.serves(work, limits):
            return process
        process.stop()
    return TrialProcess(work, limits)


def _next_idle() -> TrialProcess | None:
    try:
        return _idle.pop()  # at once, for a worker may have several threads
    except IndexError:
        return None


def _environment() -> dict[str, str]:
    """The worker's environment with one thread for each library, and its search path: what it can import, they can."""
    path = os.pathsep.join(place or os.getcwd() for place in sys.path)  # noqa: PTH109  # a string is wanted
    return {**os.environ, **_ONE_THREAD, "PYTHONPATH": path}
