"""The picture of a grasp map has the jaws where the hand puts them, whatever the camera's pose."""

import numpy as np
from box_scenes import Block, looking_down, see
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from planners.grasp_at_pixel import grasp_at_pixel
from rfcompass.mapping.camera import points_image
from rfcompass.types import GraspMaps
from rfcompass.viz.grasp_maps import draw_grasp_maps, draw_grasps, jaws_m

BOX = Block((0.02, -0.01, 0.03), (0.08, 0.06, 0.06))
SHAPE = (24, 32)
K = np.array([[40.0, 0, 15.5], [0, 40.0, 11.5], [0, 0, 1]])


def question(turn_rad, seed):
    view = see([BOX], looking_down(0.0, 0.0, 0.5, turn_rad=turn_rad), K, SHAPE)[0]
    rng = np.random.default_rng(seed)
    images = (rng.random(SHAPE), rng.uniform(-3, 3, SHAPE), rng.uniform(0.01, 0.08, SHAPE), np.full(SHAPE, 0.02))
    return view, GraspMaps(*images)


@given(st.floats(0, 6.28), st.integers(0, 99), st.integers(0, 23), st.integers(0, 31))
def test_the_jaws_close_on_both_sides_of_the_point_along_the_hands_closing(turn_rad, seed, row, column):
    view, maps = question(turn_rad, seed)
    left_m, right_m = jaws_m(view, maps, (row, column))
    T_world_hand, _ = grasp_at_pixel(view, maps, row, column)
    assert np.allclose((left_m + right_m) / 2, points_image(view)[row, column])
    assert np.allclose(right_m - left_m, maps.width_m[row, column] * T_world_hand[:3, 1])


def test_the_best_grasp_is_drawn_last_and_in_its_own_colour():
    view, maps = question(0.3, 1)
    axes = Figure().subplots()
    draw_grasps(axes, view, maps, [(3, 4), (10, 12), (20, 30)])
    colours = [line.get_color() for line in axes.lines]
    assert len(colours) == 3
    assert colours[0] == colours[1] != colours[2]
    middles = [np.mean(line.get_xydata(), axis=0) for line in axes.lines]
    assert np.allclose(middles[2], (4, 3), atol=1.0)
    assert np.allclose(middles[0], (30, 20), atol=1.0)


def test_without_a_grasp_the_picture_is_that_of_the_map():
    figure = draw_grasp_maps(*question(0.0, 2), [])
    assert not figure.axes[0].lines
