from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import TraceError
from rfcompass.recordings import AntennaPoses, Stops, TraceMeta
from rfcompass.recordings.placement import place_reads
from rfcompass.recordings.read_table import read_columns

META = TraceMeta(frame="rail")


def _poses(pairs) -> AntennaPoses:
    P = len(pairs)
    pose_ids, antennas = np.array(pairs, dtype=np.int64).reshape(P, 2).T
    return AntennaPoses(pose_ids, antennas, np.zeros((P, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (P, 1)))


def _columns(pose_id, antenna, **more):
    R = len(pose_id)
    table = {"epc": ["A"] * R, "freq_hz": [920e6] * R, "rssi_dbm": [-50.0] * R, "phase_rad": [0.0] * R}
    return read_columns(pa.table({**table, "pose_id": pose_id, "antenna": antenna, **more}), phase_sign=1)


def _stops(*stop_ids) -> Stops:
    S = len(stop_ids)
    return Stops(np.array(stop_ids, dtype=np.int64), np.zeros((S, 3)), (), np.zeros((S, 0)))


PAIRS = [(0, 1), (0, 2), (3, 1), (3, 2)]


@given(
    picked=st.lists(st.tuples(st.sampled_from([0, 3]), st.sampled_from([1, 2]), st.sampled_from([1, 2])), min_size=1)
)
def test_each_read_gets_the_poses_of_both_its_antennas(picked):
    pose_id, antenna, tx_antenna = (list(values) for values in zip(*picked, strict=True))
    columns = _columns(pose_id, antenna, tx_antenna=tx_antenna)
    placed = place_reads(columns, replace(META, geometry="bistatic"), _poses(PAIRS), None)
    rx, tx = placed.rx_rows[placed.position], placed.tx_rows[placed.position]
    assert [PAIRS[row] for row in rx] == [(p, a) for p, a, _ in picked]
    assert [PAIRS[row] for row in tx] == [(p, b) for p, _, b in picked]
    assert sorted(set(zip(rx, tx, strict=True))) == list(zip(placed.rx_rows, placed.tx_rows, strict=True))


@pytest.mark.parametrize(("pose_id", "antenna", "column"), [(7, 1, "pose_id"), (3, 9, "antenna")])
def test_a_read_without_its_pose_is_named(pose_id, antenna, column):
    with pytest.raises(TraceError) as caught:
        place_reads(_columns([0, pose_id], [1, antenna]), META, _poses(PAIRS), None)
    expected = {"column": column, "row": 1, "pose_id": pose_id, "antenna": antenna}
    assert {key: caught.value.numbers[key] for key in expected} == expected


def test_a_transmitter_without_its_pose_is_named():
    with pytest.raises(TraceError) as caught:
        place_reads(_columns([0], [1], tx_antenna=[9]), replace(META, geometry="bistatic"), _poses(PAIRS), None)
    assert caught.value.numbers["column"] == "tx_antenna"


@pytest.mark.parametrize("geometry", ["bistatic", "monostatic"])
def test_ports_that_contradict_the_geometry_are_an_error(geometry):
    more = {} if geometry == "bistatic" else {"tx_antenna": [1, 2]}
    with pytest.raises(TraceError) as caught:
        place_reads(_columns([0, 3], [1, 1], **more), replace(META, geometry=geometry), _poses(PAIRS), None)
    assert caught.value.numbers["column"] == "tx_antenna"


def test_a_monostatic_trace_may_repeat_its_antenna_as_transmitter():
    placed = place_reads(_columns([0, 3], [1, 2], tx_antenna=[1, 2]), META, _poses(PAIRS), None)
    assert placed.position.tolist() == [0, 3]


def test_an_unknown_stop_is_named():
    with pytest.raises(TraceError) as caught:
        place_reads(_columns([0, 0], [1, 1], stop_id=[4, 5]), META, _poses(PAIRS), _stops(4))
    assert (caught.value.numbers["row"], caught.value.numbers["stop_id"]) == (1, 5)


@pytest.mark.parametrize(
    ("meta", "stops", "more"),
    [
        (META, None, {"stop_id": [0]}),
        (META, _stops(0, 1), {}),
        (replace(META, robot="youbot"), None, {}),
    ],
    ids=["stop without a stops file", "several stops but no stop_id", "robot without a stops file"],
)
def test_inconsistent_stops_are_an_error(meta, stops, more):
    with pytest.raises(TraceError, match="stop"):
        place_reads(_columns([0], [1], **more), meta, _poses(PAIRS), stops)


def test_a_frequency_without_channel_offset_is_named():
    with pytest.raises(TraceError) as caught:
        place_reads(_columns([0], [1]), replace(META, channel_offsets_rad=((921e6, 0.1),)), _poses(PAIRS), None)
    assert caught.value.numbers["freq_hz"] == 920e6
