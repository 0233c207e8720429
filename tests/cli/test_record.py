"""`rfcompass record` as people run it: a process, a reader on a port, Ctrl-C."""

import json
import re
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

pytest.importorskip("llrpkit", reason="llrpkit is not installed (extra llrp)")

from rfcompass.recordings import TraceMeta, open_trace
from rfcompass.recordings.sources import EmulatedReader, Pace, SequenceSource
from rfcompass.recordings.spool import SpoolWriter
from rfcompass.types.reads import TagRead


def some_reads(count):
    rng = np.random.default_rng(2)
    return [
        TagRead(
            f"3008{k % 3:020x}", 1 + k % 2, 902.75e6 + 0.5e6 * (k % 50), -50.0, float(rng.uniform(0, 6)), t_reader_us=k
        )
        for k in range(count)
    ]


@pytest.fixture
def reader():
    with EmulatedReader(SequenceSource(some_reads(300)), rng=np.random.default_rng(0)) as emulated:
        yield emulated


def test_a_full_inventory_over_tcp_becomes_a_trace(run, reader, tmp_path):
    options = ("--antenna-position", "1=0,0,1", "--antenna-position", "2=1,0,1", "--frame", "hall", "--phase-sign", -1)
    ran = run("record", reader.host, "--port", reader.port, "--reads", 300, "--out", tmp_path / "t", *options, "--json")
    answer = ran.json
    assert (answer["reads"], answer["received"], answer["written"]) == (300, 300, 300)
    assert (answer["dropped"], answer["reconnects"], answer["ended"]) == ({}, 0, "reads")
    assert answer["epcs"] == [f"3008{k:020x}" for k in range(3)]
    trace = open_trace(answer["trace"])
    assert trace.reads["t_reader_us"].to_pylist() == list(range(300))
    assert (trace.meta.frame, trace.meta.phase_sign, trace.meta.phase_modulus) == ("hall", -1, "pi")
    assert "emulated" in trace.meta.reader
    assert trace.antenna_poses.positions_m.tolist() == [[0, 0, 1], [1, 0, 1]]
    assert json.loads(trace.meta.unknown_json)["recording"]["written"] == 300


def test_people_are_told_what_was_written_and_that_the_antennas_are_nowhere(run, reader, tmp_path):
    ran = run("record", reader.host, "--port", reader.port, "--reads", 300, "--out", tmp_path / "t")
    assert ran.code == 0
    assert "300 reads of 3 tags" in ran.err
    assert "origin" in ran.err


def test_reads_of_a_port_that_was_not_placed_are_dropped_and_people_are_told(run, reader, tmp_path):
    command = ("record", reader.host, "--port", reader.port, "--reads", 300, "--antenna-position", "2=0,0,1")
    ran = run(*command, "--out", tmp_path / "t", "--json")
    assert (ran.json["reads"], ran.json["dropped"]) == (150, {"no_place": 150})
    assert "no_place 150" in ran.err
    assert open_trace(tmp_path / "t").antenna_poses.positions_m.tolist() == [[0, 0, 1]]


def test_one_antenna_can_be_chosen(run, reader, tmp_path):
    command = ("record", reader.host, "--port", reader.port, "--antennas", "2", "--reads", 150)
    assert run(*command, "--out", tmp_path / "t", "--json").json["reads"] == 150
    assert set(open_trace(tmp_path / "t").reads["antenna"].to_pylist()) == {2}


def test_a_reader_without_phase_is_no_answer_that_says_why(run, tmp_path):
    with EmulatedReader(SequenceSource(some_reads(40)), extensions=False) as plain:
        command = ("record", plain.host, "--port", plain.port, "--duration", 0.5, "--out", tmp_path / "t", "--json")
        ran = run(*command)
    assert ran.code == 1
    assert ran.json["failure"]["kind"] == "NothingRecorded"
    assert ran.json["failure"]["dropped"] == {"no_phase": 40}
    assert list(tmp_path.iterdir()) == []


def test_a_reader_that_is_not_there_is_no_answer(run, reader, tmp_path):
    reader.stop()
    ran = run("record", reader.host, "--port", reader.port, "--out", tmp_path / "t", "--json")
    assert ran.code == 1
    assert ran.json["failure"]["kind"] == "LinkLost"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "wrong",
    [
        ("--antennas", "one"),
        ("--antenna-position", "1=0,0"),
        ("--antenna-position", "0,0,0"),
        ("--antenna-position", "1=0,0,nan"),
        ("--antenna-position", "1=0,0,0", "--antenna-position", "1=0,0,1"),
        ("--antenna-position", "1=0,0,0", "--carrier", "log.csv"),
        ("--poses", "nowhere.csv"),
        ("--duration", 0),
        ("--reads", -1),
        ("--session", 7),
        ("--phase-sign", 0),
        ("--dimensions", 4),
        ("--patience", 0),
        ("--port", 0),
    ],
)
def test_a_wrong_option_is_bad_input_before_anything_is_connected(run, tmp_path, wrong):
    # A later --port wins, so that the first one need not lead anywhere.
    ran = run("record", "127.0.0.1", "--port", 1, "--out", tmp_path / "t", *wrong)
    assert ran.code == 2
    assert list(tmp_path.iterdir()) == []


