"""From a source to a trace: all of it or nothing, nothing lost, and the counts beside it."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest

from rfcompass.errors import LinkLost, NothingRecorded, TraceError
from rfcompass.recordings import CarrierLog, StillAntennas, TraceMeta, import_spool, open_trace, reads_table, record
from rfcompass.recordings.sources import SequenceSource
from rfcompass.types.reads import TagRead

META = TraceMeta(frame="hall", phase_modulus="pi")


def some_reads(count):
    rng = np.random.default_rng(5)
    return tuple(
        TagRead(
            f"aa{k % 3}", 1 + k % 2, 915.25e6, float(rng.uniform(-70, -40)), float(rng.uniform(0, 6)), t_ns=1000 * k
        )
        for k in range(count)
    )


class Breaking:
    """Gives reads, then fails."""

    def __init__(self, reads, error):
        self.reads, self.error = reads, error

    def __iter__(self):
        yield from SequenceSource(self.reads, 10)
        raise self.error

    def counts(self):
        return {"received": len(self.reads), "dropped": {"no_phase": 2}}


def test_a_recording_holds_the_reads_in_their_order(tmp_path):
    reads = some_reads(100)
    done = record(SequenceSource(reads, 7), tmp_path / "t", meta=META)
    trace = open_trace(tmp_path / "t")
    assert trace.reads.to_pylist() == reads_table(reads).to_pylist()
    assert (done.reads, done.epcs) == (100, ("aa0", "aa1", "aa2"))
    assert trace.antenna_poses.antennas.tolist() == [1, 2]
    assert trace.meta.frame == "hall"
    assert [entry.name for entry in tmp_path.iterdir()] == ["t"]


def test_columns_that_no_read_fills_are_left_out(tmp_path):
    record(SequenceSource(some_reads(5)), tmp_path / "t", meta=META)
    assert "doppler_hz" not in open_trace(tmp_path / "t").reads.column_names


def test_the_file_is_written_in_groups_so_that_memory_stays_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr("rfcompass.recordings.spool_trace._GROUP_READS", 200)
    record(SequenceSource(some_reads(1000), 50), tmp_path / "t", meta=META)
    assert pq.ParquetFile(tmp_path / "t" / "reads.parquet").num_row_groups >= 5
    assert open_trace(tmp_path / "t").reads.num_rows == 1000


def test_the_counts_are_stored_beside_the_reads_and_survive_rewriting(tmp_path):
    done = record(Breaking(some_reads(20), LinkLost("gone")), tmp_path / "t", meta=META)
    stored = json.loads(open_trace(tmp_path / "t").meta.unknown_json)["recording"]
    assert stored == done.counts
    assert stored["written"] == 20
    assert stored["dropped"] == {"no_phase": 2}
    assert stored["ended"] == "LinkLost: gone"


def test_an_interruption_keeps_what_was_heard(tmp_path):
    done = record(Breaking(some_reads(20), KeyboardInterrupt()), tmp_path / "t", meta=META)
    assert (done.reads, done.counts["ended"]) == (20, "stopped")


def test_a_source_that_fails_before_its_first_read_leaves_nothing(tmp_path):
    with pytest.raises(LinkLost):
        record(Breaking((), LinkLost("gone")), tmp_path / "t", meta=META)
    assert list(tmp_path.iterdir()) == []


def test_a_source_without_a_read_is_no_answer_with_its_counts(tmp_path):
    with pytest.raises(NothingRecorded, match="no_phase 2") as caught:
        record(Breaking((), KeyboardInterrupt()), tmp_path / "t", meta=META)
    assert caught.value.numbers["dropped"] == {"no_phase": 2}
    assert list(tmp_path.iterdir()) == []


def test_a_bug_in_the_source_leaves_the_spool(tmp_path):
    with pytest.raises(ZeroDivisionError):
        record(Breaking(some_reads(20), ZeroDivisionError()), tmp_path / "t", meta=META)
    assert import_spool(tmp_path / "t.recording").reads.num_rows == 20
    with pytest.raises(TraceError, match="did not end"):
        record(SequenceSource(some_reads(1)), tmp_path / "t", meta=META)


def test_a_trace_that_is_there_is_replaced_on_request_only(tmp_path):
    record(SequenceSource(some_reads(5)), tmp_path / "t", meta=META)
    with pytest.raises(TraceError):
        record(SequenceSource(some_reads(6)), tmp_path / "t", meta=META)
    record(SequenceSource(some_reads(6)), tmp_path / "t", meta=META, overwrite=True)
    assert open_trace(tmp_path / "t").reads.num_rows == 6


def test_what_is_no_trace_is_never_replaced(tmp_path):
    (tmp_path / "thesis.tex").write_text("do not lose")
    with pytest.raises(TraceError):
        record(SequenceSource(some_reads(5)), tmp_path, meta=META, overwrite=True)
    assert [entry.name for entry in tmp_path.iterdir()] == ["thesis.tex"]


def test_meta_and_carriage_are_asked_for_when_they_are_known(tmp_path):
    order = []

    class Late:
        def __iter__(self):
            order.append("first read")
            yield some_reads(2)
            order.append("last read")

    def meta():
        order.append("meta")
        return META

    def carriage():
        order.append("carriage")
        return StillAntennas({1: np.array([1.0, 2.0, 3.0])})

    record(Late(), tmp_path / "t", meta=meta, carriage=carriage)
    assert order == ["first read", "meta", "last read", "carriage"]
    assert open_trace(tmp_path / "t").antenna_poses.positions_m.tolist() == [[1, 2, 3]]


def test_reads_of_a_port_without_a_place_are_dropped_and_counted_rather_than_put_at_the_origin(tmp_path):
    def of_port_2():
        return StillAntennas({2: np.array([0.0, 0.0, 1.0])})

    done = record(SequenceSource(some_reads(10)), tmp_path / "t", meta=META, carriage=of_port_2)
    assert (done.reads, done.counts["dropped"]) == (5, {"no_place": 5})
    assert open_trace(tmp_path / "t").antenna_poses.antennas.tolist() == [2]


def test_reads_get_the_place_that_the_carrier_had_when_they_came(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("t_ns,antenna,x_m,y_m,z_m\n10000,1,0,0,0\n60000,1,0.5,0,0\n10000,2,0,1,0\n60000,2,0.5,1,0\n")
    done = record(SequenceSource(some_reads(100)), tmp_path / "t", meta=META, carriage=lambda: CarrierLog.read(log))
    trace = open_trace(tmp_path / "t")
    assert done.counts["dropped"] == {"no_place": 49}
    poses = trace.antenna_poses
    rows = poses.rows_of(trace.reads["pose_id"].to_numpy(), trace.reads["antenna"].to_numpy().astype(np.int64))
    np.testing.assert_allclose(
        poses.positions_m[rows][:, 0], (trace.reads["t_ns"].to_numpy() - 10_000) / 1e5, atol=0.0025 + 1e-9
    )
    assert poses.positions_m[rows][:, 1].tolist() == [float(k % 2) for k in range(10, 61)]


@pytest.mark.parametrize("log_text", ["t_ns,antenna,x_m,y_m,z_m\n5,1,0,0,0\n4,1,0,0,0\n", None])
def test_a_carrier_log_that_is_unusable_costs_no_read(tmp_path, log_text):
    if log_text is not None:
        (tmp_path / "log.csv").write_text(log_text)
    with pytest.raises(TraceError, match="kept in"):
        record(
            SequenceSource(some_reads(9)),
            tmp_path / "t",
            meta=META,
            carriage=lambda: CarrierLog.read(tmp_path / "log.csv"),
        )
    assert import_spool(tmp_path / "t.recording").reads.num_rows == 9


def test_a_carrier_log_of_another_day_costs_no_read(tmp_path):
    (tmp_path / "log.csv").write_text("t_ns,antenna,x_m,y_m,z_m\n5000000,1,0,0,0\n6000000,1,0,0,0\n")
    with pytest.raises(NothingRecorded, match="kept in") as caught:
        record(
            SequenceSource(some_reads(9)),
            tmp_path / "t",
            meta=META,
            carriage=lambda: CarrierLog.read(tmp_path / "log.csv"),
        )
    assert caught.value.numbers["dropped"] == {"no_place": 9}
    assert import_spool(caught.value.numbers["spool"]).reads.num_rows == 9
