"""What all importers share: cut lines, times, and lacking cells."""

import gzip
from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import ImportFormatError
from rfcompass.recordings.foreign_log import channels, numbers, optional_numbers, read_log, times_ns
from rfcompass.recordings.text_table import TextTable


def table(**columns):
    return TextTable("log.csv", columns, ImportFormatError)


def time_ns(cell):
    return times_ns(table(t=[cell]), "t")[0]


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_last_line_without_its_end_is_cut_whatever_it_looks_like(tmp_path, end):
    path = tmp_path / "log.csv"
    path.write_bytes(f"a,b{end}1,2{end}{end}3,4".encode())
    log = read_log(path)
    assert (log.lines, log.cut_lines) == (("a,b", "1,2"), 1)
    path.write_bytes(f"a,b{end}1,2{end}3,4{end}".encode())
    assert (read_log(path).lines, read_log(path).cut_lines) == (("a,b", "1,2", "3,4"), 0)


def test_a_log_may_be_gzipped_and_a_cut_archive_is_an_error(tmp_path):
    path = tmp_path / "log.csv.gz"
    content = gzip.compress(b"a,b\n1,2\n")
    path.write_bytes(content)
    assert read_log(path).lines == ("a,b", "1,2")
    path.write_bytes(content[:-6])
    with pytest.raises(ImportFormatError):
        read_log(path)


@pytest.mark.parametrize("content", [b"", b"a,b", b"\n\n", b"\xff\xfe\x00"])
def test_a_file_without_a_whole_line_of_text_is_an_error(tmp_path, content):
    (tmp_path / "log.csv").write_bytes(content)
    with pytest.raises(ImportFormatError):
        read_log(tmp_path / "log.csv")


@given(
    moment=st.datetimes(datetime(1971, 1, 1), datetime(2200, 1, 1)),
    hours=st.integers(-12, 14),
    ticks=st.integers(0, 9),
)
def test_iso_times_are_exact_to_100_ns_in_any_zone(moment, hours, ticks):
    zoned = moment.replace(tzinfo=timezone(timedelta(hours=hours)))
    text = zoned.strftime("%Y-%m-%dT%H:%M:%S.%f") + f"{ticks}{hours:+03d}:00"
    exact_us = (zoned - datetime(1970, 1, 1, tzinfo=UTC)) // timedelta(microseconds=1)
    assert time_ns(text) == 1000 * exact_us + 100 * ticks


def test_times_without_a_zone_are_utc_and_z_is_utc():
    assert time_ns("2025-05-06T10:00:05.5") == time_ns("2025-05-06T10:00:05.5Z") == time_ns("1746525605.5")


@given(ns=st.integers(0, 2**62))
def test_seconds_since_1970_are_exact(ns):
    assert time_ns(f"{ns // 10**9}.{ns % 10**9:09d}") == ns


@pytest.mark.parametrize("cell", ["yesterday", "nan", "inf", "1e40", "2025-13-01T00:00:00"])
def test_what_is_no_time_is_an_error_that_says_where(cell):
    with pytest.raises(ImportFormatError) as caught:
        times_ns(table(t=["1", cell]), "t")
    assert caught.value.numbers == {"file": "log.csv", "column": "t", "row": 1}


def test_empty_cells_lack_and_others_must_be_numbers():
    np.testing.assert_array_equal(numbers(table(a=["1.5", "", " "]), "a"), [1.5, np.nan, np.nan])
    assert np.isnan(optional_numbers(table(a=["1"]), "b")).all()
    for cell in ("x", "nan", "inf"):
        with pytest.raises(ImportFormatError) as caught:
            numbers(table(a=["1", cell]), "a")
        assert caught.value.numbers["row"] == 1


def test_channels_take_their_carriers_from_the_table():
    index, freq_hz, outside = channels(table(c=["2", "1", "3", "0", "-1"]), "c", (905e6, 903e6))
    assert index.tolist() == [2, 1, 3, 0, -1]
    assert freq_hz[:2].tolist() == [903e6, 905e6]
    assert outside.tolist() == [False, False, True, True, True]


def test_channels_without_a_table_are_an_error_rather_than_a_guess():
    with pytest.raises(ImportFormatError, match="table"):
        channels(table(c=["1"]), "c", ())
