import numpy as np
import pytest

from rfcompass.rf.meters.rssi import RssiMeter

POINTS_M = np.array([[0.3, 0.6, 0.0], [0.5, 0.6, 0.0], [0.9, 0.7, 0.0]])


def test_in_free_space_m_is_the_mean_difference_of_squared_distances(make_scan):
    scan = make_scan(POINTS_M)
    squared_m2 = (scan.trace("e0").round_trip_m(POINTS_M) / 2) ** 2
    found = RssiMeter().measure(scan).anchor_m[0, 1]
    assert found == pytest.approx(np.abs(squared_m2[0] - squared_m2[1]).mean(), rel=1e-9)


def test_left_and_right_of_the_middle_are_told_apart_although_equally_loud_on_average(make_scan):
    scan = make_scan([[0.3, 0.6, 0.0], [0.7, 0.6, 0.0], [0.35, 0.6, 0.0]])
    m = RssiMeter().measure(scan).anchor_m
    assert m[0, 1] > 3 * m[0, 2]


def test_only_cells_in_which_both_were_heard_count(make_scan):
    heard = np.random.default_rng(0).random((51, 3)) < 0.5
    scan = make_scan(POINTS_M, heard=heard)
    gap = np.abs(np.diff(1 / np.abs([scan.trace(e).channel[heard] for e in ("e0", "e1")]), axis=0))
    assert RssiMeter().measure(scan).anchor_m[0, 1] == pytest.approx(gap.mean())
