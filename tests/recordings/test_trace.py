import pickle
from dataclasses import fields, replace

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.errors import TagNeverHeard, TraceError
from rfcompass.recordings import AntennaPoses, Stops, Trace, TraceMeta, TraceTag, reads_table
from rfcompass.types import Observation, ProximityMatrix, ReadTrace, Scan, TagRead

C = 299_792_458.0


def same_scan(one: Scan, other: Scan) -> bool:
    """True if both scans are equal to the last bit."""
    if (one.epcs, one.frame, one.dimensions) != (other.epcs, other.frame, other.dimensions):
        return False
    arrays = ("antenna_positions_m", "frequencies_hz", "channel", "read_counts", "antenna_ports")
    return all(
        getattr(one.trace(epc), name).tobytes() == getattr(other.trace(epc), name).tobytes()
        for epc in one.epcs
        for name in arrays
    )


def _with_reads(trace: Trace, reads: pa.Table) -> Trace:
    return replace(trace, reads=reads)


@given(seed=st.integers(0, 50))
@settings(deadline=None, max_examples=20)
def test_the_row_order_of_the_reads_changes_nothing_in_the_scan(make_trace, seed):
    trace = make_trace(seed)
    order = np.random.default_rng(seed).permutation(trace.reads.num_rows)
    assert same_scan(trace.scan(), _with_reads(trace, trace.reads.take(pa.array(order))).scan())


