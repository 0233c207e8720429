"""What happened on the way is counted, and memory stays bounded."""

import dataclasses
import json

from rfcompass.recordings.sources.link_log import Gap, LinkLog


def test_clocks_that_run_backwards_are_counted_apart(made_up_reads):
    log, (read,) = LinkLog(), made_up_reads(1)
    for t_ns, t_reader_us in ((10, 10), (9, 11), (20, 5), (20, None), (None, 1), (5, 1)):
        log.note_read(dataclasses.replace(read, t_ns=t_ns, t_reader_us=t_reader_us))
    assert log.host_clock_backwards == 1
    assert log.reader_clock_backwards == 1


def test_many_gaps_are_counted_in_full_and_listed_in_part():
    log = LinkLog()
    for k in range(1000):
        log.note_gap(Gap(k * 10**9, k * 10**9 + 500_000_000, "lost"))
    assert log.as_json()["gap_count"] == 1000
    assert log.as_json()["gap_s"] == 500.0
    assert len(log.gaps) == 100


def test_the_counts_are_json():
    log = LinkLog(received=3)
    log.dropped["no_phase"] += 2
    assert json.loads(json.dumps(log.as_json()))["dropped"] == {"no_phase": 2}


def test_no_connection_is_no_reconnect():
    assert LinkLog().as_json()["reconnects"] == 0
    assert LinkLog(connections=3).as_json()["reconnects"] == 2
