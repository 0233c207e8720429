"""What every segmenter obeys, ours, a network's, and the errors that a network may make."""

import dataclasses

import numpy as np
import pytest
from box_scenes import Block, looking_down, see

from rfcompass.errors import InputError, ShapeError
from rfcompass.interfaces import Segmenter
from rfcompass.mapping import DepthSegmenter, NetworkSegmenter, labels_of_masks

APART = [Block((-0.15, 0.0, 0.03), (0.12, 0.1, 0.06), 0.3), Block((0.15, 0.05, 0.05), (0.1, 0.14, 0.1), -0.4)]


def near_labels(depth_m):
    """Stands for a network: one object wherever something is near."""
    return (np.nan_to_num(depth_m, nan=9.0) < 0.68).astype(np.int64)


SEGMENTERS = [DepthSegmenter(), NetworkSegmenter(near_labels)]


@pytest.mark.parametrize("segmenter", SEGMENTERS, ids=lambda s: type(s).__name__)
def test_a_segmenter_labels_every_pixel_and_leaves_an_empty_table_empty(segmenter):
    assert isinstance(segmenter, Segmenter)
    view, _ = see(APART, looking_down(height_m=0.7), shape=(120, 160))
    masks = segmenter.segment(view)
    assert masks.labels.shape == view.depth_m.shape
    assert masks.count >= 1
    assert segmenter.segment(see([], looking_down(height_m=0.7))[0]).count == 0
    assert np.array_equal(masks.labels, segmenter.segment(view).labels)


@pytest.mark.parametrize("segmenter", SEGMENTERS, ids=lambda s: type(s).__name__)
def test_a_view_without_any_depth_has_no_objects(segmenter):
    view, _ = see(APART, looking_down(height_m=0.7))
    assert segmenter.segment(dataclasses.replace(view, depth_m=np.full(view.depth_m.shape, np.nan))).count == 0


def best_overlap(labels, truth, number):
    own = truth == number
    return max((own & (labels == k)).sum() / (own | (labels == k)).sum() for k in np.unique(labels) if k)


@pytest.mark.parametrize("tilt_rad", [0.0, 0.25])
def test_blocks_apart_are_told_apart_whatever_side_one_sees(tilt_rad):
    view, truth = see(APART, looking_down(0.0, 0.0, 0.7, tilt_rad), shape=(240, 320))
    labels = DepthSegmenter().segment(view).labels
    assert len(np.unique(labels)) == 3
    assert min(best_overlap(labels, truth, n) for n in (1, 2)) > 0.9


def test_a_block_on_another_is_one_of_two():
    pile = [Block((0, 0, 0.03), (0.25, 0.2, 0.06)), Block((0.02, 0, 0.08), (0.1, 0.08, 0.04), 0.5)]
    view, truth = see(pile, looking_down(0, 0, 0.7, 0.2), shape=(240, 320))
    labels = DepthSegmenter().segment(view).labels
    assert min(best_overlap(labels, truth, n) for n in (1, 2)) > 0.8


def test_a_slope_is_no_step():
    """A camera that looks aslant sees the table recede by more than a step from pixel to pixel."""
    view, _ = see([Block((0.0, 0.0, 0.01), (0.4, 0.4, 0.02))], looking_down(0, -0.5, 0.5, 0.7), shape=(60, 80))
    assert np.abs(np.diff(view.depth_m, axis=0)).max() > DepthSegmenter().step_m
    assert DepthSegmenter().segment(view).count == 1


def test_noise_of_a_depth_camera_does_not_break_objects_up():
    view, truth = see(APART, looking_down(0.0, 0.0, 0.7), shape=(240, 320))
    noise = np.random.default_rng(0).normal(0, 0.0015, view.depth_m.shape)
    labels = DepthSegmenter().segment(dataclasses.replace(view, depth_m=view.depth_m + noise)).labels
    assert min(best_overlap(labels, truth, n) for n in (1, 2)) > 0.85


def test_an_image_smaller_than_the_neighbourhood_is_refused():
    with pytest.raises(InputError, match="too small"):
        DepthSegmenter().segment(see([], looking_down(), shape=(4, 80))[0])


def test_a_network_cannot_change_the_view_and_its_wrong_answers_are_named():
    view, _ = see(APART, looking_down())

    def vandal(depth_m):
        depth_m[:] = 1.0
        return np.zeros(depth_m.shape, np.int64)

    before = view.depth_m.copy()
    NetworkSegmenter(vandal).segment(view)
    assert np.array_equal(view.depth_m, before)
    with pytest.raises(ShapeError, match=r"shape \(3, 3\)"):
        NetworkSegmenter(lambda _: np.zeros((3, 3), np.int64)).segment(view)
    with pytest.raises(ShapeError):
        NetworkSegmenter(lambda d: np.full(d.shape, 0.5)).segment(view)
    with pytest.raises(ShapeError, match="negative"):
        NetworkSegmenter(lambda d: np.full(d.shape, -1)).segment(view)


def test_of_overlapping_masks_the_first_wins():
    one, two = np.zeros((2, 3), bool), np.ones((2, 3), bool)
    one[0, 0] = True
    assert labels_of_masks([one, two], (2, 3)).tolist() == [[1, 2, 2], [2, 2, 2]]
    assert not labels_of_masks([], (2, 3)).any()
    with pytest.raises(ShapeError, match="mask 1"):
        labels_of_masks([np.zeros((4, 4), bool)], (2, 3))
