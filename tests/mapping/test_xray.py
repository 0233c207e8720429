"""X-Ray's distribution: against poses tried one by one."""

import dataclasses

import numpy as np
import pytest
from box_scenes import Block, looking_down, see, square_scan, views_of

from rfcompass.errors import InputError
from rfcompass.mapping import map_views, xray_map, xray_occupancy
from rfcompass.types import Workspace

TARGET_M = np.array([0.06, 0.04, 0.025])
PILE = (Block((-0.08, 0.0, 0.04), (0.18, 0.16, 0.08), 0.3), Block((0.15, 0.05, 0.015), (0.14, 0.14, 0.03)))


def slowly(view, target_m, stride, yaws, slack_m=0.003):
    """Every pose as a block before the same camera, one image each."""
    total, rows, columns = np.zeros(view.depth_m.shape), *view.depth_m.shape
    K, T = view.intrinsics, view.T_world_camera
    for roll in range(3):
        size_m = np.roll(target_m, -roll)
        for yaw in np.pi * np.arange(yaws) / yaws:
            for v in range(0, rows, stride):
                for u in range(0, columns, stride):
                    ray = T[:3, :3] @ np.linalg.inv(K) @ [u, v, 1.0]
                    centre_m = T[:3, 3] + (size_m[2] / 2 - T[2, 3]) / ray[2] * ray
                    alone, own = see((Block(tuple(centre_m), tuple(size_m), yaw),), T, K, view.depth_m.shape)
                    own = own == 1
                    border = own[0].any() or own[-1].any() or own[:, 0].any() or own[:, -1].any()
                    hidden = ~(view.depth_m[own] > alone.depth_m[own] + slack_m).any()
                    total += own * (hidden and not border)
    return total / max(total.sum(), 1.0)


@pytest.mark.parametrize("tilt_rad", [0.0, 0.2])
def test_the_distribution_is_that_of_poses_tried_one_by_one(tilt_rad):
    view, _ = see(PILE, looking_down(0.0, 0.0, 0.7, tilt_rad, 0.4), shape=(36, 48))
    fast = xray_occupancy(view, TARGET_M, step_m=0.055, yaws=2)
    slow = slowly(view, TARGET_M, max(1, round(0.055 * view.intrinsics[0, 0] / 0.7)), 2)
    assert slow.any()
    assert np.abs(fast - slow).sum() < 1e-6


def test_it_lies_under_what_is_high_enough_and_sums_to_one():
    view, labels = see(PILE, looking_down(), shape=(120, 160))
    image = xray_occupancy(view, TARGET_M)
    assert np.isclose(image.sum(), 1.0)
    assert image[labels == 1].sum() > 0.8
    assert image[labels == 0].sum() < 0.02
    # The low block only hides the target where it lies flat.
    assert 0 < image[labels == 2].sum() < 0.2


def test_what_sees_all_hides_nothing_and_what_sees_nothing_there_may_hide_it():
    view, _ = see((), looking_down(), shape=(60, 80))
    assert not xray_occupancy(view, TARGET_M).any()
    depth_m = view.depth_m.copy()
    depth_m[20:40, 30:50] = np.nan
    image = xray_occupancy(dataclasses.replace(view, depth_m=depth_m), TARGET_M)
    assert np.isclose(image[20:40, 30:50].sum(), 1.0)


def test_many_views_know_it_from_above_with_one_layer():
    table = Workspace.between([-0.3, -0.25, 0.0], [0.3, 0.25, 0.2], 0.01)
    grid = xray_map(map_views(table, views_of(PILE, square_scan(), shape=(120, 160))), TARGET_M)
    assert grid.values.shape == (60, 50, 1)
    assert np.isclose(grid.values.sum(), 1.0)
    x, *_ = table.axes_m()
    assert grid.values[x < 0.04].sum() > 0.8
    empty = xray_map(map_views(table, views_of((), square_scan())), TARGET_M)
    assert not empty.values.any()


def test_wrong_lengths_are_named():
    view, _ = see(PILE, looking_down())
    with pytest.raises(InputError):
        xray_occupancy(view, TARGET_M, yaws=0)
    with pytest.raises(InputError):
        xray_occupancy(view, TARGET_M, 2.0)
    with pytest.raises(InputError):
        xray_occupancy(view, -TARGET_M)
