import numpy as np
import pytest

from rfcompass.rf.dtw import dtw
from rfcompass.rf.meters.phase_dtw import PhaseDtwMeter

POINTS_M = np.array([[0.3, 0.6, 0.0], [0.5, 0.6, 0.0], [0.8, 0.7, 0.0]])


@pytest.mark.parametrize(("band_share", "band"), [(None, None), (0.1, 5)])
def test_m_is_the_warping_distance_of_the_round_trips_less_their_medians(make_scan, band_share, band):
    scan = make_scan(POINTS_M)
    a, b = scan.trace("e0").round_trip_m(POINTS_M[:2])
    found = PhaseDtwMeter(smoothing_m=0.0, band_share=band_share).measure(scan).anchor_m[0, 1]
    assert found == pytest.approx(dtw(a - np.median(a), b - np.median(b), band=band), rel=1e-9)


def test_a_wider_band_never_enlarges_m(make_scan):
    scan = make_scan(POINTS_M)
    narrow, wide = (PhaseDtwMeter(band_share=share).measure(scan).anchor_m for share in (0.02, 0.3))
    off_diagonal = ~np.eye(3, dtype=bool)
    assert (wide <= narrow + 1e-12)[off_diagonal].all()
    assert (wide < narrow)[off_diagonal].any()


def test_two_ports_are_warped_one_by_one(make_scan, line):
    ports = np.repeat([1, 2], [26, 25])
    meter = PhaseDtwMeter(smoothing_m=0.0)
    both = meter.measure(make_scan(POINTS_M, line(), ports=ports)).anchor_m[0, 1]
    first, second = (meter.measure(make_scan(POINTS_M, line()[ports == port].copy())).anchor_m[0, 1] for port in (1, 2))
    assert both == pytest.approx((first + second) / 2)
