"""Every way in which a trace folder can break the format is one typed error that says where.

The folders are written by hand here, without the project's writer, from the text of the format alone.
"""

import json
from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from rfcompass.errors import InputError, NoAnswer, TagNeverHeard, TraceError
from rfcompass.recordings import open_trace

META = {
    "schema": "rfcompass-trace/1", "source": "made up", "license": "CC0", "reader": "none", "frame": "rail",
    "geometry": "monostatic", "phase_sign": 1, "phase_modulus": "2pi", "dimensions": 2,
    "tags": [{"epc": "AA"}, {"epc": "BB"}],
}  # fmt: skip
READS = {
    "epc": ["AA", "BB", "AA", "CC"], "antenna": [1, 1, 1, 1], "freq_hz": [920e6] * 4,
    "rssi_dbm": [-50.0, -51.0, -52.0, -53.0], "phase_rad": [0.1, 0.2, 0.3, 0.4], "pose_id": [0, 0, 1, 1],
}  # fmt: skip
POSES = ["pose_id,antenna,x_m,y_m,z_m,qx,qy,qz,qw", "0,1,0,0,0,0,0,0,1", "1,1,0.02,0,0,0,0,0,1", "2,1,0.04,0,0,0,0,0,1"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    path = tmp_path / "trace"
    path.mkdir()
    (path / "meta.json").write_text(json.dumps(META))
    (path / "antenna_poses.csv").write_text("\n".join(POSES) + "\n")
    pq.write_table(pa.table(READS), path / "reads.parquet")
    return path


def _meta(**changes: object) -> Callable[[Path], object]:
    return lambda path: (path / "meta.json").write_text(json.dumps(META | changes))


def _reads(**changes: object) -> Callable[[Path], object]:
    return lambda path: pq.write_table(pa.table(READS | changes), path / "reads.parquet")


def _without(column: str) -> Callable[[Path], object]:
    return lambda path: pq.write_table(pa.table(READS).drop([column]), path / "reads.parquet")


def _poses(*rows: str) -> Callable[[Path], object]:
    return lambda path: (path / "antenna_poses.csv").write_text("\n".join([*POSES, *rows]))


def _truncate(name: str) -> Callable[[Path], object]:
    return lambda path: (path / name).write_bytes((path / name).read_bytes()[:-20])


def _remove(name: str) -> Callable[[Path], object]:
    return lambda path: (path / name).unlink()


def _stops(*rows: str, **reads: object) -> Callable[[Path], object]:
    def write(path: Path) -> None:
        header = "stop_id,base_x_m,base_y_m,base_theta_rad,arm_joint_1"
        (path / "stops.csv").write_text("\n".join([header, *rows]))
        _reads(**reads)(path)

    return write


NAN, INF = float("nan"), float("inf")
DEFECTS = {
    "no meta": (_remove("meta.json"), "meta.json", None, None),
    "no reads": (_remove("reads.parquet"), "reads.parquet", None, None),
    "no poses": (_remove("antenna_poses.csv"), "antenna_poses.csv", None, None),
    "meta is no JSON": (_truncate("meta.json"), "meta.json", None, None),
    "meta of another schema": (_meta(schema="rfcompass-trace/2"), "meta.json", "schema", None),
    "unknown geometry": (_meta(geometry="round"), "meta.json", "geometry", None),
    "phase sign 0": (_meta(phase_sign=0), "meta.json", "phase_sign", None),
    "unknown modulus": (_meta(phase_modulus="4pi"), "meta.json", "phase_modulus", None),
    "one dimension": (_meta(dimensions=1), "meta.json", "dimensions", None),
    "duplicate EPC": (_meta(tags=[{"epc": "AA"}, {"epc": "BB"}, {"epc": "AA"}]), "meta.json", "tags", 2),
    "truncated reads": (_truncate("reads.parquet"), "reads.parquet", None, None),
    "missing column": (_without("phase_rad"), "reads.parquet", "phase_rad", None),
    "ill-typed column": (_reads(antenna=["1"] * 4), "reads.parquet", "antenna", None),
    "NaN phase": (_reads(phase_rad=[0.1, 0.2, NAN, 0.4]), "reads.parquet", "phase_rad", 2),
    "infinite phase": (_reads(phase_rad=[0.1, INF, 0.3, 0.4]), "reads.parquet", "phase_rad", 1),
    "NaN power": (_reads(rssi_dbm=[NAN, -51.0, -52.0, -53.0]), "reads.parquet", "rssi_dbm", 0),
    "null power": (_reads(rssi_dbm=[-50.0, -51.0, -52.0, None]), "reads.parquet", "rssi_dbm", 3),
    "frequency 0": (_reads(freq_hz=[920e6, 920e6, 0.0, 920e6]), "reads.parquet", "freq_hz", 2),
    "negative frequency": (_reads(freq_hz=[-920e6, 1.0, 1.0, 1.0]), "reads.parquet", "freq_hz", 0),
    "read without its pose": (_reads(pose_id=[0, 0, 1, 3]), "reads.parquet", "pose_id", 3),
    "read without its antenna": (_reads(antenna=[1, 2, 1, 1]), "reads.parquet", "antenna", 1),
    "bistatic without transmitter": (_meta(geometry="bistatic"), "reads.parquet", "tx_antenna", None),
    "i without q": (_reads(i=[1.0] * 4), "reads.parquet", "q", None),
    "pose given twice": (_poses("1,1,0.03,0,0,0,0,0,1"), "antenna_poses.csv", "pose_id", 3),
    "zero quaternion": (_poses("3,1,0.06,0,0,0,0,0,0"), "antenna_poses.csv", "qw", 3),
    "NaN pose": (_poses("3,1,nan,0,0,0,0,0,1"), "antenna_poses.csv", "x_m", 3),
    "pose that is no number": (_poses("3,one,0,0,0,0,0,0,1"), "antenna_poses.csv", "antenna", 3),
    "pose cut short": (_poses("3,1,0.06"), "antenna_poses.csv", None, 3),
    "unknown stop": (_stops("0,0,0,0,0", stop_id=[0, 0, 0, 1]), "reads.parquet", "stop_id", 3),
    "several stops, no stop_id": (_stops("0,0,0,0,0", "1,0,0,0,0"), "reads.parquet", "stop_id", None),
    "stop given twice": (_stops("0,0,0,0,0", "0,1,0,0,0", stop_id=[0] * 4), "stops.csv", "stop_id", 1),
    "infinite joint": (_stops("0,0,0,0,inf", stop_id=[0] * 4), "stops.csv", "arm_joint_1", 0),
}


def test_the_trace_is_in_order_before_it_is_broken(folder):
    quality = open_trace(folder).quality
    assert quality.reads == 4
    assert [stray.epc for stray in quality.strays] == ["CC"]
    assert quality.poses_without_reads == ((2, 1),)


@pytest.mark.parametrize("name", DEFECTS)
def test_a_defect_is_a_typed_error_that_says_where(folder, name):
    damage, file, column, row = DEFECTS[name]
    damage(folder)
    with pytest.raises(TraceError) as caught:
        open_trace(folder)
    numbers = caught.value.numbers
    assert (numbers["file"], numbers.get("column"), numbers.get("row")) == (file, column, row)
    assert numbers["path"] == str(folder)
    assert isinstance(caught.value, InputError)


@pytest.mark.parametrize("name", DEFECTS)
def test_reading_a_bad_trace_writes_nothing(folder, name):
    DEFECTS[name][0](folder)
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    with pytest.raises(TraceError):
        open_trace(folder)
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before
    assert list(folder.parent.iterdir()) == [folder]


@pytest.mark.parametrize("path", ["nowhere", "", "trace/meta.json"])
def test_a_path_that_is_no_trace_folder_is_a_typed_error(folder, path):
    with pytest.raises(TraceError, match="no trace"):
        open_trace(folder.parent / path)


def test_an_epc_that_was_never_heard_is_no_answer_rather_than_bad_input(folder):
    _meta(tags=[*META["tags"], {"epc": "DD"}])(folder)
    with pytest.raises(TagNeverHeard) as caught:
        open_trace(folder).scan().trace("DD")
    assert isinstance(caught.value, NoAnswer)
    assert caught.value.numbers == {"epc": "DD", "heard": ["AA", "BB"]}
