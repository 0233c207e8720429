"""Reads that waited for a busy consumer get the time at which they arrived, not that at which they were taken."""

from hypothesis import given
from hypothesis import strategies as st

from rfcompass.recordings.sources.arrival import PROMPT_S, ArrivalClock

NOW_NS = 1_700_000_000_000_000_000
clocks_us = st.integers(0, 2**61)


@given(reader_us=clocks_us, behind_ns=st.integers(0, 10**9))
def test_a_read_that_is_taken_at_once_arrived_now_whatever_the_reader_believes(reader_us, behind_ns):
    clock = ArrivalClock()
    assert clock.arrival_ns(reader_us, NOW_NS, PROMPT_S) == NOW_NS
    assert clock.arrival_ns(reader_us - 1, NOW_NS + behind_ns, 0.0) == NOW_NS + behind_ns


@given(start_us=clocks_us, waits_ms=st.lists(st.integers(0, 5000), max_size=20))
def test_reads_that_waited_are_as_far_apart_as_on_the_clock_of_the_reader(start_us, waits_ms):
    clock, taken_ns = ArrivalClock(), NOW_NS + 5_000 * 10**6
    clock.arrival_ns(start_us, NOW_NS, 0.0)
    for wait_ms in sorted(waits_ms):
        arrival_ns = clock.arrival_ns(start_us + 1000 * wait_ms, taken_ns, 5.0)
        assert arrival_ns == NOW_NS + wait_ms * 10**6


@given(
    reads=st.lists(
        st.tuples(st.none() | clocks_us, st.integers(0, 10**10), st.floats(0.0, 9.0)), min_size=2, max_size=30
    )
)
def test_however_the_reader_s_clock_jumps_a_read_arrived_while_it_could_and_never_before_the_last(reads):
    clock, now_ns, last_ns = ArrivalClock(), NOW_NS, 0
    for reader_us, later_ns, unread_s in reads:
        now_ns += later_ns
        arrival_ns = clock.arrival_ns(reader_us, now_ns, unread_s)
        assert now_ns - unread_s * 1e9 - 1e3 <= arrival_ns <= now_ns  # a float64 resolves 256 ns here
        if reader_us is not None:
            assert arrival_ns >= last_ns
            last_ns = arrival_ns


def test_a_reader_without_a_clock_leaves_the_time_at_which_a_read_was_taken():
    assert ArrivalClock().arrival_ns(None, NOW_NS, 5.0) == NOW_NS


def test_a_host_clock_that_was_set_back_is_believed():
    clock = ArrivalClock()
    clock.arrival_ns(5, NOW_NS, 0.0)
    assert clock.arrival_ns(6, NOW_NS - 10**9, 0.5) == NOW_NS - 10**9
