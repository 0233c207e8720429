"""Impinj ItemTest: commented headers, and numbers of both locales."""

import gzip

import numpy as np
import pytest

from rfcompass.errors import ImportFormatError
from rfcompass.recordings import import_itemtest

COMMENTS = """// 4/9/2026 2:15:32 PM
// ReaderName=impinj-test.local, AntennaIDs=1,2, ModeIndex=1002, PowerInDbm=30
// Timestamp, EPC, TID, Antenna, RSSI, Frequency, Hostname, PhaseAngle, DopplerFrequency, CRHandle
"""
POINT = COMMENTS + (
    "2026-04-09T14:24:20.2551234-05:00,300833B2DDD9014000000001,,1,-65.5,927.25,impinj,3.7245,-0.25,\n"
    "2026-04-09T14:24:20.3551234-05:00,300833B2DDD9014000000002,,2,-63,902.75,impinj,0,0.5,\n"
)
COMMA = COMMENTS + (
    '2026-04-09T14:24:20.2551234-05:00,300833B2DDD9014000000001,,1,"-65,5","927,25",impinj,"3,7245","-0,25",\n'
    '2026-04-09T14:24:20.3551234-05:00,300833B2DDD9014000000002,,2,-63,"902,75",impinj,0,"0,5",\n'
)


def imported(tmp_path, text, name="log.csv"):
    path = tmp_path / name
    path.write_bytes(gzip.compress(text.encode()) if name.endswith(".gz") else text.encode("utf-8-sig"))
    return import_itemtest(path)


@pytest.mark.parametrize("text", [POINT, COMMA, POINT.replace("\n", "\r\n")])
@pytest.mark.parametrize("name", ["log.csv", "log.csv.gz"])
def test_both_locales_give_the_same_reads(tmp_path, text, name):
    if name.endswith(".gz"):
        text = text.encode().decode("utf-8-sig")
    trace = imported(tmp_path, text, name)
    assert trace.reads.to_pylist() == [
        {
            "epc": "300833b2ddd9014000000001", "antenna": 1, "freq_hz": 927.25e6, "rssi_dbm": -65.5,
            "phase_rad": 3.7245, "pose_id": 0, "t_ns": 1_775_762_660_255_123_400, "doppler_hz": -0.25,
        },
        {
            "epc": "300833b2ddd9014000000002", "antenna": 2, "freq_hz": 902.75e6, "rssi_dbm": -63.0,
            "phase_rad": 0.0, "pose_id": 0, "t_ns": 1_775_762_660_355_123_400, "doppler_hz": 0.5,
        },
    ]  # fmt: skip


def test_the_conventions_of_the_reader_are_in_the_trace(tmp_path):
    meta = imported(tmp_path, POINT).meta
    assert (meta.phase_modulus, meta.phase_sign, meta.frame) == ("pi", 1, "antenna")
    assert "impinj-test.local" in meta.reader
    assert "log.csv" in meta.source


def test_a_header_without_a_comment_mark_and_a_second_comment_block_are_understood(tmp_path):
    plain = POINT.replace("// Timestamp", "Timestamp")
    assert imported(tmp_path, plain).reads.num_rows == 2
    assert imported(tmp_path, POINT + COMMENTS + POINT.splitlines()[-1] + "\n").reads.num_rows == 3


def test_a_file_without_a_header_is_not_taken_for_one(tmp_path):
    with pytest.raises(ImportFormatError, match="no ItemTest file"):
        imported(tmp_path, "a,b\n1,2\n")


def test_a_file_without_phase_names_the_missing_column(tmp_path):
    without = "\n".join(POINT.splitlines()).replace("PhaseAngle", "Angle") + "\n"
    with pytest.raises(ImportFormatError) as caught:
        imported(tmp_path, without)
    assert caught.value.numbers["column"] == "PhaseAngle"


@pytest.mark.parametrize("cell", ['"1.234,5"', '"1,2,3"', "-", "NaN"])
def test_a_number_of_no_locale_is_an_error_that_says_where(tmp_path, cell):
    with pytest.raises(ImportFormatError) as caught:
        imported(tmp_path, POINT.replace("902.75", cell))
    assert (caught.value.numbers["column"], caught.value.numbers["row"]) == ("Frequency", 1)


def test_frequencies_are_whole_hertz(tmp_path):
    trace = imported(tmp_path, COMMA.replace("927,25", "865,7"))
    assert trace.reads["freq_hz"].to_pylist()[0] == 865_700_000.0
    assert np.isfinite(trace.reads["freq_hz"].to_numpy()).all()


@pytest.mark.parametrize(
    ("old", "cell", "column"),
    [
        ("3.7245", "370.7", "PhaseAngle"),
        ("3.7245", "-0.1", "PhaseAngle"),
        ("927.25", "927250", "Frequency"),
        ("927.25", "0", "Frequency"),
    ],
)
def test_a_value_in_some_other_unit_is_an_error_that_says_where(tmp_path, old, cell, column):
    with pytest.raises(ImportFormatError) as caught:
        imported(tmp_path, POINT.replace(old, cell))
    assert (caught.value.numbers["column"], caught.value.numbers["row"]) == (column, 0)


def test_a_full_turn_may_be_rounded_up(tmp_path):
    (first, _) = imported(tmp_path, POINT.replace("3.7245", "6.2832")).reads["phase_rad"].to_pylist()
    assert 0.0 <= first < 1e-4
