import numpy as np
import pytest

from rfcompass.rf.meters.phase_l1 import PhaseL1Meter
from rfcompass.types.reads import Scan

POINTS_M = np.array([[0.3, 0.6, 0.0], [0.5, 0.6, 0.0], [0.8, 0.7, 0.0]])


def test_m_is_the_mean_deviation_of_the_difference_of_round_trips(make_scan):
    scan = make_scan(POINTS_M)
    path_m = scan.trace("e0").round_trip_m(POINTS_M)
    gap_m = path_m[0] - path_m[1]
    expected = np.abs(gap_m - np.median(gap_m)).mean()
    assert PhaseL1Meter().measure(scan).anchor_m[0, 1] == pytest.approx(expected, rel=1e-9)


def test_only_cells_in_which_both_were_heard_count(make_trace):
    left, right = np.zeros((51, 3), dtype=bool), np.zeros((51, 3), dtype=bool)
    left[:30], right[20:] = True, True
    traces = [
        make_trace(p, epc=f"e{k}", heard=h) for k, (p, h) in enumerate(zip(POINTS_M, (left, right), strict=False))
    ]
    gap_m = np.diff(traces[0].round_trip_m(POINTS_M[:2])[:, 20:30], axis=0)[0]
    expected = np.abs(gap_m - np.median(gap_m)).mean()
    assert PhaseL1Meter().distances(traces)[0, 1] == pytest.approx(expected, rel=1e-6)


def test_tags_that_were_never_heard_together_do_not_compare(make_trace):
    left = np.zeros((51, 3), dtype=bool)
    left[:20] = True
    traces = {k: make_trace(p, epc=k, heard=h) for k, p, h in (("a", POINTS_M[0], left), ("b", POINTS_M[1], ~left))}
    assert np.isnan(PhaseL1Meter().measure(Scan(traces)).anchor_m).all()
