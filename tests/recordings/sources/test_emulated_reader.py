"""The emulated reader is a reader to any client, also to one that shares no line with us."""

import ast
import re
import signal
import socket
import subprocess
import sys
import time
import venv

import numpy as np
import pytest

pytest.importorskip("llrpkit", reason="llrpkit is not installed (extra llrp)")

from rfcompass.errors import InputError, ReaderError
from rfcompass.recordings.sources import EmulatedReader, LlrpSource, Pace, SequenceSource

# The last published sllurp whose command line works: the wheels of 3.0.2 and 3.0.5 lack the package `sllurp.verb`.
SLLURP = "sllurp==2.0.1"


@pytest.fixture(scope="session")
def sllurp(tmp_path_factory):
    """Command of sllurp, in an environment of its own: it is GPL, and only ever runs as a process of its own."""
    home = tmp_path_factory.getbasetemp().parent / f"environment-{SLLURP}"
    command = home / "bin" / "sllurp"
    if not command.exists():
        venv.create(home, with_pip=False, clear=True)
        pip = [sys.executable, "-m", "pip", "--python", str(home / "bin" / "python"), "install", "--quiet"]
        done = subprocess.run(
            [*pip, "--retries", "1", SLLURP], capture_output=True, text=True, timeout=120, check=False
        )
        if done.returncode:
            pytest.skip(f"{SLLURP} cannot be installed: {done.stderr.strip().splitlines()[-1:]}")
    return command


def tags_in(log):
    """What sllurp says that it saw: Python literals after `saw tag(s):`."""
    return [
        tag for seen in re.findall(r"saw tag\(s\): (\[.*?\}\])\n", log, re.DOTALL) for tag in ast.literal_eval(seen)
    ]


def run_sllurp(command, reader, until, log):
    """Let sllurp take an inventory until so many reads went out, then Ctrl-C; its log."""
    options = ["--antennas", "0", "--report-every-n-tags", "1", "--impinj-reports"]
    arguments = [command, "inventory", "--port", str(reader.port), *options, reader.host]
    with log.open("w") as out, subprocess.Popen(arguments, stdout=out, stderr=subprocess.STDOUT) as process:
        give_up_s = time.monotonic() + 20.0
        while reader.sent < until and process.poll() is None and time.monotonic() < give_up_s:
            time.sleep(0.05)
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            process.kill()
    return log.read_text()


def test_an_independent_client_reads_the_same_phases(sllurp, made_up_reads, tmp_path):
    reads = made_up_reads(300)
    with EmulatedReader(SequenceSource(reads), rng=np.random.default_rng(3)) as reader:
        theirs = tags_in(run_sllurp(sllurp, reader, len(reads), tmp_path / "log"))
        table_hz = reader.frequencies_hz
    with EmulatedReader(SequenceSource(reads), rng=np.random.default_rng(3)) as reader:
        source = LlrpSource(reader.host, reader.port, max_reads=len(reads), duration_s=20.0)
        ours = [read for batch in source for read in batch]
    assert len(theirs) == len(ours) == len(reads)
    for tag, read, told in zip(theirs, ours, reads, strict=True):
        assert tag["EPC"].decode() == read.epc
        assert table_hz[tag["ChannelIndex"] - 1] == read.freq_hz
        assert tag["ImpinjRFPhaseAngle"] == round(read.phase_rad / (2 * np.pi) * 4096) % 4096
        assert tag["ImpinjRFPhaseAngle"] == round(told.phase_rad / (2 * np.pi) * 4096) % 4096
        assert tag["ImpinjPeakRSSI"] == round(100 * read.rssi_dbm)
        assert tag["ImpinjRFDopplerFrequency"] == round(16 * read.doppler_hz)
        assert tag["LastSeenTimestampUTC"] == read.t_reader_us


def test_a_second_client_is_turned_away_while_the_first_one_reads(made_up_reads):
    source = SequenceSource(made_up_reads(1000), pace=Pace(reads_per_s=500.0))
    with EmulatedReader(source) as reader:
        batches = iter(LlrpSource(reader.host, reader.port))
        next(batches)
        with pytest.raises(ReaderError, match="another client"):
            next(iter(LlrpSource(reader.host, reader.port)))
        batches.close()


def test_no_read_is_taken_from_the_source_while_nobody_listens(made_up_reads):
    taken = []

    class Watched:
        def __iter__(self):
            for read in made_up_reads(3):
                taken.append(read)
                yield (read,)

    with EmulatedReader(Watched()) as reader:
        time.sleep(0.2)
        assert taken == []
        for batch in LlrpSource(reader.host, reader.port, max_reads=3, duration_s=10.0):
            assert batch
    assert len(taken) == 3
    assert reader.sent == 3


def test_a_source_that_fails_fails_where_one_sees_it(made_up_reads):
    class Failing:
        def __iter__(self):
            yield made_up_reads(2)
            raise InputError("no more")

    reader = EmulatedReader(Failing())
    reader.start()
    heard = [read for batch in LlrpSource(reader.host, reader.port, duration_s=0.4) for read in batch]
    assert len(heard) == 2
    with pytest.raises(InputError, match="no more"):
        reader.stop()


def test_a_reader_can_stand_behind_a_reader(made_up_reads):
    reads = made_up_reads(400)
    with EmulatedReader(SequenceSource(reads), rng=np.random.default_rng(1)) as first:
        relay = LlrpSource(first.host, first.port, max_reads=len(reads), duration_s=20.0)
        with EmulatedReader(relay, rng=np.random.default_rng(2)) as second:
            last = LlrpSource(second.host, second.port, max_reads=len(reads), duration_s=20.0)
            heard = [read for batch in last for read in batch]
    assert [read.t_reader_us for read in heard] == [read.t_reader_us for read in reads]
    assert [read.freq_hz for read in heard] == [read.freq_hz for read in reads]


def test_a_port_that_is_taken_is_a_typed_error():
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with pytest.raises(ReaderError) as caught:
            EmulatedReader(SequenceSource(()), port=port).start()
    assert caught.value.numbers["port"] == port


@pytest.mark.parametrize("wrong_hz", [0.0, -900e6, 902.7505e6 + 7.0])
def test_a_carrier_that_llrp_cannot_state_is_refused(wrong_hz):
    with pytest.raises(InputError):
        EmulatedReader(SequenceSource(()), frequencies_hz=[902.75e6, wrong_hz])


def test_stopping_twice_and_misbehaving_while_stopped_are_harmless(made_up_reads):
    reader = EmulatedReader(SequenceSource(made_up_reads(1)))
    with pytest.raises(ReaderError):
        reader.send_bytes(b"x")
    reader.start()
    reader.stop()
    reader.stop()
    with pytest.raises(ReaderError):
        reader.send_bytes(b"x")
