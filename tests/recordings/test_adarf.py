import gzip
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from rfcompass.errors import ImportFormatError
from rfcompass.recordings import IMPORTERS, import_adarf, open_trace, write_trace

HEADER = "epc,antennaIndex,frequency,time,RSSI,phase,dopplerShift,velocity,x,y,z,angle"


def _line(epc="AA", antenna="1", frequency="920625000", rssi="-51.5", phase="1.25", x="0.02") -> str:
    return f"{epc},{antenna},{frequency},0,{rssi},{phase},0,0,{x},1.63,0,-0.02"


def _write(folder: Path, name: str, *lines: str) -> None:
    folder.mkdir(exist_ok=True)
    content = b"\xef\xbb\xbf" + "\r\n".join([HEADER, *lines, ""]).encode()
    (folder / name).write_bytes(gzip.compress(content) if name.endswith(".gz") else content)


def _sweep(folder: Path, sweep: str = "190110-01-3-8") -> Path:
    _write(folder, f"{sweep}_10.csv.gz", _line(x="0.06", phase="3.5"))
    _write(folder, f"{sweep}_0.csv", _line(), _line(epc="BB", frequency="921125000", rssi="-60", phase="0.5"))
    _write(folder, f"{sweep}_2.csv", _line(epc="BB", x="0.04"), _line(x="0.04", phase="2"))
    return folder


def test_files_become_poses_in_the_order_of_their_index(tmp_path):
    trace = import_adarf(_sweep(tmp_path))
    assert trace.antenna_poses.pose_ids.tolist() == [0, 2, 10]
    np.testing.assert_array_equal(trace.antenna_poses.positions_m, [[0.02, 0, 0], [0.04, 0, 0], [0.06, 0, 0]])
    assert trace.reads.to_pylist()[1] == {
        "epc": "BB", "antenna": 1, "freq_hz": 921.125e6, "rssi_dbm": -60.0, "phase_rad": 0.5, "pose_id": 0,
    }  # fmt: skip
    assert trace.reads["pose_id"].to_pylist() == [0, 0, 2, 2, 10]


def test_the_conventions_of_the_campaign_are_stated(tmp_path):
    meta = import_adarf(_sweep(tmp_path)).meta
    assert (meta.phase_sign, meta.phase_modulus, meta.geometry, meta.dimensions) == (1, "2pi", "monostatic", 2)
    assert "190110-01-3-8" in meta.source


def test_a_full_turn_is_none(tmp_path):
    _write(tmp_path, "190110-01-3-8_0.csv", _line(phase="6.28318530717959"))
    assert import_adarf(tmp_path).reads["phase_rad"][0].as_py() < 1e-12


def test_columns_that_contradict_the_rig_are_not_taken_over(tmp_path):
    assert set(import_adarf(_sweep(tmp_path)).reads.column_names) == {
        "epc", "antenna", "freq_hz", "rssi_dbm", "phase_rad", "pose_id",
    }  # fmt: skip


def test_an_import_survives_being_written(tmp_path):
    trace = import_adarf(_sweep(tmp_path / "raw"))
    write_trace(trace, tmp_path / "trace")
    assert open_trace(tmp_path / "trace").reads.equals(trace.reads)


def test_all_tags_belong_unless_they_are_named(tmp_path):
    assert import_adarf(_sweep(tmp_path)).epcs == ("AA", "BB")
    trace = import_adarf(tmp_path, epcs=["BB"])
    assert trace.epcs == ("BB",)
    assert trace.quality.stray_reads == 3


def test_a_folder_may_carry_the_name_of_the_sweep_instead_of_its_files(tmp_path):
    sweep = tmp_path / "190110-01-3-8"
    for index in range(3):
        _write(sweep, f"{index}.csv", _line(x=str(0.02 * index)))
    trace = import_adarf(sweep)
    assert trace.antenna_poses.pose_ids.tolist() == [0, 1, 2]
    assert "190110-01-3-8" in trace.meta.source


