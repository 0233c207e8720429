"""From a pixel to the hand."""

import numpy as np
import pytest
from box_scenes import Block, looking_down, see

from planners.grasp_at_pixel import TIP_BEYOND_M, grasp_across, grasp_at_pixel
from rfcompass.errors import InputError
from rfcompass.robots import hand_of, load_robot
from rfcompass.types import GraspMaps

BLOCK = Block((0.05, -0.04, 0.03), (0.16, 0.06, 0.06), 0.6)


def seen(turn_rad=0.5):
    view, labels = see((BLOCK,), looking_down(0.02, 0.0, 0.7, 0.1, turn_rad), shape=(120, 160))
    return view, labels == 1


def maps_like(view, quality=0.5, angle=0.7, width=0.04, depth=0.02):
    return GraspMaps(*(np.full(view.depth_m.shape, number) for number in (quality, angle, width, depth)))


def test_the_hand_of_the_arm_is_the_one_that_is_meant():
    robot = load_robot("urdf/robots/ur5e_2f85.json")
    hand = hand_of(robot)
    assert hand.approach_axis.tolist() == [0, 0, 1]
    assert hand.closing_axis.tolist() == [0, 1, 0]
    assert np.isclose(hand.left.pads_m[:, 1, 1].max(), TIP_BEYOND_M)
    assert np.isclose(hand.greatest_m, 0.085)


@pytest.mark.parametrize("angle_rad", [-2.0, 0.0, 0.7])
def test_the_tips_go_below_the_point_that_the_pixel_shows_and_close_along_the_angle(angle_rad):
    view, pixels = seen()
    row, column = np.argwhere(pixels).mean(axis=0).astype(int)
    T, aperture_m = grasp_at_pixel(view, maps_like(view, angle=angle_rad), row, column)
    ray = np.linalg.inv(view.intrinsics) @ [column, row, 1.0] * view.depth_m[row, column]
    point_m = (view.T_world_camera @ np.append(ray, 1.0))[:3]
    assert np.isclose(point_m[2], 0.06)
    assert np.allclose((T @ [0, 0, TIP_BEYOND_M, 1])[:3], point_m - [0, 0, 0.02])
    assert np.allclose(T[:3, 1], [np.cos(angle_rad), np.sin(angle_rad), 0])
    assert np.allclose(T[:3, 2], [0, 0, -1])
    assert np.isclose(np.linalg.det(T[:3, :3]), 1)
    assert aperture_m == pytest.approx(0.06)


def test_the_jaws_open_no_wider_than_they_can():
    view, pixels = seen()
    row, column = np.argwhere(pixels)[0]
    assert grasp_at_pixel(view, maps_like(view, width=0.08), row, column)[1] == 0.085


def test_without_a_good_pixel_an_object_is_gripped_across_its_shorter_side():
    view, pixels = seen()
    T, aperture_m = grasp_across(view, pixels, 0.0)
    assert abs(T[:3, 1] @ [-np.sin(0.6), np.cos(0.6), 0]) > 0.98
    assert np.allclose(T[:2, 3], BLOCK.centre_m[:2], atol=0.01)
    assert np.isclose(T[2, 3] - TIP_BEYOND_M, 0.06 - 0.025)
    assert 0.07 < aperture_m <= 0.085


def test_the_tips_stay_above_the_table():
    view, labels = see((Block((0.0, 0.0, 0.006), (0.1, 0.05, 0.012)),), looking_down())
    T, _ = grasp_across(view, labels == 1, 0.0)
    assert np.isclose(T[2, 3] - TIP_BEYOND_M, 0.005)


def test_a_pixel_without_depth_is_refused():
    view, pixels = seen()
    blind = type(view)(np.where(pixels, np.nan, view.depth_m), view.intrinsics, view.T_world_camera)
    row, column = np.argwhere(pixels)[0]
    with pytest.raises(InputError):
        grasp_at_pixel(blind, maps_like(view), row, column)
    with pytest.raises(InputError):
        grasp_across(blind, pixels, 0.0)
