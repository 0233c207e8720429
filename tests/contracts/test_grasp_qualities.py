"""What every way to score grasps obeys, ours and a network's."""

import dataclasses

import numpy as np
import pytest
from box_scenes import Block, looking_down, see

from planners.grasp_network import NetworkGraspQuality, ggcnn_network
from planners.grasp_quality import AntipodalQuality
from rfcompass.errors import InputError
from rfcompass.interfaces import GraspQuality

APART = [Block((-0.1, 0.0, 0.03), (0.09, 0.05, 0.06), 0.3), Block((0.1, 0.05, 0.04), (0.06, 0.06, 0.08), -0.4)]


def near_is_good(depth_m):
    """Stands for a network: whatever is near can be grasped along the rows."""
    near = np.nan_to_num(depth_m, nan=9.0) < 0.66
    return near * 0.5, np.zeros(depth_m.shape), np.full(depth_m.shape, 20.0)


def anywhere(depth_m):
    """Stands for a network that answers everywhere, as GG-CNN does."""
    return np.full(depth_m.shape, 0.5), np.zeros(depth_m.shape), np.full(depth_m.shape, 20.0)


def forward(image):
    """A GG-CNN of 60 x 60 pixels that likes all it sees alike: quality, cos, sin, width."""
    return [np.full(image.shape, value) for value in (0.5, 1.0, 0.0, 0.2)]


QUALITIES = {
    "antipodal": AntipodalQuality(),
    "network": NetworkGraspQuality(network=near_is_good),
    "network anywhere": NetworkGraspQuality(network=anywhere),
    "ggcnn": NetworkGraspQuality(network=ggcnn_network(forward, 60)),
}
named = pytest.mark.parametrize("quality", QUALITIES.values(), ids=QUALITIES)


@named
def test_each_pixel_of_the_view_gets_a_grasp_and_the_table_none(quality):
    assert isinstance(quality, GraspQuality)
    view, labels = see(APART, looking_down(height_m=0.7), shape=(120, 160))
    maps = quality.quality(view)
    assert maps.quality.shape == view.depth_m.shape
    assert maps.quality[labels == 1].max() > 0.3
    assert not maps.quality[labels == 0].any()
    assert not quality.quality(see([], looking_down(height_m=0.7))[0]).quality.any()


@named
def test_a_view_without_any_depth_has_no_grasp(quality):
    view, _ = see(APART, looking_down(height_m=0.7))
    blind = dataclasses.replace(view, depth_m=np.full(view.depth_m.shape, np.nan))
    assert not quality.quality(blind).quality.any()


@named
def test_a_grasp_stays_above_the_table_and_within_the_surface(quality):
    view, labels = see(APART, looking_down(height_m=0.7), shape=(120, 160))
    maps = quality.quality(view)
    good = maps.quality > 0
    assert (maps.depth_m[good] > 0).all()
    assert (0.7 - view.depth_m[good] - maps.depth_m[good] > 0).all()
    assert (labels[good] > 0).all()


@named
def test_a_table_at_another_height_has_no_grasp_either(quality):
    raised = [dataclasses.replace(block, centre_m=np.add(block.centre_m, (0, 0, 0.75))) for block in APART]
    view, labels = see(raised, looking_down(height_m=1.45), shape=(120, 160), table_m=0.75)
    maps = dataclasses.replace(quality, table_m=0.75).quality(view)
    assert maps.quality[labels == 1].max() > 0.3
    assert not maps.quality[labels == 0].any()


@named
def test_equal_views_give_equal_bits(quality):
    view, _ = see(APART, looking_down(height_m=0.7))
    first, second = quality.quality(view), quality.quality(view)
    assert all(np.array_equal(getattr(first, name), getattr(second, name)) for name in first.__slots__)


@named
def test_a_camera_that_looks_up_sees_no_grasp_from_above(quality):
    view, _ = see(APART, looking_down(height_m=0.7))
    up = view.T_world_camera @ np.diag([1.0, -1.0, -1.0, 1.0])
    with pytest.raises(InputError, match="rises by 90 degrees"):
        quality.quality(dataclasses.replace(view, T_world_camera=up))
    with pytest.raises(InputError, match="below the table"):
        dataclasses.replace(quality, table_m=0.75).quality(view)


@named
@pytest.mark.parametrize("dtype", [np.float64, np.uint16])
def test_depths_in_millimetres_are_refused(quality, dtype):
    view, _ = see(APART, looking_down(height_m=0.7))
    with pytest.raises(InputError, match="millimetres") as refusal:
        quality.quality(dataclasses.replace(view, depth_m=(1000 * view.depth_m).astype(dtype)))
    assert refusal.value.numbers["median_m"] == pytest.approx(700.0)
