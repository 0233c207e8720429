"""A scan travels to the last bit, averaged or read by read; what is no scan is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from same_records import differences

from rfcompass.errors import RobotFormatError
from rfcompass.recordings import AntennaPoses, TraceMeta
from rfcompass.recordings.robot_link import decode_frame, encode_frame, reads_json
from rfcompass.recordings.robot_link.heard import heard_json, heard_of
from rfcompass.types import ProximityMatrix, ReadTrace, Scan, TagRead

finite = st.floats(-1e3, 1e3)


def travelled(content):
    return decode_frame(encode_frame(content)[:-1])


@st.composite
def scans(draw):
    M, F, tags = draw(st.integers(1, 4)), draw(st.integers(1, 3)), draw(st.integers(0, 3))
    position_m = arrays(np.float64, (M, 3), elements=finite)
    traces = {}
    for k in range(tags):
        counts = draw(arrays(np.int64, (M, F), elements=st.integers(0, 5)))
        channel = draw(arrays(np.complex128, (M, F), elements=st.complex_numbers(max_magnitude=1e3)))
        traces[f"30{k:02}"] = ReadTrace(
            f"30{k:02}", draw(position_m), 9e8 + 1e6 * np.arange(F) + draw(st.floats(0, 1)), channel * (counts > 0),
            counts, draw(arrays(np.int64, M, elements=st.integers(1, 4))), draw(st.none() | position_m),
            draw(st.sampled_from([np.pi, 2 * np.pi])),
        )  # fmt: skip
    heights_m = draw(st.dictionaries(st.sampled_from(["3000", "3001"]), finite))
    return Scan(traces, draw(st.text()), draw(st.sampled_from([2, 3])), heights_m)


@given(scans())
def test_an_averaged_scan_comes_back_with_the_same_bits(scan):
    heard = heard_of(travelled(heard_json(scan, None)), ["3000"])
    assert differences(heard.scan, scan) == []
    assert heard.proximity is None


@given(st.data(), st.booleans())
def test_proximities_come_back_with_what_is_missing_still_missing(data, with_errors):
    K, N = 2, 3
    cells = st.floats(0, 10) | st.just(np.nan)
    upper = np.triu(data.draw(arrays(np.float64, (N, N), elements=cells)), 1)
    anchor_m = upper + upper.T
    np.fill_diagonal(anchor_m, np.nan)
    matrix = ProximityMatrix(
        ("a", "b"), ("x", "y", "z"), data.draw(arrays(np.float64, (K, N), elements=cells)), anchor_m, "phase_l1",
        data.draw(arrays(np.float64, (K, N), elements=cells)) if with_errors else None,
    )  # fmt: skip
    heard = heard_of(travelled(heard_json(Scan(), matrix)), ["a"])
    assert differences(heard.proximity, matrix) == []
    assert not heard.scan.traces


@pytest.mark.parametrize("meta", [{}, {"phase_sign": -1}, {"phase_modulus": "pi", "dimensions": 2}])
def test_the_rows_of_a_reader_give_the_scan_that_their_trace_gives(make_trace, meta):
    trace = make_trace(**meta)
    names = trace.reads.column_names
    reads = [TagRead(**{name: row[name] for name in names}) for row in trace.reads.to_pylist()]
    content = travelled(reads_json(reads, trace.antenna_poses, trace.meta))
    assert differences(heard_of(content, trace.meta.epcs).scan, trace.scan()) == []


def test_strays_are_left_out_and_a_reader_that_reports_the_channel_needs_no_power():
    rows = [{"epc": epc, "antenna": 1, "freq_hz": 9e8, "i": 0.3, "q": -0.4} for epc in ("aa", "stray")]
    content = {"reads": {
        "frame": "room", "geometry": "monostatic", "phase_sign": 1, "phase_modulus": "2pi", "dimensions": 3,
        "rows": rows, "antenna_poses": [{"pose_id": 0, "antenna": 1, "position_m": [1, 2, 3]}],
    }}  # fmt: skip
    scan = heard_of(content, ["aa", "bb"]).scan
    assert scan.epcs == ("aa",)
    assert np.allclose(scan.traces["aa"].channel, 0.3 - 0.4j)


def a_reading(**changes):
    row = {"epc": "aa", "antenna": 1, "freq_hz": 9e8, "rssi_dbm": -50.0, "phase_rad": 1.0, "pose_id": 0}
    content = {
        "frame": "room", "geometry": "monostatic", "phase_sign": 1, "phase_modulus": "2pi", "dimensions": 3,
        "rows": [row], "antenna_poses": [{"pose_id": 0, "antenna": 1, "position_m": [1.0, 2.0, 3.0]}],
    }  # fmt: skip
    return {"reads": {key: value for key, value in {**content, **changes}.items() if value is not None}}


@pytest.mark.parametrize(
    "content",
    [
        {},
        {"echo": 1},
        {**a_reading(), "channel": {}},
        a_reading(frame=None),
        a_reading(phase_sign=0),
        a_reading(rows=3),
        a_reading(rows=[3]),
        a_reading(rows=[{"epc": "aa"}]),
        a_reading(rows=[{"epc": 1, "antenna": 1, "freq_hz": 9e8, "rssi_dbm": -50.0, "phase_rad": 0.0}]),
        a_reading(rows=[{"epc": "aa", "antenna": 1, "freq_hz": 9e8, "rssi_dbm": -50.0}]),
        a_reading(rows=[{"epc": "aa", "antenna": 1, "freq_hz": -9e8, "rssi_dbm": -50.0, "phase_rad": 0.0}]),
        a_reading(rows=[{"epc": "aa", "antenna": 7, "freq_hz": 9e8, "rssi_dbm": -50.0, "phase_rad": 0.0}]),
        a_reading(rows=[{"epc": "aa", "antenna": 1, "freq_hz": 9e8, "rssi": -50.0}]),
        a_reading(antenna_poses=[{"pose_id": 0, "antenna": 1, "position_m": [1.0, 2.0]}]),
        a_reading(antenna_poses=[{"pose_id": 0.5, "antenna": 1, "position_m": [1.0, 2.0, 3.0]}]),
        a_reading(geometry="bistatic"),
        {"channel": {"frame": "a", "dimensions": 4, "heights_m": {}, "tags": []}},
        {"channel": {"frame": "a", "dimensions": 3, "heights_m": [], "tags": []}},
        {"channel": {"frame": "a", "dimensions": 3, "heights_m": {}, "tags": [{}]}},
        {"proximity": {"kind": "k", "target_epcs": ["a"], "anchor_epcs": ["x"], "m": [[-1.0]], "anchor_m": [[None]],
                       "standard_errors": None}},
        {"proximity": {"kind": "k", "target_epcs": ["a"], "anchor_epcs": ["x"], "m": [[1.0, 2.0]],
                       "anchor_m": [[None]], "standard_errors": None}},
        {"proximity": {"kind": "k", "target_epcs": [1], "anchor_epcs": ["x"], "m": [[1.0]], "anchor_m": [[None]],
                       "standard_errors": None}},
    ],
)  # fmt: skip
def test_what_is_no_scan_is_refused(content):
    with pytest.raises(RobotFormatError):
        heard_of(content, ["aa"])


def test_a_good_reading_is_taken():
    assert heard_of(a_reading(), ["aa"]).scan.epcs == ("aa",)


def test_poses_travel_with_their_antennas():
    places_m, upright = np.array([[0.0, 1, 2], [3, 4, 5]]), np.tile([0, 0, 0, 1.0], (2, 1))
    poses = AntennaPoses(np.array([0, 0]), np.array([2, 1]), places_m, upright)
    reads = [TagRead("aa", 2, 9e8, -50.0, 1.0)]
    scan = heard_of(travelled(reads_json(reads, poses, TraceMeta("room"))), ["aa"]).scan
    assert scan.traces["aa"].antenna_positions_m.tolist() == [[0.0, 1.0, 2.0]]
    assert scan.traces["aa"].antenna_ports.tolist() == [2]