@pytest.mark.parametrize("sign", [1, -1])
def test_the_phase_of_the_scan_falls_with_distance_whatever_the_reader_says(sign):
    distances_m = 0.5 + 0.01 * np.arange(6)
    reads = [
        TagRead("A", 1, 920e6, -50.0, sign * 4 * np.pi * d * 920e6 / C % (2 * np.pi), p)
        for p, d in enumerate(distances_m)
    ]
    poses = AntennaPoses(np.arange(6), np.ones(6, int), np.zeros((6, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (6, 1)))
    h = Trace(TraceMeta(frame="a", phase_sign=sign), reads_table(reads), poses).scan().trace("A").channel[:, 0]
    np.testing.assert_allclose(h, 10**-2.5 * np.exp(-2j * np.pi * 920e6 * 2 * distances_m / C), atol=1e-12)


def test_all_tags_share_the_axes_in_the_order_of_the_poses(make_trace):
    trace = make_trace(tags=3, positions=4)
    partly = trace.reads.filter(pa.compute.or_(
        pa.compute.not_equal(trace.reads["epc"], "30080001"), pa.compute.equal(trace.reads["pose_id"], 2)
    ))  # fmt: skip
    scan = _with_reads(trace, partly).scan()
    for epc in scan.epcs:
        np.testing.assert_array_equal(scan.trace(epc).antenna_positions_m, trace.antenna_poses.positions_m)
    assert scan.trace("30080001").mask[:, 0].tolist() == [False, False, True, False]


def test_strays_are_left_out_and_a_silent_tag_is_no_answer(make_trace):
    trace = make_trace(tags=3)
    trace = replace(trace, meta=replace(trace.meta, tags=(TraceTag("30080000"), TraceTag("30089999"))))
    scan = trace.scan()
    assert scan.epcs == ("30080000",)
    assert trace.epcs == ("30080000", "30089999")
    with pytest.raises(TagNeverHeard):
        scan.trace("30089999")


def test_without_a_list_of_tags_all_that_were_heard_belong(make_trace):
    trace = make_trace(tags=3)
    trace = replace(trace, meta=replace(trace.meta, tags=()))
    assert trace.epcs == trace.scan().epcs == ("30080000", "30080001", "30080002")


@given(offsets=st.lists(st.floats(-9, 9), min_size=2, max_size=2), sign=st.sampled_from([1, -1]))
@settings(deadline=None, max_examples=20)
def test_known_channel_offsets_are_removed(make_trace, offsets, sign):
    plain = make_trace(phase_sign=sign)
    freqs_hz = plain.scan().trace("30080000").frequencies_hz
    offset_of = dict(zip(freqs_hz.tolist(), offsets, strict=True))
    raw = plain.reads["phase_rad"].to_numpy() + [offset_of[f] for f in plain.reads["freq_hz"].to_pylist()]
    shifted = plain.reads.set_column(plain.reads.column_names.index("phase_rad"), "phase_rad", pa.array(raw))
    meta = replace(plain.meta, channel_offsets_rad=tuple(offset_of.items()))
    scan = Trace(meta, shifted, plain.antenna_poses).scan()
    for epc in scan.epcs:
        np.testing.assert_allclose(scan.trace(epc).channel, plain.scan().trace(epc).channel, atol=1e-12)


def _two_stops(make_trace) -> Trace:
    trace = make_trace(positions=4)
    stop_id = (trace.reads["pose_id"].to_numpy() >= 2).astype(np.int64) + 5
    reads = trace.reads.append_column("stop_id", pa.array(stop_id))
    stops = Stops(np.array([5, 6, 7]), np.zeros((3, 3)), ("arm_joint_1",), np.zeros((3, 1)))
    return replace(trace, reads=reads, stops=stops)


def test_each_stop_has_its_own_scan(make_trace):
    trace = _two_stops(make_trace)
    positions_m = trace.antenna_poses.positions_m
    np.testing.assert_array_equal(trace.scan(5).trace("30080000").antenna_positions_m, positions_m[:2])
    np.testing.assert_array_equal(trace.scan(6).trace("30080000").antenna_positions_m, positions_m[2:])
    assert trace.scan(7).epcs == ()


@pytest.mark.parametrize("stop_id", [None, 8])
def test_a_stop_must_be_chosen_among_several(make_trace, stop_id):
    with pytest.raises(TraceError) as caught:
        _two_stops(make_trace).scan(stop_id)
    assert caught.value.numbers["stops"] == [5, 6, 7]


def test_the_only_stop_need_not_be_named(make_trace):
    trace = make_trace()
    one_stop = replace(trace, stops=Stops(np.array([3]), np.zeros((1, 3)), (), np.zeros((1, 0))))
    assert same_scan(one_stop.scan(), one_stop.scan(3))
    assert same_scan(one_stop.scan(), trace.scan())


def test_a_bistatic_scan_knows_where_the_transmitter_was():
    reads = reads_table([TagRead("A", rx, 920e6, -50.0, 1.0, pose) for pose in (0, 1) for rx in (1, 2)])
    reads = reads.append_column("tx_antenna", pa.array([2, 1, 2, 1]))
    positions_m = np.arange(12.0).reshape(4, 3)
    poses = AntennaPoses(np.array([0, 0, 1, 1]), np.array([1, 2, 1, 2]), positions_m, np.ones((4, 4)))
    trace = Trace(TraceMeta(frame="a", geometry="bistatic"), reads, poses).scan().trace("A")
    np.testing.assert_array_equal(trace.antenna_positions_m, positions_m)
    np.testing.assert_array_equal(trace.tx_positions_m, positions_m[[1, 0, 3, 2]])
    assert trace.antenna_ports.tolist() == [1, 2, 1, 2]


def test_half_turn_ambiguous_reads_give_the_channel_modulo_pi(make_trace):
    plain = make_trace()
    raw = plain.reads["phase_rad"].to_numpy() % np.pi
    reads = plain.reads.set_column(plain.reads.column_names.index("phase_rad"), "phase_rad", pa.array(raw))
    scan = Trace(replace(plain.meta, phase_modulus="pi"), reads, plain.antenna_poses).scan()
    for epc in scan.epcs:
        assert scan.trace(epc).phase_modulus_rad == np.pi
        squares, expected = scan.trace(epc).channel ** 2, plain.scan().trace(epc).channel ** 2
        np.testing.assert_allclose(squares / expected, 1.0, atol=0.01)


def test_a_trace_without_reads_is_in_order_and_its_scan_empty(make_trace):
    trace = _with_reads(make_trace(), reads_table([]))
    assert trace.scan().epcs == ()
    assert trace.quality.reads == 0


def test_a_ready_made_proximity_needs_a_known_stop(make_trace):
    matrix = ProximityMatrix(("T",), ("A",), np.ones((1, 1)), np.full((1, 1), np.nan), "oracle")
    assert replace(make_trace(), proximity={0: matrix}).proximity[0] is matrix
    with pytest.raises(TraceError) as caught:
        replace(make_trace(), proximity={1: matrix})
    assert caught.value.numbers["stop_id"] == 1


def test_a_ready_made_proximity_without_anchors_cannot_be_stored(make_trace):
    matrix = ProximityMatrix(("T",), (), np.ones((1, 0)), np.ones((0, 0)), "oracle")
    with pytest.raises(TraceError, match="no anchor"):
        replace(make_trace(), proximity={0: matrix})


def test_a_trace_survives_the_trip_between_processes(make_trace):
    trace = _two_stops(make_trace)
    again = pickle.loads(pickle.dumps(trace))
    assert again.meta == trace.meta
    assert again.reads.equals(trace.reads)
    assert same_scan(again.scan(6), trace.scan(6))
    assert not again.antenna_poses.positions_m.flags.writeable


def test_free_form_schema_metadata_does_not_ride_along(make_trace):
    reads = make_trace().reads.replace_schema_metadata({"truth": "tag at 1, 2, 3"})
    assert _with_reads(make_trace(), reads).reads.schema.metadata is None


def test_an_estimator_sees_no_meta_and_no_unknown_column(make_trace):
    trace = make_trace()
    told = Trace(
        replace(trace.meta, unknown_json='{"truth": [1, 2, 3]}'),
        trace.reads.append_column("true_x_m", pa.array(np.arange(float(trace.reads.num_rows)))),
        trace.antenna_poses,
    )
    assert same_scan(told.scan(), trace.scan())
    for record in (Scan, ReadTrace, Observation):
        assert not {"meta", "truth", "unknown", "unknown_json", "metadata", "extra"} & {f.name for f in fields(record)}
