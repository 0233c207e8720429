"""Reads that are there already come out as they went in."""

import dataclasses
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError
from rfcompass.recordings import AntennaPoses, Trace, TraceMeta, reads_table
from rfcompass.recordings.sources import Pace, SequenceSource, TraceSource


@given(count=st.integers(0, 40), size=st.integers(1, 50))
def test_batches_keep_the_order_and_lose_nothing(made_up_reads, count, size):
    reads = made_up_reads(count)
    batches = list(SequenceSource(reads, size))
    assert [read for batch in batches for read in batch] == list(reads)
    assert all(0 < len(batch) <= size for batch in batches)


def test_a_trace_gives_back_the_reads_it_was_made_of(made_up_reads):
    reads = made_up_reads(30, antennas=1)
    trace = Trace(TraceMeta(frame="rail"), reads_table(reads), AntennaPoses.along(np.zeros((1, 3))))
    assert [read for batch in TraceSource(trace, 7) for read in batch] == list(reads)


@pytest.mark.parametrize("phase_sign", [1, -1])
def test_a_trace_of_i_and_q_gives_reads_of_the_same_channel(phase_sign):
    h = np.array([0.3 - 0.4j, -1e-3 + 2e-3j])
    rows = {"epc": ["aa", "bb"], "antenna": [1, 1], "freq_hz": [9e8] * 2, "pose_id": [0, 0]}
    table = reads_table(()).from_pydict({**rows, "i": h.real.tolist(), "q": h.imag.tolist()})
    trace = Trace(TraceMeta(frame="rail", phase_sign=phase_sign), table, AntennaPoses.along(np.zeros((1, 3))))
    (batch,) = TraceSource(trace)
    again = [10 ** (read.rssi_dbm / 20) * np.exp(-1j * phase_sign * read.phase_rad) for read in batch]
    np.testing.assert_allclose(again, h, rtol=1e-12)
    assert [complex(read.i, read.q) for read in batch] == list(h)


def test_a_pace_makes_the_replay_take_its_time(made_up_reads):
    start_s = time.monotonic()
    batches = list(SequenceSource(made_up_reads(40), pace=Pace(reads_per_s=200.0)))
    assert time.monotonic() - start_s >= 40 / 200.0
    assert max(map(len, batches)) <= 20


@pytest.mark.parametrize("rate", [0.0, -1.0, np.nan, np.inf])
def test_a_rate_that_is_none_is_refused(rate):
    with pytest.raises(InputError):
        Pace(reads_per_s=rate)


def test_an_empty_batch_size_is_refused(made_up_reads):
    with pytest.raises(InputError):
        dataclasses.replace(SequenceSource(made_up_reads(1)), batch_reads=0)
