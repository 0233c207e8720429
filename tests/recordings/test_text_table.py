import gzip
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import ImportFormatError, TraceError
from rfcompass.recordings.text_table import as_csv, read_text_table

finite = st.floats(allow_nan=False, allow_infinity=False)


def _table(folder: Path, content: bytes, name: str = "a.csv"):
    (folder / name).write_bytes(content)
    return read_text_table(folder / name)


@given(values=st.lists(finite, min_size=1), texts=st.lists(st.text("ab,\"' é;"), min_size=1))
def test_what_is_written_reads_back_to_the_last_bit(tmp_path_factory, values, texts):
    rows = min(len(values), len(texts))
    content = as_csv({"v": values[:rows], "t": [f"x{text}" for text in texts[:rows]]})
    table = _table(tmp_path_factory.mktemp("csv"), content)
    assert table.floats("v").tobytes() == np.array(values[:rows]).tobytes()
    assert [text[1:] for text in table.text("t")] == texts[:rows]


@pytest.mark.parametrize("content", [b"a,b\n1,2\n", b"\xef\xbb\xbfa,b\n1,2\n", b"a,b\r\n1,2\r\n", b"a,b\n\n1,2\n\n"])
def test_byte_order_mark_line_ends_and_empty_lines_do_not_matter(tmp_path, content):
    table = _table(tmp_path, content)
    assert table.rows == 1
    assert table.integers("a").tolist() == [1]
    assert table.floats("b").tolist() == [2.0]


def test_a_gzipped_file_reads_like_the_plain_one(tmp_path):
    content = b"a\n1\n2\n"
    assert _table(tmp_path, gzip.compress(content), "a.csv.gz").columns == _table(tmp_path, content).columns


@pytest.mark.parametrize(
    ("content", "name"),
    [
        (b"", "a.csv"),
        (b"a,a\n1,2\n", "a.csv"),
        (b"a\n\xff\n", "a.csv"),
        (b'a\n"open\n', "a.csv"),
        (gzip.compress(b"a\n" + b"1\n" * 500)[:-12], "a.csv.gz"),
        (b"a\n1\n", "a.csv.gz"),
    ],
)
def test_a_damaged_file_is_an_error_that_names_it(tmp_path, content, name):
    with pytest.raises(TraceError) as caught:
        _table(tmp_path, content, name)
    assert caught.value.numbers["file"] == name


def test_a_file_that_is_not_there_is_the_error_asked_for(tmp_path):
    with pytest.raises(ImportFormatError):
        read_text_table(tmp_path / "none.csv", ImportFormatError)


def test_a_row_with_a_cell_too_many_is_named(tmp_path):
    with pytest.raises(TraceError) as caught:
        _table(tmp_path, b"a,b\n1,2\n1,2,3\n")
    assert caught.value.numbers["row"] == 1


@pytest.mark.parametrize("cell", ["", "x", "nan", "inf", "-inf", "1e999"])
def test_a_cell_that_is_no_finite_number_is_named(tmp_path, cell):
    table = _table(tmp_path, f"a,b\n1,1\n{cell},1\n".encode())
    with pytest.raises(TraceError) as caught:
        table.floats("a")
    assert (caught.value.numbers["column"], caught.value.numbers["row"]) == ("a", 1)


@pytest.mark.parametrize("cell", ["", "x", "1.0", "9223372036854775808"])
def test_a_cell_that_is_no_integer_is_named(tmp_path, cell):
    table = _table(tmp_path, f"a,b\n1,1\n{cell},1\n".encode())
    with pytest.raises(TraceError) as caught:
        table.integers("a")
    assert (caught.value.numbers["column"], caught.value.numbers["row"]) == ("a", 1)


def test_a_missing_column_is_an_error_that_lists_those_there(tmp_path):
    with pytest.raises(TraceError, match=r"found: a, b"):
        _table(tmp_path, b"a,b\n1,2\n").floats("c")
