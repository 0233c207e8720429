from dataclasses import replace

import numpy as np
import pytest

from rfcompass.errors import TagNeverHeard
from rfcompass.localization.measuring import measure_proximities, with_known_heights
from rfcompass.types import Observation, ProximityMatrix, Scan, TagLayout, TagPositions

ANCHORS = TagPositions("base", ("A", "B"), np.array([[0.0, 0.0, 0.1], [1.0, 0.0, 0.2]]))
PART = TagLayout("leg", ("P",), ("part",), np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), ("part",))
STOP = Observation(3, ANCHORS, PART, np.array([0.025]))


class Listener:
    """A meter that keeps what it was given."""

    kind = "listener"

    def measure(self, scan, *, targets=(), anchors=None):
        self.scan = scan
        N = len(anchors)
        return ProximityMatrix(tuple(targets), tuple(anchors), np.ones((1, N)), np.full((N, N), np.nan), self.kind)


def test_a_meter_is_told_every_height_that_is_known():
    meter = Listener()
    assert measure_proximities(STOP, meter).kind == "listener"
    assert dict(meter.scan.heights_m) == {"A": 0.1, "B": 0.2, "P": 0.025}


def test_heights_that_the_scan_brings_stay():
    told = replace(STOP, scan=Scan(heights_m={"P": 0.5, "stray": 1.0}))
    assert dict(with_known_heights(told).heights_m) == {"A": 0.1, "B": 0.2, "P": 0.5, "stray": 1.0}


def test_ready_made_proximities_need_no_meter():
    ready = ProximityMatrix(("P",), ("A", "B"), np.ones((1, 2)), np.full((2, 2), np.nan), "told")
    assert measure_proximities(replace(STOP, proximity=ready)) is ready


def test_where_nobody_names_a_meter_auto_measures():
    with pytest.raises(TagNeverHeard):  # it looks for the tags, and the scan is empty
        measure_proximities(STOP)
