"""The process that runs trials for a worker: `python -m rfcompass.studies.trial_server DESCRIPTOR`.

It gets the work and the limits, then batches, over the connection of that descriptor, and sends back a record for
each trial. Its worker may kill it at any moment. It ends by itself when the worker is gone, when nothing comes for
a minute, and, by the kernel's alarm, when a trial takes longer than its worker would have allowed.
"""

import os
import queue
import signal
import sys
from dataclasses import replace
from multiprocessing.connection import Connection
from threading import Thread

from rfcompass.evaluation.records import TrialFailure, TrialRecord
from rfcompass.studies.batch import Batch, TrialWork
from rfcompass.studies.limits import OUT_OF_MEMORY, TrialLimits
from rfcompass.studies.process_memory import at_most
from rfcompass.studies.study import Trial
from rfcompass.studies.trial import run_trial

_IDLE_S = 60.0
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
    batches: queue.SimpleQueue[Batch] = queue.SimpleQueue()
    Thread(target=_receive, args=(connection, batches), daemon=True).start()
    signal.signal(signal.SIGALRM, signal.SIG_DFL)  # ends the process, also one that never comes back to Python
    while True:
        try:
            batch = batches.get(timeout=_IDLE_S)
        except queue.Empty:
            return
        _run(connection, work, trial, limits, batch)


def _receive(connection: Connection, batches: "queue.SimpleQueue[Batch]") -> None:
    try:
        while True:
            batches.put(connection.recv())
    except (EOFError, OSError):
        os._exit(0)  # nobody waits for the trial that runs


def _run(connection: Connection, work: TrialWork, trial: Trial, limits: TrialLimits, batch: Batch) -> None:
    alarm_s = 0.0 if limits.seconds is None else limits.seconds + _GRACE_S
    for cell, seed in zip(batch.cells, batch.seeds, strict=True):
        signal.setitimer(signal.ITIMER_REAL, alarm_s)
        with at_most(limits.bytes):
            record = run_trial(work.study, trial, work.metrics, cell, seed)
        connection.send(_named(record, limits))
    signal.setitimer(signal.ITIMER_REAL, 0.0)


def _named(record: TrialRecord, limits: TrialLimits) -> TrialRecord:
    """Give an allocation that the limit refused the failure that a worker writes where it sees the limit passed."""
    if limits.bytes is None or record.failure is None or record.failure.kind != OUT_OF_MEMORY:
        return record
    return replace(record, failure=limits.out_of_memory())


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