def test_of_several_sweeps_one_must_be_chosen(tmp_path):
    _sweep(_sweep(tmp_path), "190110-02-3-8")
    with pytest.raises(ImportFormatError) as caught:
        import_adarf(tmp_path)
    assert caught.value.numbers["sweeps"] == ["190110-01-3-8", "190110-02-3-8"]
    assert import_adarf(tmp_path, sweep="190110-02-3-8").reads.num_rows == 5
    with pytest.raises(ImportFormatError, match="190110-03"):
        import_adarf(tmp_path, sweep="190110-03")


@pytest.mark.parametrize("name", [None, "readme.txt", "._190110-01-3-8_0.csv", "config.csv"])
def test_a_folder_without_a_sweep_is_an_error(tmp_path, name):
    if name:
        _write(tmp_path, name, _line())
    with pytest.raises(ImportFormatError):
        import_adarf(tmp_path)


def test_a_path_that_is_no_folder_is_an_error(tmp_path):
    with pytest.raises(ImportFormatError, match="no folder"):
        import_adarf(tmp_path / "nowhere")


def test_one_position_in_two_files_is_an_error(tmp_path):
    _write(_sweep(tmp_path), "190110-01-3-8_0.csv.gz", _line())
    with pytest.raises(ImportFormatError) as caught:
        import_adarf(tmp_path)
    assert caught.value.numbers["index"] == 0


@pytest.mark.parametrize(
    ("bad", "column"),
    [
        (_line(phase=""), "phase"),
        (_line(phase="nan"), "phase"),
        (_line(rssi="loud"), "RSSI"),
        (_line(rssi="-1e6"), "RSSI"),
        (_line(frequency="0"), "frequency"),
        (_line(antenna="1.0"), "antennaIndex"),
        (_line(antenna="2"), "antennaIndex"),
        (_line(epc=""), "epc"),
        (_line(x="0.5"), "x"),
        ("AA,1,920625000,0,-51", None),
    ],
)
def test_a_malformed_line_is_named_by_file_column_and_row(tmp_path, bad, column):
    _write(_sweep(tmp_path), "190110-01-3-8_3.csv", _line(), bad)
    with pytest.raises(ImportFormatError) as caught:
        import_adarf(tmp_path)
    assert caught.value.numbers["file"] == "190110-01-3-8_3.csv"
    assert caught.value.numbers["row"] == 1
    assert caught.value.numbers.get("column") == column


def test_a_file_without_reads_or_of_another_antenna_is_an_error(tmp_path):
    _write(_sweep(tmp_path), "190110-01-3-8_3.csv")
    with pytest.raises(ImportFormatError, match="no read"):
        import_adarf(tmp_path)
    _write(tmp_path, "190110-01-3-8_3.csv", _line(antenna="2"))
    with pytest.raises(ImportFormatError, match="the slide carries one"):
        import_adarf(tmp_path)


def test_the_importer_is_known_by_its_name(tmp_path):
    assert IMPORTERS["adarf"](_sweep(tmp_path)).reads.num_rows == 5


def test_the_raw_files_of_the_campaign_give_the_reads_of_the_converted_trace(measured_data):
    converted = open_trace(measured_data / "traces" / "adarf_D2test_190110-01")
    imported = import_adarf(measured_data / "raw_sample", epcs=converted.epcs)
    listed = imported.reads.filter(pa.compute.is_in(imported.reads["epc"], pa.array(converted.epcs)))
    expected = converted.reads.filter(pa.compute.is_in(converted.reads["pose_id"], pa.array([0, 24, 49], pa.int32())))
    for name in ("epc", "antenna", "freq_hz", "pose_id"):
        assert listed[name].to_pylist() == expected[name].to_pylist()
    np.testing.assert_allclose(listed["phase_rad"].to_numpy(), expected["phase_rad"].to_numpy(), atol=1e-6)
    np.testing.assert_allclose(listed["rssi_dbm"].to_numpy(), expected["rssi_dbm"].to_numpy(), atol=1e-6)
    np.testing.assert_allclose(
        imported.antenna_poses.positions_m, converted.antenna_poses.positions_m[[0, 24, 49]], atol=1e-6
    )
    assert [stray.epc for stray in imported.quality.strays] == ["942700000000000000000009"]
