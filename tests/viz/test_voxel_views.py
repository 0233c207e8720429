"""Voxel maps as figures, files and layers: they show the values that they were given."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError
from rfcompass.types import VoxelGrid
from rfcompass.viz.robot_scene import RobotScene
from rfcompass.viz.voxel_figures import draw_kernels, draw_maps
from rfcompass.viz.voxel_layers import MOST_POINTS, draw_voxels
from rfcompass.viz.voxel_ply import write_ply
from rfcompass.viz.voxel_points import voxel_points


def grid(seed=0, shape=(6, 5, 4)):
    rng = np.random.default_rng(seed)
    return VoxelGrid(np.array([0.1, -0.2, 0.01]), 0.02, rng.normal(size=shape) * (rng.random(shape) < 0.6))


@given(st.integers(0, 10**6), st.floats(0, 1))
def test_the_points_are_the_voxels_that_are_large_enough(seed, share):
    values = grid(seed).values
    shown = voxel_points(grid(seed), share)
    assert shown.count == len(shown.values) == ((values != 0) & (np.abs(values) >= share * np.abs(values).max())).sum()
    voxels = np.round((shown.points_m - [0.1, -0.2, 0.01]) / 0.02).astype(int)
    assert np.array_equal(values[tuple(voxels.T)], shown.values)
    assert (shown.rgb[shown.values > 0.1, 0] >= shown.rgb[shown.values > 0.1, 2]).all()
    assert (shown.rgb[shown.values < -0.1, 2] >= shown.rgb[shown.values < -0.1, 0]).all()


def test_of_too_many_points_the_largest_are_kept():
    some, all_ = voxel_points(grid(), 0.0, 10), voxel_points(grid(), 0.0)
    assert some.count == all_.count
    assert np.array_equal(np.sort(np.abs(some.values)), np.sort(np.abs(all_.values))[-10:])
    assert voxel_points(VoxelGrid(np.zeros(3), 0.01, np.zeros((2, 2, 2)))).count == 0
    for wrong in ((-0.1, None), (1.1, None), (0.5, 0)):
        with pytest.raises(InputError, match="out of range"):
            voxel_points(grid(), *wrong)


def test_a_ply_file_is_read_by_others(tmp_path):
    count = write_ply(tmp_path / "map.ply", grid())
    cloud = trimesh.load(tmp_path / "map.ply")
    expected = voxel_points(grid(), 0.0)
    assert count == expected.count
    assert cloud.vertices == pytest.approx(expected.points_m, abs=1e-6)
    assert cloud.metadata["_ply_raw"]["vertex"]["data"]["value"] == pytest.approx(expected.values, rel=1e-6)
    assert np.array_equal(cloud.colors[:, :3], np.round(255 * expected.rgb).astype(int))


def test_an_empty_map_is_an_empty_file(tmp_path):
    assert write_ply(tmp_path / "empty.ply", VoxelGrid(np.zeros(3), 0.01, np.zeros((2, 2, 2)))) == 0
    assert b"element vertex 0" in (tmp_path / "empty.ply").read_bytes()


def test_a_figure_of_maps_shows_the_strongest_from_above_and_the_cut():
    one, other = grid(1), grid(2)
    figure = draw_maps({"C": one, "R": other}, {"tag": np.array([0.14, -0.16, 0.03])}, y_m=-0.16)
    images = [axes.images[0] for axes in figure.axes if axes.images]
    above, upright = (np.asarray(image.get_array()).T for image in (images[0], images[2]))
    assert np.abs(above) == pytest.approx(np.abs(one.values).max(axis=2))
    assert np.array_equal(upright, one.values[:, 2])
    assert images[0].get_extent() == pytest.approx([0.09, 0.21, -0.21, -0.11])
    assert [axes.get_title(loc="left") for axes in figure.axes if axes.get_title(loc="left")] == ["C", "R"]


def test_without_a_cut_it_goes_through_the_strongest_voxel():
    values = np.zeros((4, 6, 3))
    values[1, 4, 2] = 1.0
    figure = draw_maps({"map": VoxelGrid(np.zeros(3), 0.1, values)})
    assert figure.axes[1].images[0].get_array().max() == 1.0


def test_a_figure_of_kernels_shares_one_scale_and_outlines_the_item():
    figure = draw_kernels({"rigid": grid(1), "pressed": grid(2)}, np.array([0.14, -0.16, 0.03]), np.array([0.1, 0.04]))
    limits = {axes.images[0].get_clim() for axes in figure.axes if axes.images}
    assert len(limits) == 1
    outline = figure.axes[0].patches[0]
    assert (outline.get_width(), outline.get_height()) == pytest.approx((0.1, 0.04))


def test_nothing_to_draw_and_cuts_beside_the_map_are_refused():
    with pytest.raises(InputError, match="no map"):
        draw_maps({})
    with pytest.raises(InputError, match="no kernel"):
        draw_kernels({}, np.zeros(3))
    with pytest.raises(InputError, match="misses the map"):
        draw_maps({"C": grid()}, y_m=5.0)


def test_a_layer_counts_all_voxels_and_sends_few():
    scene = RobotScene()
    layer = draw_voxels(scene, "C", "where nobody looked", VoxelGrid(np.zeros(3), 0.01, np.ones((50, 50, 40))))
    assert layer.count == 100_000
    assert layer.node == "voxels/C"
    sent = next(c for c in scene.window.commands if c["type"] == "set_object" and c["path"].endswith("voxels/C"))
    geometry = sent["object"]["geometries"][0]
    assert geometry["data"]["attributes"]["position"]["array"] is not None
    assert layer.count > MOST_POINTS
