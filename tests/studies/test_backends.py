import os

import joblib
import pytest

from rfcompass.errors import StudyError
from rfcompass.studies.backends import parallel_backend


def process_and_threads(_):
    return os.getpid(), os.environ.get("OMP_NUM_THREADS")


def test_one_worker_is_one_process_of_its_own_with_one_thread():
    with parallel_backend("loky", 1):
        seen = set(joblib.Parallel()(joblib.delayed(process_and_threads)(k) for k in range(20)))
    assert len(seen) == 1
    process, threads = seen.pop()
    assert process != os.getpid()
    assert threads == "1"


def test_sequential_stays_in_this_process():
    with parallel_backend("sequential", 3):
        assert joblib.Parallel()(joblib.delayed(os.getpid)() for _ in range(2)) == [os.getpid()] * 2


def test_a_backend_that_does_not_exist_is_refused():
    with pytest.raises(StudyError, match="known: loky"):
        parallel_backend("pigeon", 1)
    with pytest.raises(StudyError, match="at least 1"):
        parallel_backend("loky", 0)
