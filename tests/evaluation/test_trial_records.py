import json
import pickle

import numpy as np

from rfcompass.errors import TooFewReads
from rfcompass.evaluation.records import TrialFailure, TrialRecord


def test_a_record_survives_the_trip_between_processes():
    failure = TrialFailure.of(TooFewReads("2 reads, 5 needed", reads=2, needed=5))
    record = TrialRecord("toy", {"noise": 0.1}, 7, {"error_m": 0.25}, failure, 0.5, "numpy 2")
    assert pickle.loads(pickle.dumps(record)) == record


def test_a_failure_keeps_the_numbers_of_our_errors():
    error = TooFewReads("few", epc="30AA", reads=np.int64(2), at_m=np.array([0.1, 0.2]))
    failure = TrialFailure.of(error)
    assert failure.kind == "TooFewReads"
    assert json.loads(failure.numbers) == {"epc": "30AA", "reads": 2, "at_m": [0.1, 0.2]}


def test_a_foreign_error_becomes_a_failure_too():
    assert TrialFailure.of(ZeroDivisionError("by zero")) == TrialFailure("ZeroDivisionError", "by zero", "{}")
