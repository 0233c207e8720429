import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import TraceError
from rfcompass.recordings import reads_table
from rfcompass.recordings.read_table import read_columns
from rfcompass.types.reads import TagRead

GOOD = {
    "epc": ["B", "A", "B"], "antenna": [1, 2, 1], "freq_hz": [921e6, 920e6, 921e6], "rssi_dbm": [-50.0, -51.5, -60.0],
    "phase_rad": [0.1, 0.2, 6.2], "pose_id": [0, 1, 2],
}  # fmt: skip


def _table(**columns) -> pa.Table:
    return pa.table({**GOOD, **columns})


def test_values_come_out_as_they_went_in():
    columns = read_columns(_table(), phase_sign=-1)
    assert [columns.epcs[i] for i in columns.epc_index] == GOOD["epc"]
    assert columns.frequencies_hz[columns.freq_index].tolist() == GOOD["freq_hz"]
    assert columns.epcs == ("A", "B")
    np.testing.assert_allclose(20 * np.log10(columns.amplitude), GOOD["rssi_dbm"])
    np.testing.assert_array_equal(columns.lag_rad, -np.array(GOOD["phase_rad"]))


@given(
    lag=st.floats(-3.1, 3.1), level=st.floats(-100, 20), sign=st.sampled_from([1, -1])
)  # fmt: skip
def test_i_and_q_stand_for_the_same_channel_as_power_and_phase(lag, level, sign):
    h = 10 ** (level / 20) * np.exp(-1j * lag)
    polar = _table(rssi_dbm=[level] * 3, phase_rad=[sign * lag] * 3)
    cartesian = _table(i=[h.real] * 3, q=[h.imag] * 3).drop(["rssi_dbm", "phase_rad"])
    a, b = read_columns(polar, sign), read_columns(cartesian, sign)
    np.testing.assert_allclose(b.amplitude * np.exp(-1j * b.lag_rad), a.amplitude * np.exp(-1j * a.lag_rad), rtol=1e-9)


def test_i_and_q_are_preferred_where_power_and_phase_are_there_too():
    columns = read_columns(_table(i=[0.0, 0.0, 0.0], q=[2.0, 2.0, 2.0]), phase_sign=1)
    np.testing.assert_array_equal(columns.amplitude, 2.0)
    np.testing.assert_array_equal(columns.lag_rad, -np.pi / 2)


@pytest.mark.parametrize("name", GOOD)
def test_a_missing_column_is_named(name):
    with pytest.raises(TraceError) as caught:
        read_columns(_table().drop([name]), phase_sign=1)
    assert (caught.value.numbers["file"], caught.value.numbers["column"]) == ("reads.parquet", name)


@pytest.mark.parametrize(("there", "missing"), [("i", "q"), ("q", "i")])
def test_i_without_q_names_the_missing_one(there, missing):
    with pytest.raises(TraceError) as caught:
        read_columns(_table(**{there: [1.0, 1.0, 1.0]}), phase_sign=1)
    assert caught.value.numbers["column"] == missing


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("epc", [1, 2, 3]),
        ("antenna", [1.0, 2.0, 1.0]),
        ("antenna", [True, False, True]),
        ("pose_id", ["0", "1", "2"]),
        ("freq_hz", ["a", "b", "c"]),
        ("phase_rad", [[0.0], [0.0], [0.0]]),
        ("rssi_dbm", [None, None, None]),
        ("t_ns", [0.5, 1.5, 2.5]),
        ("doppler_hz", ["x", "y", "z"]),
        ("stop_id", [0.0, 0.0, 0.0]),
        ("tx_antenna", ["1", "1", "1"]),
    ],
)
def test_an_ill_typed_column_is_named(name, values):
    with pytest.raises(TraceError) as caught:
        read_columns(_table(**{name: values}), phase_sign=1)
    assert caught.value.numbers["column"] == name


@pytest.mark.parametrize(
    ("name", "bad"),
    [
        ("epc", ""), ("epc", None), ("antenna", None), ("pose_id", None), ("freq_hz", 0.0), ("freq_hz", -1.0),
        ("freq_hz", float("inf")), ("phase_rad", float("nan")), ("rssi_dbm", float("nan")), ("rssi_dbm", None),
        ("rssi_dbm", -float("inf")), ("rssi_dbm", 1e9), ("doppler_hz", float("nan")), ("i", 1e300), ("i", 0.0),
    ],
)  # fmt: skip
def test_an_impossible_value_is_named_by_its_row(name, bad):
    iq = {"i": [1.0, 1.0, 1.0], "q": [0.0, 0.0, 0.0]} if name == "i" else {}
    good = {**GOOD, "doppler_hz": [0.0, 0.0, 0.0], **iq}
    with pytest.raises(TraceError) as caught:
        read_columns(pa.table({**good, name: [*good[name][:2], bad]}), phase_sign=1)
    assert (caught.value.numbers["column"], caught.value.numbers["row"]) == (name, 2)


def test_an_integer_beyond_64_bits_is_named_by_its_row():
    with pytest.raises(TraceError) as caught:
        read_columns(_table(pose_id=pa.array([0, 2**63, 1], pa.uint64())), phase_sign=1)
    assert caught.value.numbers["row"] == 1


def test_a_column_given_twice_is_named():
    table = _table()
    with pytest.raises(TraceError, match="twice"):
        read_columns(table.append_column("epc", table["epc"]), phase_sign=1)


@pytest.mark.parametrize(
    "kind", [pa.string(), pa.large_string(), pa.dictionary(pa.int32(), pa.string())], ids=str
)  # fmt: skip
def test_the_storage_type_of_a_column_does_not_matter(kind):
    other = _table(epc=pa.array(GOOD["epc"]).cast(kind), antenna=pa.array(GOOD["antenna"], pa.uint8()))
    a, b = read_columns(other, phase_sign=1), read_columns(_table(), phase_sign=1)
    assert a.epcs == b.epcs
    np.testing.assert_array_equal(a.epc_index, b.epc_index)
    np.testing.assert_array_equal(a.antenna, b.antenna)


def test_times_and_doppler_may_be_unknown_for_some_reads():
    columns = read_columns(_table(t_ns=[1, None, 3], doppler_hz=[None, 0.5, None]), phase_sign=1)
    assert columns.epc_index.size == 3


def test_a_table_of_single_reads_holds_what_they_hold():
    reads = [TagRead("A", 1, 920e6, -50.0, 0.5, pose_id=7, t_ns=11), TagRead("B", 2, 921e6, -51.0, 0.25, pose_id=8)]
    table = reads_table(reads)
    assert table.column_names == ["epc", "antenna", "freq_hz", "rssi_dbm", "phase_rad", "pose_id", "t_ns"]
    assert [TagRead(**row) for row in table.to_pylist()] == reads


def test_a_table_without_reads_is_in_order():
    columns = read_columns(reads_table([]), phase_sign=1)
    assert columns.epcs == ()
    assert columns.frequencies_hz.shape == (0,)
