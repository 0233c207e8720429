"""A red target in sight: found by colour, placed by depth."""

import colorsys
import dataclasses

import numpy as np
import pytest
from box_scenes import Block, looking_down, see
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError
from rfcompass.mapping import ColourRule, back_project, find_visible_target
from rfcompass.mapping.visible_target import hue_saturation_value, pixels_of_colour

RED, GREY = (210, 20, 30), (120, 120, 120)
POSE = looking_down(0.05, -0.02, 0.7, 0.2, 0.5)


@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_colours_convert_as_the_standard_library_does(rgb):
    hue_deg, saturation, value = hue_saturation_value(np.array(rgb))
    expected = colorsys.rgb_to_hsv(*(channel / 255 for channel in rgb))
    assert (hue_deg / 360, saturation, value) == pytest.approx(expected, abs=1e-9)


def test_red_is_red_on_both_sides_of_zero_and_pink_and_black_are_not():
    colours = np.array([[RED, (200, 30, 20), (255, 180, 190), (30, 2, 2), (20, 20, 200), (200, 120, 20)]])
    assert pixels_of_colour(colours).tolist() == [[True, True, False, False, False, False]]


@given(st.floats(-0.1, 0.1), st.floats(-0.08, 0.08), st.floats(0.03, 0.1))
def test_the_target_is_found_where_it_is(x_m, y_m, height_m):
    size_m = (0.08, 0.06, height_m)
    target = Block((x_m, y_m, height_m / 2), size_m, 0.3, RED)
    view, labels = see([Block((0.3, 0.2, 0.02), (0.1, 0.1, 0.04), 0.0, GREY), target], POSE, shape=(120, 160))
    found = find_visible_target(view)
    assert np.array_equal(found.pixels, labels == 2)
    c, s = np.cos(0.3), np.sin(0.3)
    dx, dy = (found.points_m - target.centre_m)[:, :2].T
    assert (np.abs(c * dx + s * dy) <= 0.04 + 1e-9).all()
    assert (np.abs(c * dy - s * dx) <= 0.03 + 1e-9).all()
    assert found.points_m[:, 2].max() == pytest.approx(height_m, abs=1e-9)


def test_the_largest_patch_counts_and_a_small_one_is_no_target():
    small, large = Block((0.2, 0, 0.03), (0.02, 0.02, 0.06), 0, RED), Block((-0.1, 0, 0.02), (0.1, 0.1, 0.04), 0, RED)
    view, labels = see([small, large], looking_down(), shape=(120, 160))
    assert np.array_equal(find_visible_target(view).pixels, labels == 2)
    assert find_visible_target(see([small], looking_down())[0]) is None
    assert find_visible_target(see([], looking_down())[0]) is None


def test_a_target_without_depth_is_seen_but_has_no_points():
    view, _ = see([Block((0, 0, 0.02), (0.2, 0.2, 0.04), 0, RED)], looking_down())
    blind = dataclasses.replace(view, depth_m=np.full(view.depth_m.shape, np.nan))
    assert find_visible_target(blind).points_m.shape == (0, 3)


def test_points_of_an_empty_view_lie_on_the_table():
    points_m = back_project(see([], POSE)[0])
    assert len(points_m) == 60 * 80
    assert np.abs(points_m[:, 2]).max() < 1e-12


def test_a_grey_camera_and_rules_out_of_range_are_refused():
    with pytest.raises(InputError, match="no colour"):
        find_visible_target(dataclasses.replace(see([], POSE)[0], colour=None))
    for wrong in ({"saturation": 2.0}, {"half_width_deg": 0.0}, {"least_pixels": 0}):
        with pytest.raises(InputError, match="out of range"):
            ColourRule(**wrong)