def test_what_is_there_is_not_replaced_unasked(run, reader, tmp_path):
    command = ("record", reader.host, "--port", reader.port, "--reads", 100, "--out", tmp_path / "t")
    assert run(*command).code == 0
    assert run(*command).code == 2
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "n.txt").write_text("mine")
    assert run(*command[:-1], tmp_path / "notes", "--overwrite").code == 2


def record_process(reader, out, *options):
    command = [sys.executable, "-c", "from rfcompass.cli import main; main()", "record", reader.host]
    arguments = [*command, "--port", str(reader.port), "--out", str(out), "--json", *options]
    return subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_until(condition, timeout_s=30.0):
    give_up_s = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < give_up_s, "it did not happen in time"
        time.sleep(0.02)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_ends_the_recording_and_keeps_every_read_that_went_out(tmp_path, number):
    with EmulatedReader(SequenceSource(some_reads(60_000), pace=Pace(reads_per_s=1000.0))) as reader:
        with record_process(reader, tmp_path / "t") as process:
            wait_until(lambda: reader.sent > 300)
            process.send_signal(number)
            out, err = process.communicate(timeout=30)
        sent = reader.sent
    assert process.returncode == 0, err
    answer = json.loads(out)
    assert answer["ended"] == "stopped"
    trace = open_trace(tmp_path / "t")
    assert trace.reads["t_reader_us"].to_pylist() == list(range(sent))
    assert answer["reads"] == answer["received"] == sent
    assert [entry.name for entry in tmp_path.iterdir()] == ["t"]


def test_a_recording_that_was_killed_can_be_recovered(run, tmp_path):
    with (
        EmulatedReader(SequenceSource(some_reads(60_000), pace=Pace(reads_per_s=1000.0))) as reader,
        record_process(reader, tmp_path / "t") as process,
    ):
        wait_until(lambda: reader.sent > 300)
        process.kill()
        process.communicate(timeout=30)
    assert [entry.name for entry in tmp_path.iterdir()] == ["t.recording"]
    again = run("record", "127.0.0.1", "--port", 1, "--out", tmp_path / "t")
    assert again.code == 2
    assert re.search(r"import\s+spool", again.err)
    answer = run("import", "spool", tmp_path / "t.recording", "--out", tmp_path / "t", "--json").json
    ticks = open_trace(tmp_path / "t").reads["t_reader_us"].to_pylist()
    assert ticks == list(range(len(ticks)))
    assert answer["reads"] == len(ticks) > 100


def test_what_is_told_about_a_recording_that_did_not_end_leads_to_a_new_one(run, reader, tmp_path):
    with SpoolWriter(tmp_path / "t.recording", TraceMeta(frame="hall")) as spool:
        spool.write(some_reads(5))
    record = ("record", reader.host, "--port", reader.port, "--reads", 100, "--out", tmp_path / "t", "--overwrite")
    refused = run(*record)
    assert refused.code == 2
    assert "deleted" in refused.err
    recovered = run("import", "spool", tmp_path / "t.recording", "--out", tmp_path / "t", "--json")
    assert (recovered.json["reads"], recovered.json["dropped"]) == (5, {})
    assert "dropped" not in recovered.err
    assert "is kept" in recovered.err
    shutil.rmtree(tmp_path / "t.recording")
    assert run(*record).code == 0


def test_the_reader_may_be_killed_and_started_again_while_recording(tmp_path):
    reader = EmulatedReader(SequenceSource(some_reads(2000), pace=Pace(reads_per_s=1500.0)))
    reader.start()
    with record_process(reader, tmp_path / "t", "--reads", "2000") as process:
        wait_until(lambda: reader.sent > 400)
        reader.stop()
        time.sleep(0.2)
        reader.start()
        out, err = process.communicate(timeout=60)
    reader.stop()
    assert process.returncode == 0, err
    assert json.loads(out)["reconnects"] == 1
    assert open_trace(tmp_path / "t").reads["t_reader_us"].to_pylist() == list(range(2000))


def test_import_takes_the_frequency_table_of_the_reader(run, tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("timestamp,antenna,rssi,epc,phase_angle,channel_index,doppler_frequency\n1,1,-35,aa,1024,2,0\n2,1,")
    (tmp_path / "table.txt").write_text("915.25\n902.75\n")
    for table in ("915.25,902.75", tmp_path / "table.txt"):
        command = ("import", "sllurp", log, "--frequencies", table, "--phase-modulus", "2pi", "--overwrite")
        ran = run(*command, "--out", tmp_path / "t", "--json")
        assert (ran.json["reads"], ran.json["dropped"]) == (1, {"cut_line": 1})
        assert "cut_line 1" in ran.err
        trace = open_trace(tmp_path / "t")
        assert trace.reads["freq_hz"].to_pylist() == [902.75e6]
        assert trace.meta.phase_modulus == "2pi"
    for wrong in ("fast", "-1", "", "902750000,903250000", "902750", "0.90275", "902.75,nan"):
        assert run("import", "sllurp", log, "--frequencies", wrong, "--out", tmp_path / "u").code == 2
    assert not (tmp_path / "u").exists()
