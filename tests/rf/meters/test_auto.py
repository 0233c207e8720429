import numpy as np

from rfcompass.rf.meters.auto import AutoMeter
from rfcompass.rf.meters.phase_rms import PhaseRmsMeter

POINTS_M = np.array([[0.3, 0.6, 0.0], [0.5, 0.6, 0.0], [0.9, 0.7, 0.0]])


def test_auto_says_which_meter_it_used(make_scan):
    scan = make_scan(POINTS_M)
    found, plain = AutoMeter().measure(scan, targets=["e1"]), PhaseRmsMeter().measure(scan, targets=["e1"])
    assert found.kind == "phase_rms"
    np.testing.assert_array_equal(found.m, plain.m)
