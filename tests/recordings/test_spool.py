"""A spool is worth as much as it holds, however its writer ended."""

import dataclasses
import json

import pytest

from rfcompass.errors import NothingRecorded, TraceError
from rfcompass.recordings import TraceMeta, import_spool
from rfcompass.recordings.spool import SpoolWriter, check_no_spool, spooled_meta, spooled_reads
from rfcompass.types.reads import TagRead

READS = tuple(TagRead("aa", 1, 915e6 + k, -50.0, 0.001 * k, t_ns=k) for k in range(60))
META = TraceMeta(frame="hall", phase_modulus="pi")


def written(folder, batches=6):
    with SpoolWriter(folder, META) as spool:
        for first in range(0, 60, 60 // batches):
            spool.write(READS[first : first + 60 // batches])
    return folder


def times(folder):
    return [t_ns for batch in spooled_reads(folder) for t_ns in batch.column("t_ns").to_pylist()]


def test_what_was_written_is_there(tmp_path):
    folder = written(tmp_path / "a.recording")
    assert times(folder) == list(range(60))
    assert spooled_meta(folder) == META


def test_a_batch_can_be_read_before_the_spool_is_closed(tmp_path):
    spool = SpoolWriter(tmp_path / "a.recording", META)
    spool.write(READS[:10])
    assert times(tmp_path / "a.recording") == list(range(10))
    spool.write(())
    spool.write(READS[10:11])
    assert times(tmp_path / "a.recording") == list(range(11))
    assert spool.reads == 11
    spool.close()
    spool.close()


def test_a_spool_cut_at_any_byte_gives_its_whole_batches(tmp_path):
    folder = written(tmp_path / "a.recording")
    stream = folder / "reads.arrows"
    content = stream.read_bytes()
    counts = []
    for length in range(0, len(content) + 1, 97):
        stream.write_bytes(content[:length])
        heard = times(folder)
        assert heard == list(range(len(heard)))
        assert len(heard) % 10 == 0
        counts.append(len(heard))
    assert counts == sorted(counts)
    assert counts[0] == 0
    assert counts[-1] >= 50


def test_a_spool_that_did_not_end_becomes_a_trace(tmp_path):
    folder = written(tmp_path / "a.recording")
    stream = folder / "reads.arrows"
    stream.write_bytes(stream.read_bytes()[:-200])
    trace = import_spool(folder)
    assert 0 < trace.reads.num_rows < 60
    assert trace.meta.frame == "hall"
    told = json.loads(trace.meta.unknown_json)["recording"]
    assert told == {"written": trace.reads.num_rows, "dropped": {}, "ended": "recovered"}
    assert folder.exists()


def test_a_spool_without_a_read_is_no_answer(tmp_path):
    SpoolWriter(tmp_path / "a.recording", META).close()
    with pytest.raises(NothingRecorded):
        import_spool(tmp_path / "a.recording")


def test_what_is_no_spool_is_a_typed_error(tmp_path):
    with pytest.raises(TraceError):
        import_spool(tmp_path)
    with pytest.raises(TraceError):
        list(spooled_reads(tmp_path / "nowhere"))


def test_a_spool_is_never_written_over(tmp_path):
    folder = written(tmp_path / "a.recording")
    for again in (lambda: check_no_spool(folder), lambda: SpoolWriter(folder, META)):
        with pytest.raises(TraceError, match=r"import spool .*a\.recording.* then be deleted"):
            again()
    assert times(folder) == list(range(60))


def test_a_disk_that_refuses_is_a_typed_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(TraceError, match="cannot be written"):
        SpoolWriter(tmp_path / "file" / "a.recording", META)


def test_all_fields_of_a_read_survive(tmp_path):
    full = dataclasses.replace(
        READS[0], doppler_hz=1.5, tx_antenna=2, i=0.25, q=-0.5, t_reader_us=7, channel_index=3, pose_id=9
    )
    with SpoolWriter(tmp_path / "a.recording", META) as spool:
        spool.write([full])
    (batch,) = spooled_reads(tmp_path / "a.recording")
    assert TagRead(**batch.to_pylist()[0]) == full
