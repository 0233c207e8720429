"""The confidence box is the extent of the region around the peak, and says when it is cut off."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.localization.confidence_box import ConfidenceBox, confidence_box, is_confident
from rfcompass.rf.peak_search import Peak
from rfcompass.types import SearchVolume

FIELD = SearchVolume([-1.0, -1.0, 0.0], [1.0, 1.0, 0.0])


def ridge(centre_m, widths_m):
    """A Gaussian hill with its own width along each axis; full width at 0.84 of the peak is 2 w √(-ln 0.84)."""
    return lambda points_m: np.exp(-(((points_m - centre_m) / widths_m) ** 2).sum(axis=1))


@given(st.floats(0.02, 0.4), st.floats(0.02, 0.4))
def test_the_box_of_a_hill_is_its_width_along_each_axis(width_x, width_y):
    widths_m = np.array([width_x, width_y, 1.0])
    box = confidence_box(ridge(np.zeros(3), widths_m), FIELD, Peak(np.zeros(3), 1.0))
    expected_m = 2 * np.sqrt(-np.log(0.84)) * widths_m
    assert not box.clipped
    assert (np.abs(box.extent_m - expected_m)[:2] < 0.2 * expected_m[:2] + 0.01).all()
    assert box.extent_m[2] == 0.0


@given(st.floats(0.5, 0.9), st.floats(0.01, 0.09))
def test_a_lower_threshold_never_shrinks_the_box(threshold, less):
    hill, peak = ridge(np.zeros(3), np.array([0.1, 0.2, 1.0])), Peak(np.zeros(3), 1.0)
    high, low = (confidence_box(hill, FIELD, peak, t).extent_m for t in (threshold, threshold - less))
    assert (low >= high - 0.01).all()


def test_a_second_hill_elsewhere_is_not_part_of_the_box():
    one, other = ridge(np.zeros(3), np.full(3, 0.05)), ridge(np.array([0.5, 0.0, 0.0]), np.full(3, 0.05))
    box = confidence_box(lambda p: one(p) + 0.95 * other(p), FIELD, Peak(np.zeros(3), 1.0))
    assert box.extent_m[0] < 0.1


def test_a_hill_at_the_border_is_clipped_there():
    centre_m = np.array([1.0, 0.0, 0.0])
    box = confidence_box(ridge(centre_m, np.full(3, 0.2)), FIELD, Peak(centre_m, 1.0))
    assert box.clipped
    assert not is_confident(box)


def test_a_flat_power_gives_the_whole_volume():
    box = confidence_box(lambda points_m: np.ones(len(points_m)), FIELD, Peak(np.zeros(3), 1.0))
    assert box.extent_m.tolist() == [2.0, 2.0, 0.0]
    assert box.clipped


def test_every_axis_has_its_own_threshold():
    box = ConfidenceBox(np.array([0.1, 0.3, 0.0]), clipped=False)
    assert is_confident(box, (0.2, 0.4, 0.1))
    assert not is_confident(box, (0.2, 0.3, 0.1))
    assert not is_confident(ConfidenceBox(box.extent_m, clipped=True), (1.0, 1.0, 1.0))
