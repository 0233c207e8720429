"""CSV logs written with sllurp: raw phase codes, raw Doppler codes, and EPCs in three costumes."""

import numpy as np
import pytest

from rfcompass.errors import ImportFormatError
from rfcompass.recordings import import_sllurp

HEADER = "timestamp,antenna,rssi,epc,phase_angle,channel_index,doppler_frequency\n"
TABLE_HZ = (915.25e6, 902.75e6)


def imported(tmp_path, text, **options):
    path = tmp_path / "log.csv"
    path.write_text(text)
    return import_sllurp(path, **{"frequencies_hz": TABLE_HZ, **options})


@pytest.mark.parametrize("epc", ["303435FC8803", "b'303435fc8803'", '"b""303435fc8803"""', " 303435fc8803"])
@pytest.mark.parametrize("time", ["1746525605.123456", "2025-05-06T10:00:05.123456"])
def test_each_costume_gives_the_same_read(tmp_path, epc, time):
    (read,) = imported(tmp_path, f"{HEADER}{time},1,-35,{epc},3072,2,-40\n").reads.to_pylist()
    assert read == {
        "epc": "303435fc8803", "antenna": 1, "freq_hz": 902.75e6, "rssi_dbm": -35.0, "phase_rad": 1.5 * np.pi,
        "pose_id": 0, "t_ns": 1_746_525_605_123_456_000, "doppler_hz": -2.5, "channel_index": 2,
    }  # fmt: skip


def test_channels_outside_the_table_are_dropped_and_counted(tmp_path):
    rows = "".join(f"{k},1,-35,aa,{k},{k},0\n" for k in range(5))
    trace = imported(tmp_path, HEADER + rows)
    assert trace.reads["channel_index"].to_pylist() == [1, 2]
    assert '"channel_outside_table": 3' in trace.meta.unknown_json


def test_the_reader_is_named_where_the_log_names_it(tmp_path):
    text = "reader," + HEADER + "10.0.0.2:5084,1,1,-35,aa,0,1,0\n"
    assert imported(tmp_path, text).meta.reader == "10.0.0.2:5084"


def test_a_log_of_sllurp_itself_lacks_the_phase_and_says_so(tmp_path):
    with pytest.raises(ImportFormatError) as caught:
        imported(tmp_path, "timestamp,reader,antenna,rssi,epc\n1,r,1,-35,aa\n")
    assert caught.value.numbers["column"] == "phase_angle"


def test_without_the_frequencies_of_the_reader_there_is_no_trace(tmp_path):
    with pytest.raises(ImportFormatError, match="frequency table"):
        imported(tmp_path, f"{HEADER}1,1,-35,aa,0,1,0\n", frequencies_hz=())


def test_a_power_that_cannot_be_is_an_error_with_the_row_of_the_log(tmp_path):
    rows = "1,1,-35,aa,,1,0\n2,1,-35,aa,0,1,0\n3,1,-5300,aa,0,1,0\n"
    with pytest.raises(ImportFormatError) as caught:
        imported(tmp_path, HEADER + rows)
    assert (caught.value.numbers["column"], caught.value.numbers["row"]) == ("rssi_dbm", 2)


@pytest.mark.parametrize("cell", ["4096", "-1", "3.14", "1e99"])
def test_a_phase_that_is_no_code_is_an_error_rather_than_wrapped(tmp_path, cell):
    with pytest.raises(ImportFormatError) as caught:
        imported(tmp_path, f"{HEADER}1,1,-35,aa,4095,1,0\n2,1,-35,aa,{cell},1,0\n")
    assert (caught.value.numbers["column"], caught.value.numbers["row"]) == ("phase_angle", 1)


@pytest.mark.parametrize("index", [2**31, -(2**31) - 1, 2**62])
def test_a_channel_of_any_size_is_outside_the_table(tmp_path, index):
    trace = imported(tmp_path, f"{HEADER}1,1,-35,aa,0,{index},0\n2,1,-35,aa,0,1,0\n")
    assert trace.reads["channel_index"].to_pylist() == [1]
    assert '"channel_outside_table": 1' in trace.meta.unknown_json
