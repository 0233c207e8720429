import numpy as np
import pytest

from rfcompass.errors import TagNeverHeard
from rfcompass.rf.meters.auto import AutoMeter
from rfcompass.rf.meters.phase_rms import PhaseRmsMeter
from rfcompass.rf.meters.sar_nearfield import SarNearfieldMeter
from rfcompass.types.reads import Scan

POINTS_M = np.array([[0.3, 0.6, 0.0], [0.5, 0.6, 0.0], [0.9, 0.7, 0.0]])


def test_auto_takes_phase_rms_on_a_straight_path_and_says_so(make_scan):
    scan = make_scan(POINTS_M)
    found, plain = AutoMeter().measure(scan, targets=["e1"]), PhaseRmsMeter().measure(scan, targets=["e1"])
    assert found.kind == "phase_rms"
    np.testing.assert_array_equal(found.m, plain.m)


def test_auto_takes_sar_nearfield_where_the_path_spans_two_directions(make_scan, line):
    corner = np.concatenate([line()[::-1], line()[1:][:, [1, 0, 2]]])
    scan = Scan(make_scan(POINTS_M, corner).traces, heights_m={"e0": 0.0, "e1": 0.0, "e2": 0.0})
    found, plain = AutoMeter().measure(scan, targets=["e1"]), SarNearfieldMeter().measure(scan, targets=["e1"])
    assert found.kind == "sar_nearfield"
    np.testing.assert_array_equal(found.m, plain.m)


def test_an_empty_scan_is_no_answer():
    with pytest.raises(TagNeverHeard):
        AutoMeter().measure(Scan())
