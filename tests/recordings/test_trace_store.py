import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rfcompass.errors import TraceError
from rfcompass.recordings import AntennaPoses, Stops, Trace, open_trace, write_trace
from rfcompass.types import ProximityMatrix, Scan

seeds = st.integers(0, 2**31)
few = settings(deadline=None, max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])


def _bits(scan: Scan) -> dict[str, bytes]:
    names = ("channel", "read_counts", "antenna_positions_m", "frequencies_hz", "antenna_ports")
    return {f"{epc}.{name}": getattr(scan.trace(epc), name).tobytes() for epc in scan.epcs for name in names}


def _contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in sorted(folder.iterdir())}


def _rich(make_trace, seed: int = 0) -> Trace:
    """A trace that uses every file, with unknown keys and columns."""
    trace = make_trace(seed)
    R, P = trace.reads.num_rows, trace.antenna_poses.pose_ids.size
    poses = trace.antenna_poses
    matrix = ProximityMatrix(("T",), ("A", "B"), np.array([[0.5, np.nan]]), np.full((2, 2), np.nan), "oracle")
    return Trace(
        meta=replace(trace.meta, robot="youbot", tag_layout="X4", unknown_json='{"operator": "someone"}'),
        reads=trace.reads.append_column("stop_id", pa.array(np.arange(R) % 2)).append_column(
            "note", pa.array([["a"], None] * (R // 2) + [[]] * (R % 2))
        ),
        antenna_poses=AntennaPoses(
            poses.pose_ids, poses.antennas, poses.positions_m, poses.quaternions_xyzw, {"note": ["007"] * P}
        ),
        stops=Stops(np.array([0, 1]), np.eye(2, 3), ("arm_joint_1",), np.array([[0.1], [0.2]])),
        proximity={1: matrix},
    )


@given(seed=seeds)
@few
def test_what_is_written_reads_back_equal(make_trace, tmp_path, seed):
    trace = _rich(make_trace, seed)
    write_trace(trace, tmp_path / "t", overwrite=True)
    again = open_trace(tmp_path / "t")
    assert again.meta == trace.meta
    assert again.reads.equals(trace.reads)
    assert again.antenna_poses.unknown == trace.antenna_poses.unknown
    assert again.proximity[1].kind == "oracle"
    for stop_id in (0, 1):
        assert _bits(again.scan(stop_id)) == _bits(trace.scan(stop_id))
    assert again.quality == trace.quality


@given(seed=seeds)
@few
def test_rewriting_what_was_read_gives_equal_bytes(make_trace, tmp_path, seed):
    write_trace(_rich(make_trace, seed), tmp_path / "a", overwrite=True)
    write_trace(open_trace(tmp_path / "a"), tmp_path / "b", overwrite=True)
    assert _contents(tmp_path / "a") == _contents(tmp_path / "b")


def test_how_a_table_is_cut_into_chunks_does_not_show_in_the_file(make_trace, tmp_path):
    trace = make_trace()
    chunked = pa.concat_tables([trace.reads.slice(0, 7), trace.reads.slice(7)])
    write_trace(trace, tmp_path / "a")
    write_trace(replace(trace, reads=chunked), tmp_path / "b")
    assert _contents(tmp_path / "a") == _contents(tmp_path / "b")


def test_a_folder_named_like_a_partition_adds_no_column(make_trace, tmp_path):
    trace = make_trace()
    write_trace(trace, tmp_path / "run=3" / "t")
    assert open_trace(tmp_path / "run=3" / "t").reads.column_names == trace.reads.column_names


def test_a_trace_is_replaced_only_when_asked(make_trace, tmp_path):
    write_trace(make_trace(1), tmp_path / "t")
    before = _contents(tmp_path / "t")
    with pytest.raises(TraceError, match="overwriting"):
        write_trace(make_trace(2), tmp_path / "t")
    assert _contents(tmp_path / "t") == before
    write_trace(make_trace(2), tmp_path / "t", overwrite=True)
    assert _bits(open_trace(tmp_path / "t").scan()) == _bits(make_trace(2).scan())
    assert [entry.name for entry in tmp_path.iterdir()] == ["t"]


def test_a_damaged_trace_can_be_replaced(make_trace, tmp_path):
    write_trace(make_trace(), tmp_path / "t")
    (tmp_path / "t" / "reads.parquet").unlink()
    write_trace(make_trace(), tmp_path / "t", overwrite=True)
    assert open_trace(tmp_path / "t").quality.reads > 0


@pytest.mark.parametrize("kind", ["file", "folder", "trace with another file", "folder with another meta"])
def test_nothing_else_is_ever_replaced(make_trace, tmp_path, kind):
    target = tmp_path / "t"
    if kind == "trace with another file":
        write_trace(make_trace(), target)
    elif kind != "file":
        target.mkdir()
    precious = {"file": target, "folder with another meta": target / "meta.json"}.get(kind, target / "notes.txt")
    precious.write_text('{"schema": "mine"}')
    with pytest.raises(TraceError, match="something else"):
        write_trace(make_trace(), target, overwrite=True)
    assert precious.read_text() == '{"schema": "mine"}'


def test_an_empty_folder_may_be_filled(make_trace, tmp_path):
    (tmp_path / "t").mkdir()
    write_trace(make_trace(), tmp_path / "t")
    assert open_trace(tmp_path / "t").quality.reads > 0


@pytest.mark.parametrize(
    ("call", "nth", "there_before"),
    [
        *[("fsync", nth, there_before) for nth in range(4) for there_before in (False, True)],
        ("rename", 0, False),
        ("rename", 0, True),
        ("rename", 1, True),
    ],
)
def test_a_failure_leaves_everything_as_it_was(make_trace, tmp_path, monkeypatch, call, nth, there_before):
    if there_before:
        write_trace(make_trace(1), tmp_path / "t")
    before = _contents(tmp_path / "t") if there_before else {}
    calls = iter(range(100))

    def failing(original):
        def run(*args):
            if next(calls) == nth:
                raise OSError(28, "No space left on device")
            return original(*args)

        return run

    with monkeypatch.context() as patch:
        owner = os if call == "fsync" else Path
        patch.setattr(owner, call, failing(getattr(owner, call)))
        with pytest.raises(TraceError, match="No space left"):
            write_trace(make_trace(2), tmp_path / "t", overwrite=True)
    assert [entry.name for entry in tmp_path.iterdir()] == (["t"] if there_before else [])
    assert not there_before or _contents(tmp_path / "t") == before


def test_a_parent_that_is_a_file_is_an_error(make_trace, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(TraceError) as caught:
        write_trace(make_trace(), tmp_path / "file" / "t")
    assert caught.value.numbers["path"].endswith("t")


@pytest.fixture(scope="module")
def written(make_trace, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("written") / "t"
    write_trace(_rich(make_trace), folder)
    return folder


def _damaged_copy(written: Path, folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(written, folder)
    return folder


FILES = ["reads.parquet", "meta.json", "antenna_poses.csv", "stops.csv", "proximity.parquet"]


@given(
    name=st.sampled_from(FILES), at=st.floats(0, 1, exclude_max=True), cut=st.integers(0, 8), put=st.binary(max_size=8)
)
@settings(few, max_examples=150)
def test_any_damage_to_a_file_is_a_trace_error_or_harmless(written, tmp_path, name, at, cut, put):
    folder = _damaged_copy(written, tmp_path / "t")
    content = (folder / name).read_bytes()
    place = int(at * len(content))
    (folder / name).write_bytes(content[:place] + put + content[place + cut :])
    try:
        trace = open_trace(folder)
    except TraceError:
        return
    trace.scan(trace.stop_ids[0])
    assert trace.quality.reads == trace.reads.num_rows


@given(at=st.floats(0, 1, exclude_max=True))
@few
def test_a_truncated_reads_file_is_always_a_trace_error(written, tmp_path, at):
    folder = _damaged_copy(written, tmp_path / "t")
    content = (folder / "reads.parquet").read_bytes()
    (folder / "reads.parquet").write_bytes(content[: int(at * len(content))])
    with pytest.raises(TraceError) as caught:
        open_trace(folder)
    assert caught.value.numbers["file"] == "reads.parquet"


@given(at=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
@few
def test_a_flipped_bit_in_the_values_is_always_a_trace_error(written, tmp_path, at, bit):
    folder = _damaged_copy(written, tmp_path / "t")
    chunk = pq.ParquetFile(folder / "reads.parquet").metadata.row_group(0).column(4)
    assert chunk.path_in_schema == "phase_rad"
    content = bytearray((folder / "reads.parquet").read_bytes())
    end = chunk.data_page_offset + chunk.total_compressed_size - (chunk.data_page_offset - chunk.dictionary_page_offset)
    half = (end - chunk.data_page_offset) // 2  # the second half of the page is values, not its header
    content[end - half + int(at * half)] ^= 1 << bit
    (folder / "reads.parquet").write_bytes(content)
    with pytest.raises(TraceError):
        open_trace(folder)


@given(column=st.sampled_from(["epc", "antenna", "freq_hz", "rssi_dbm", "phase_rad", "pose_id", "stop_id"]))
@few
def test_a_dropped_column_is_always_a_trace_error_that_names_it(written, tmp_path, column):
    folder = _damaged_copy(written, tmp_path / "t")
    pq.write_table(pq.read_table(folder / "reads.parquet").drop([column]), folder / "reads.parquet")
    with pytest.raises(TraceError) as caught:
        open_trace(folder)
    assert caught.value.numbers["column"] == column


@given(
    column=st.sampled_from(["freq_hz", "rssi_dbm", "phase_rad"]), row=st.integers(0, 89),
    bad=st.sampled_from([float("nan"), float("inf"), -float("inf"), None]),
)  # fmt: skip
@few
def test_a_value_that_is_not_finite_is_always_named_by_column_and_row(written, tmp_path, column, row, bad):
    folder = _damaged_copy(written, tmp_path / "t")
    table = pq.read_table(folder / "reads.parquet")
    cells = table[column].to_pylist()
    cells[row] = bad
    index = table.column_names.index(column)
    pq.write_table(table.set_column(index, column, pa.array(cells, pa.float64())), folder / "reads.parquet")
    with pytest.raises(TraceError) as caught:
        open_trace(folder)
    expected = {"file": "reads.parquet", "column": column, "row": row}
    assert {key: caught.value.numbers[key] for key in expected} == expected


def test_unknown_keys_and_columns_of_a_foreign_writer_survive_rewriting(written, tmp_path):
    folder = _damaged_copy(written, tmp_path / "t")
    meta = json.loads((folder / "meta.json").read_text())
    meta["tags"][0]["colour"] = "red"
    (folder / "meta.json").write_text(json.dumps(meta))
    write_trace(open_trace(folder), tmp_path / "u")
    rewritten = json.loads((tmp_path / "u" / "meta.json").read_text())
    assert rewritten["tags"][0]["colour"] == "red"
    assert rewritten["operator"] == "someone"
    assert "note" in pq.read_schema(tmp_path / "u" / "reads.parquet").names
    assert (tmp_path / "u" / "antenna_poses.csv").read_text().splitlines()[1].endswith(",007")
