from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest

from rfcompass.recordings import Stops, StrayTag, Trace, TraceTag, reads_table


def _with_phase(trace: Trace, phase_rad: np.ndarray) -> Trace:
    index = trace.reads.column_names.index("phase_rad")
    return replace(trace, reads=trace.reads.set_column(index, "phase_rad", pa.array(phase_rad)))


def test_every_read_is_counted_once(make_trace):
    trace = make_trace(tags=3, positions=5, frequencies=2, reads_per_cell=4)
    quality = trace.quality
    assert (quality.reads, quality.positions, quality.frequencies) == (120, 5, 2)
    assert [(tag.epc, tag.reads, tag.coverage) for tag in quality.tags] == [(epc, 40, 1.0) for epc in trace.epcs]
    assert quality.strays == quality.poses_without_reads == quality.stops_without_reads == ()


def test_strays_silent_tags_and_unused_poses_are_told_apart(make_trace):
    trace = make_trace(tags=2, positions=3, frequencies=1, reads_per_cell=2)
    trace = replace(
        trace,
        meta=replace(trace.meta, tags=(TraceTag("30080001"), TraceTag("FFFF"))),
        reads=trace.reads.filter(pa.compute.not_equal(trace.reads["pose_id"], 1)),
    )
    quality = trace.quality
    assert quality.strays == (StrayTag("30080000", 4),)
    assert quality.stray_reads == 4
    assert quality.silent_epcs == ("FFFF",)
    assert quality.poses_without_reads == ((1, 1),)
    assert quality.reads == 8


def test_coverage_is_the_share_of_cells_with_a_read(make_trace):
    trace = make_trace(tags=2, positions=4, frequencies=2, reads_per_cell=1)
    first_tag_at_pose_0 = pa.compute.and_(
        pa.compute.equal(trace.reads["epc"], "30080000"), pa.compute.equal(trace.reads["pose_id"], 0)
    )
    quality = replace(trace, reads=trace.reads.filter(pa.compute.invert(first_tag_at_pose_0))).quality
    assert [tag.coverage for tag in quality.tags] == [6 / 8, 1.0]


@pytest.mark.parametrize("modulus", ["2pi", "pi"])
def test_the_phase_spread_is_that_of_the_noise(make_trace, modulus):
    trace = make_trace(reads_per_cell=200, positions=3, phase_modulus=modulus)
    noise = np.random.default_rng(1).normal(0.0, 0.2, trace.reads.num_rows)
    pose = trace.reads["pose_id"].to_numpy()
    spread_rad = _with_phase(trace, (pose + noise) % (np.pi if modulus == "pi" else 2 * np.pi)).quality.phase_spread_rad
    assert spread_rad == pytest.approx(0.2, rel=0.1)


def test_flips_by_half_a_turn_are_found_in_their_cells(make_trace):
    trace = make_trace(tags=2, positions=5, frequencies=2, reads_per_cell=10)
    assert trace.quality.flip_share == 0.0
    phase_rad = trace.reads["phase_rad"].to_numpy().copy()
    phase_rad[[0, 10, 12]] += np.pi  # one read of cell 0, two of cell 1, all of tag 0
    quality = _with_phase(trace, phase_rad).quality
    assert quality.flip_share == 2 / 20
    assert [tag.flip_share for tag in quality.tags] == [2 / 10, 0.0]


def test_flips_of_a_reader_with_half_turn_ambiguity_are_not_observable(make_trace):
    quality = make_trace(phase_modulus="pi").quality
    assert quality.flip_share is None
    assert quality.tags[0].flip_share is None


def test_single_reads_say_nothing_about_scatter(make_trace):
    quality = make_trace(reads_per_cell=1).quality
    assert quality.phase_spread_rad is None
    assert quality.flip_share is None


def test_a_stop_without_reads_is_listed(make_trace):
    trace = make_trace()
    reads = trace.reads.append_column("stop_id", pa.array(np.full(trace.reads.num_rows, 2)))
    stops = Stops(np.array([2, 9]), np.zeros((2, 3)), (), np.zeros((2, 0)))
    assert replace(trace, reads=reads, stops=stops).quality.stops_without_reads == (9,)


def test_a_trace_without_reads_gets_a_report_too(make_trace):
    quality = replace(make_trace(positions=2), reads=reads_table([])).quality
    assert quality.silent_epcs == ("30080000", "30080001", "30080002")
    assert quality.poses_without_reads == ((0, 1), (1, 1))
    assert quality.phase_spread_rad is None
