import os
import subprocess
import sys

import numpy as np
import pytest

from rfcompass.studies.process_memory import ON_LINUX, at_most, resident_bytes


def test_a_process_holds_what_it_has_touched():
    before = resident_bytes(os.getpid())
    kept = np.ones(8_000_000)
    assert 50e6 < resident_bytes(os.getpid()) - before < 100e6
    assert kept.nbytes == 64e6


def test_a_process_that_is_gone_holds_nothing():
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    assert resident_bytes(ended.pid) == 0


@pytest.mark.skipif(not ON_LINUX, reason="macOS does not bind memory")
def test_linux_refuses_more_than_allowed_and_allows_it_again():
    with at_most(50_000_000):
        np.ones(1_000_000)
        with pytest.raises(MemoryError):
            np.ones(20_000_000)
    assert np.ones(20_000_000).nbytes == 160e6


def test_without_a_limit_nothing_is_refused():
    with at_most(None):
        assert np.ones(20_000_000).nbytes == 160e6
