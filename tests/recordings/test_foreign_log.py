"""What all importers share: cut lines, times, and lacking cells."""

import gzip
from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import ImportFormatError
from rfcompass.recordings.foreign_log import epcs, numbers, optional_numbers, ports, read_log, times_ns
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


@pytest.mark.parametrize("cell", ["-0.1", "10.5", "1e300"])
def test_a_number_that_a_column_cannot_hold_is_an_error_that_says_where(cell):
    assert numbers(table(a=["0", "10", ""]), "a", within=(0.0, 10.0))[:2].tolist() == [0.0, 10.0]
    with pytest.raises(ImportFormatError, match="0 to 10") as caught:
        numbers(table(a=["1", cell]), "a", within=(0.0, 10.0))
    assert caught.value.numbers == {"file": "log.csv", "column": "a", "row": 1}


def test_a_fraction_where_only_integers_belong_is_an_error():
    assert numbers(table(a=["3", "4.0"]), "a", whole=True).tolist() == [3.0, 4.0]
    with pytest.raises(ImportFormatError, match="no integer"):
        numbers(table(a=["3.14"]), "a", whole=True)


@pytest.mark.parametrize("cell", ["-4", "0", "65536", "1.5", ""])
def test_what_is_no_port_is_an_error_that_says_where(cell):
    assert ports(table(a=["1", "65535"]), "a").tolist() == [1, 65535]
    with pytest.raises(ImportFormatError) as caught:
        ports(table(a=["1", cell]), "a")
    assert caught.value.numbers == {"file": "log.csv", "column": "a", "row": 1}


@pytest.mark.parametrize("cell", ["zzzz not hex", "0x30", "303", "30 08", "\u0663\u0660"])
def test_what_is_no_hexadecimal_epc_is_an_error_that_says_where(cell):
    assert epcs(table(a=["3008", " 30AB ", "", " "]), "a") == ["3008", "30ab", "", ""]
    with pytest.raises(ImportFormatError) as caught:
        epcs(table(a=["3008", cell]), "a")
    assert caught.value.numbers == {"file": "log.csv", "column": "a", "row": 1}


def test_a_folder_is_no_log_and_the_error_names_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ImportFormatError, match=r"^\.: cannot be read") as caught:
        read_log(".")
    assert caught.value.numbers["file"] == "."
