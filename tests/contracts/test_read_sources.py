"""What every source of reads must do, so that nothing downstream can tell a file, a simulator and a reader apart."""

import sys
from contextlib import contextmanager

import numpy as np
import pytest

from rfcompass.errors import MissingExtra
from rfcompass.interfaces import ReadSource
from rfcompass.recordings import AntennaPoses, Trace, TraceMeta, open_trace, reads_table, record, write_trace
from rfcompass.recordings import sources as package
from rfcompass.recordings.sources import SequenceSource, TraceSource
from rfcompass.simulation import SweepScene, simulate_sweep
from rfcompass.types.reads import TagRead

RAIL_M = np.column_stack([np.linspace(0, 1, 12), np.zeros(12), np.zeros(12)])
TAGS_M = {f"3008{k:020x}": np.array([0.2 + 0.3 * k, 0.7, 0.0]) for k in range(3)}
SCENE = SweepScene(
    tags_m=TAGS_M, antenna_positions_m=RAIL_M, frequencies_hz=902.75e6 + 0.5e6 * np.array([3.0, 20.0, 41.0])
)
HEARD = simulate_sweep(SCENE, np.random.default_rng(3))


class Simulated:
    """A simulator as a source: whatever yields batches of reads is one."""

    def __iter__(self):
        for pose_id in range(len(RAIL_M)):
            yield tuple(read for read in HEARD if read.pose_id == pose_id)


@contextmanager
def simulated(_):
    yield Simulated()


@contextmanager
def sequence(_):
    yield SequenceSource(HEARD, batch_reads=17)


@contextmanager
def trace_file(folder):
    trace = Trace(TraceMeta(frame="rail", dimensions=2), reads_table(HEARD), AntennaPoses.along(RAIL_M))
    write_trace(trace, folder / "trace")
    yield TraceSource(open_trace(folder / "trace"), batch_reads=17)


@contextmanager
def llrp(_):
    pytest.importorskip("llrpkit", reason="llrpkit is not installed (extra llrp)")
    rng = np.random.default_rng(5)
    with package.EmulatedReader(Simulated(), rng=rng) as reader:
        yield package.LlrpSource(reader.host, reader.port, max_reads=len(HEARD), duration_s=20.0)


SOURCES = {"simulated": simulated, "sequence": sequence, "trace file": trace_file, "llrp": llrp}


@pytest.fixture(params=SOURCES)
def source(request, tmp_path):
    with SOURCES[request.param](tmp_path) as made:
        yield made


def test_it_is_a_read_source(source):
    assert isinstance(source, ReadSource)


def test_every_read_comes_once_and_in_order_in_batches_of_reads(source):
    batches = list(source)
    assert all(isinstance(read, TagRead) for batch in batches for read in batch)
    assert all(len(batch) for batch in batches)
    heard = [read for batch in batches for read in batch]
    assert [(r.epc, r.antenna, r.freq_hz) for r in heard] == [(r.epc, r.antenna, r.freq_hz) for r in HEARD]


def test_phase_and_power_are_right_to_half_the_last_digit_of_llrp(source):
    heard = [read for batch in source for read in batch]
    for read, told in zip(heard, HEARD, strict=True):
        off_rad = (read.phase_rad - told.phase_rad + np.pi) % (2 * np.pi) - np.pi
        assert abs(off_rad) <= np.pi / 4096 + 1e-12
        assert 0.0 <= read.phase_rad < 2 * np.pi
        assert abs(read.rssi_dbm - told.rssi_dbm) <= 0.005 + 1e-12


def test_a_recording_of_it_is_a_trace_with_all_of_its_reads(source, tmp_path):
    done = record(source, tmp_path / "recorded", meta=TraceMeta(frame="rail", dimensions=2))
    trace = open_trace(tmp_path / "recorded")
    assert done.reads == trace.reads.num_rows == len(HEARD)
    assert set(trace.scan().epcs) == set(TAGS_M)


def test_without_llrpkit_one_is_told_what_to_install(monkeypatch):
    for name in [name for name in sys.modules if name.startswith(("llrpkit", "rfcompass.recordings.sources.llrp"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "llrpkit", None)
    with pytest.raises(MissingExtra, match=r"rfcompass\[llrp\]") as caught:
        package.LlrpSource  # noqa: B018 - the access is what fails
    assert caught.value.numbers["extra"] == "llrp"


def test_an_unknown_name_is_still_an_attribute_error():
    with pytest.raises(AttributeError, match="LlrpSource"):
        package.Nothing  # noqa: B018
