import numpy as np
import pytest

from rfcompass.rf.meters.phase_l1 import PhaseL1Meter
from rfcompass.rf.meters.phase_rms import PhaseRmsMeter
from rfcompass.types.reads import ReadTrace, Scan

POINTS_M = np.array([[0.3, 0.6, 0.0], [0.5, 0.6, 0.0], [0.8, 0.7, 0.0]])


def test_m_is_the_standard_deviation_of_the_difference_of_round_trips(make_scan):
    scan = make_scan(POINTS_M)
    path_m = scan.trace("e0").round_trip_m(POINTS_M)
    found = PhaseRmsMeter(smoothing_m=0.0).measure(scan).anchor_m[0, 1]
    assert found == pytest.approx((path_m[0] - path_m[1]).std(), rel=1e-9)
    assert PhaseRmsMeter().measure(scan).anchor_m[0, 1] == pytest.approx(found, rel=0.02)


def test_it_is_never_smaller_than_the_mean_deviation(make_scan):
    scan = make_scan(POINTS_M)
    l1 = PhaseL1Meter().measure(scan).anchor_m
    rms = PhaseRmsMeter(smoothing_m=0.0).measure(scan).anchor_m
    assert (rms >= l1 * (1 - 1e-9))[~np.isnan(l1)].all()


def test_a_slip_in_a_fade_does_not_turn_the_order(make_trace):
    """Two tags 5 cm apart, one with a fade in which the phase turns once; a third 25 cm away."""
    traces = [make_trace([x, 0.6, 0.0], epc=f"e{k}") for k, x in enumerate((0.40, 0.45, 0.65))]
    channel = traces[1].channel.copy()
    channel[38:42] *= 1e-2 * np.exp(2j * np.pi * np.array([0.2, 0.4, 0.6, 0.8]))[:, None]
    scan = Scan({"e0": traces[0], "e1": _with_channel(traces[1], channel), "e2": traces[2]})
    plain = Scan({trace.epc: trace for trace in traces})
    unsmoothed = PhaseRmsMeter(smoothing_m=0.0).measure(scan).anchor_m
    assert unsmoothed[0, 1] > 3 * PhaseRmsMeter().measure(plain).anchor_m[0, 1]
    smoothed = PhaseRmsMeter().measure(scan).anchor_m
    assert smoothed[0, 1] < 0.5 * unsmoothed[0, 1]
    assert smoothed[0, 1] < 0.5 * smoothed[0, 2]


def test_tags_that_were_never_heard_together_do_not_compare(make_trace):
    left = np.zeros((51, 3), dtype=bool)
    left[:20] = True
    traces = {k: make_trace(p, epc=k, heard=h) for k, p, h in (("a", POINTS_M[0], left), ("b", POINTS_M[1], ~left))}
    assert np.isnan(PhaseRmsMeter().measure(Scan(traces)).anchor_m).all()


def _with_channel(trace: ReadTrace, channel: np.ndarray) -> ReadTrace:
    return ReadTrace(
        trace.epc, trace.antenna_positions_m, trace.frequencies_hz, channel, trace.read_counts, trace.antenna_ports
    )
