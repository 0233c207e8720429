"""The process that runs trials for a worker: `python -m rfcompass.studies.trial_server DESCRIPTOR`.

It gets the work and the limits, then batches, over the connection of that descriptor, and sends back the records of
their trials: one by one where the worker wants to know which trial it is that goes wrong, else a few at a time, since
waking the worker for each short trial would cost more than all else.

Its worker may kill it at any moment. It ends by itself when the worker is gone, when nothing comes for a minute, and,
by the kernel's alarm, when a trial takes longer than its worker would have allowed.
"""

import os
import queue
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from multiprocessing.connection import Connection
from threading import Thread
from typing import TypeAlias

from rfcompass.evaluation.records import TrialFailure, TrialRecord
from rfcompass.studies.batch import BATCH_SECONDS, Batch, TrialWork
from rfcompass.studies.limits import OUT_OF_MEMORY, TrialLimits
from rfcompass.studies.process_memory import at_most
from rfcompass.studies.study import Trial
from rfcompass.studies.trial import run_trial

# A batch, and whether each of its records is to be sent at once.
Asked: TypeAlias = tuple[Batch, bool]

_IDLE_S = 60.0
SEND_S = BATCH_SECONDS  # records wait at most this long, and for the end of a trial
_GRACE_S = 5.0  # the worker's own clock comes first, and knows what to write down


def serve(connection: Connection) -> None:
    """Run trials until the other end closes the connection."""
    work, limits = connection.recv()
    try:
        trial = work.trial()
    except Exception as error:
        connection.send(TrialFailure.of(error))
        return
    connection.send(None)
    batches: queue.SimpleQueue[Asked] = queue.SimpleQueue()
    Thread(target=_receive, args=(connection, batches), daemon=True).start()
    signal.signal(signal.SIGALRM, signal.SIG_DFL)  # ends the process, also one that never comes back to Python
    while True:
        try:
            batch, one_by_one = batches.get(timeout=_IDLE_S)
        except queue.Empty:
            return
        finished: list[TrialRecord] = []
        sent_s = time.monotonic()
        for record in _records(work, trial, limits, batch):
            finished.append(record)
            if one_by_one or time.monotonic() - sent_s > SEND_S:
                connection.send(finished)
                finished, sent_s = [], time.monotonic()
        if finished:
            connection.send(finished)


def _receive(connection: Connection, batches: "queue.SimpleQueue[Asked]") -> None:
    try:
        while True:
            batches.put(connection.recv())
    except (EOFError, OSError):
        os._exit(0)  # nobody waits for the trial that runs


def _records(work: TrialWork, trial: Trial, limits: TrialLimits, batch: Batch) -> Iterator[TrialRecord]:
    alarm_s = 0.0 if limits.seconds is None else limits.seconds + _GRACE_S
    for cell, seed in zip(batch.cells, batch.seeds, strict=True):
        signal.setitimer(signal.ITIMER_REAL, alarm_s)
        with at_most(limits.bytes):
            record = run_trial(work.study, trial, work.metrics, cell, seed)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        yield _named(record, limits)


def _named(record: TrialRecord, limits: TrialLimits) -> TrialRecord:
    """Give an allocation that the limit refused the failure that a worker writes where it sees the limit passed."""
    if limits.bytes is None or record.failure is None or record.failure.kind != OUT_OF_MEMORY:
        return record
    return replace(record, failure=limits.out_of_memory())


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
