"""What each baseline goes for, where their rules part."""

from dataclasses import replace

import numpy as np
import pytest
from box_scenes import Block, intrinsics, looking_down
from extraction_scenes import grasps_of, question

from planners.extraction import FuseBotPolicy, LargestMaskPolicy, MapMassPolicy, NaivePolicy, RandomPolicy, XRayPolicy
from planners.extraction.xray_policy import every_pixel
from rfcompass.errors import InputError
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView

# Under the flat wide one nothing of the target's size fits; under the high one it does.
FLAT, HIGH = Block((-0.12, 0.0, 0.005), (0.20, 0.16, 0.01)), Block((0.12, 0.0, 0.06), (0.12, 0.10, 0.12))
TARGET_M = np.array([0.06, 0.05, 0.04])


def with_better_grasp_beside(off_m):
    """The peak of the map is under the middle of the first block; a better grasp is so far off along the next axis."""
    blocks = (Block((0.0, 0.0, 0.02), (0.20, 0.16, 0.04)),)
    asked = question(blocks, mass=(5.0,), quality=(0.3,))
    points_m = points_image(asked.view)
    peak_m = asked.grid.origin_m[:2] + asked.grid.spacing_m * np.array(
        np.unravel_index(asked.grid.values.argmax(), asked.grid.values.shape)[:2]
    )
    wanted_m = peak_m + np.array([off_m, 0.0])
    pixel = np.unravel_index(np.linalg.norm(points_m[..., :2] - wanted_m, axis=2).argmin(), asked.masks.labels.shape)
    quality = asked.grasps.quality.copy()
    quality[pixel] = 0.9
    parts = asked.grid, asked.view, asked.masks, replace(asked.grasps, quality=quality)
    return parts, peak_m


@pytest.mark.parametrize(("off_m", "taken"), [(0.04, True), (0.06, False)])
def test_naive_takes_the_best_grasp_within_five_centimetres_of_the_likeliest_voxel(off_m, taken):
    parts, peak_m = with_better_grasp_beside(off_m)
    action = NaivePolicy().choose(*parts)
    away_m = np.linalg.norm(action.T_world_hand[:2, 3] - peak_m)
    assert away_m <= 0.05 + 1e-9
    assert (action.score == 0.9) == taken


def test_naive_with_the_gate_leaves_the_five_centimetres_for_a_grasp_above_tau():
    parts, peak_m = with_better_grasp_beside(0.08)
    near, far = (NaivePolicy(gate=gate).choose(*parts) for gate in (False, True))
    assert np.linalg.norm(near.T_world_hand[:2, 3] - peak_m) <= 0.05
    assert np.linalg.norm(far.T_world_hand[:2, 3] - peak_m) == pytest.approx(0.08, abs=0.01)


def test_x_ray_takes_what_the_target_fits_under_and_largest_what_is_widest():
    asked = question((FLAT, HIGH), mass=(5.0, 1.0), quality=(0.9, 0.9))
    assert XRayPolicy(target_m=TARGET_M).choose(*asked.parts()).mask_label == 2
    assert LargestMaskPolicy().choose(*asked.parts()).mask_label == 1
    assert MapMassPolicy().choose(*asked.parts()).mask_label == 1  # the map says so


def test_x_ray_with_the_gate_leaves_what_can_hardly_be_grasped():
    asked = question((FLAT, HIGH), mass=(5.0, 1.0), quality=(0.9, 0.9))
    grasps = grasps_of(asked.masks.labels, (0.9, 0.3))
    parts = asked.grid, asked.view, asked.masks, grasps
    assert [XRayPolicy(target_m=TARGET_M, gate=gate).choose(*parts).mask_label for gate in (False, True)] == [2, 1]


@pytest.mark.parametrize("gamma", [0.0, -0.5, 1.01, np.nan])
def test_a_discount_that_is_none_is_refused_where_it_is_given(gamma):
    with pytest.raises(InputError, match="gamma"):
        FuseBotPolicy(gamma=gamma)


@pytest.mark.parametrize("middle", [(-0.5, -0.5), (4.0, 3.0), (0.0, 0.0)])
def test_every_other_pixel_of_an_image_is_an_image(middle):
    K = intrinsics(4, 3)
    K[:2, 2] = middle
    half = every_pixel(DepthView(np.ones((3, 4)), K, looking_down()), 2)
    assert half.depth_m.shape == (2, 2)


@pytest.mark.parametrize("seed", [-1, 0.5, None])
def test_a_seed_that_is_none_is_refused_where_it_is_given(seed):
    with pytest.raises(InputError, match="seed"):
        RandomPolicy(seed=seed)
