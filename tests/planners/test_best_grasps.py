"""The best grasps of an image: best first, apart from each other, none left that is better."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from standing_boxes import Upright, look

from planners.best_grasps import best_grasps
from planners.grasp_at_pixel import grasp_at_pixel
from planners.grasp_quality import AntipodalQuality
from rfcompass.errors import InputError, ShapeError
from rfcompass.mapping.camera import points_image
from rfcompass.types import GraspMaps

VIEW = look(Upright(), shape=(18, 32))


def maps_of(quality):
    flat = np.zeros(quality.shape)
    return GraspMaps(quality, flat, flat + 0.04, flat + 0.02)


@given(st.integers(0, 2**32), st.integers(1, 12), st.floats(0.0, 0.2))
def test_they_are_the_greedy_ones_and_lie_apart(seed, count, apart_m):
    rng = np.random.default_rng(seed)
    maps = maps_of(rng.random((18, 32)) * (rng.random((18, 32)) < 0.2))
    grasps = best_grasps(VIEW, maps, count, apart_m)
    places = np.array([points_image(VIEW)[grasp.row, grasp.column, :2] for grasp in grasps]).reshape(-1, 2)
    left = maps.quality.copy()
    for place, grasp in zip(places, grasps, strict=True):
        assert grasp.quality == maps.quality[grasp.row, grasp.column] == left.max() > 0
        T_world_hand, aperture_m = grasp_at_pixel(VIEW, maps, grasp.row, grasp.column)
        assert np.array_equal(grasp.T_world_hand, T_world_hand)
        assert grasp.aperture_m == aperture_m
        left[np.linalg.norm(points_image(VIEW)[..., :2] - place, axis=2) < apart_m] = 0
        left[grasp.row, grasp.column] = 0
    assert len(grasps) == count or left.max() == 0
    off_m = np.linalg.norm(places[:, None] - places[None], axis=2) + np.where(np.eye(len(places)), np.inf, 0.0)
    assert off_m.min(initial=np.inf) >= apart_m


def test_two_things_give_two_grasps():
    view = look(Upright(x_m=-0.08), Upright(x_m=0.08), shape=(90, 160))
    first, second = best_grasps(view, AntipodalQuality().quality(view), 2, apart_m=0.1)
    assert sorted(np.sign([first.T_world_hand[0, 3], second.T_world_hand[0, 3]])) == [-1, 1]
    assert first.quality >= second.quality > 0


def test_where_nothing_was_seen_there_is_no_grasp():
    depth_m = VIEW.depth_m.copy()
    depth_m[3, 4] = np.nan
    quality = np.zeros(depth_m.shape)
    quality[3, 4] = 1.0
    view = type(VIEW)(depth_m, VIEW.intrinsics, VIEW.T_world_camera)
    assert best_grasps(view, maps_of(quality)) == ()


@pytest.mark.parametrize("more", [{"count": 0}, {"count": 1.5}, {"apart_m": -0.1}, {"apart_m": np.nan}])
def test_numbers_that_are_none_are_refused(more):
    with pytest.raises(InputError):
        best_grasps(VIEW, maps_of(np.zeros((18, 32))), **more)


def test_maps_of_another_image_are_refused():
    with pytest.raises(ShapeError):
        best_grasps(VIEW, maps_of(np.zeros((18, 31))))
