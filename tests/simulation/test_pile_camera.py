"""The depth camera: rays meet what MuJoCo's single rays meet, noise is as stated, and truth stays inside."""

import dataclasses

import numpy as np
import pytest
from pile_scenes import RED, at, inside, is_red, item, one_of_each, tiny, world_of

from rfcompass.errors import CameraBlocked, PileError
from rfcompass.interfaces import DepthSource
from rfcompass.mapping import map_views
from rfcompass.simulation.piles import (
    D415,
    NO_DEPTH_NOISE,
    NO_POSE_NOISE,
    CameraModel,
    DepthNoise,
    PileCamera,
    PileWorld,
    PoseNoise,
    cast_image,
    look_down,
    scan_poses,
    sights,
)
from rfcompass.simulation.piles.camera import beside_edges
from rfcompass.types import DepthView, Workspace

mujoco = pytest.importorskip("mujoco", reason="the extra `piles` is not installed")
SMALL = CameraModel(width=96, height=54)


def clean(world, seed=0, **more):
    rng = np.random.default_rng(seed)
    return PileCamera(
        world, rng, **{"camera": SMALL, "depth_noise": NO_DEPTH_NOISE, "pose_noise": NO_POSE_NOISE, **more}
    )


def points_of(view):
    """Points of all pixels in the world, shape (H, W, 3)."""
    v, u = np.indices(view.depth_m.shape)
    K = view.intrinsics
    rays = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones_like(u)], axis=-1)
    return (rays * view.depth_m[..., None]) @ view.T_world_camera[:3, :3].T + view.T_world_camera[:3, 3]


def test_the_field_of_view_is_as_stated():
    K = D415.intrinsics
    assert np.degrees(2 * np.arctan(D415.width / 2 / K[0, 0])) == pytest.approx(65)
    assert np.degrees(2 * np.arctan(D415.height / 2 / K[1, 1])) == pytest.approx(40)


def test_an_empty_table_is_as_far_as_the_camera_is_high():
    view, masks = clean(PileWorld()).view_and_masks()
    assert view.depth_m == pytest.approx(np.full(view.depth_m.shape, 0.7))
    assert masks.count == 0


@pytest.mark.parametrize("T", [look_down(0, 0, 0.7), scan_poses()[0]], ids=["above", "corner"])
def test_every_ray_meets_what_mujocos_single_ray_meets(T):
    world = tiny().world()
    image = cast_image(world, SMALL, T)
    rays = SMALL.directions() @ T[:3, :3].T
    for v, u in np.random.default_rng(0).integers(0, (SMALL.height, SMALL.width), (400, 2)):
        geom = np.full(1, -1, dtype=np.int32)
        depth = mujoco.mj_ray(world.model, world.data, T[:3, 3], rays[v, u], None, 1, -1, geom)
        assert image.depth_m[v, u] == pytest.approx(depth, abs=1e-9)
        assert image.numbers[v, u] == world.geom_numbers[geom[0]]


def test_what_a_pixel_shows_is_on_the_surface_of_the_item_it_is_said_to_be():
    world = one_of_each()
    camera = clean(world)
    camera.move_to(look_down(-0.1, 0, 0.7))
    view, masks = camera.view_and_masks()
    points = points_of(view)
    assert set(np.unique(masks.labels)) == {0, 1, 2, 3, 4, 5}
    for thing in world.items:
        seen = points[masks.labels == thing.number]
        gaps = [inside(thing, (seen - T[:3, 3]) @ T[:3, :3]) for T in world.panel_poses(thing.number)]
        assert np.abs(np.min(gaps, axis=0)).max() < 1e-6, thing.name
    assert np.abs(points[masks.labels == 0][:, 2]).max() < 1e-9


def test_only_the_target_looks_red():
    world = world_of((item(1, rgb=RED), at(0, 0, 0.02)), (item(2), at(0.15, 0, 0.02)))
    view, masks = clean(world).view_and_masks()
    red = np.array([[is_red(rgb) for rgb in row] for row in view.colour])
    assert (red == (masks.labels == 1)).all()
    assert red.any()


def test_a_camera_is_a_depth_source_and_hands_out_nothing_but_the_record():
    camera = clean(tiny().world())
    assert isinstance(camera, DepthSource)
    view = camera.view()
    assert type(view) is DepthView
    assert {field.name for field in dataclasses.fields(view)} == {"depth_m", "intrinsics", "T_world_camera", "colour"}
    assert not [
        name for name in dir(camera) if not name.startswith("_") and name not in ("move_to", "view", "view_and_masks")
    ]


def test_the_pose_handed_out_is_the_believed_one_and_the_image_is_taken_beside_it():
    world = world_of((item(1), at(0, 0, 0.02)))
    off = clean(world, pose_noise=PoseNoise(hand_eye_m=0.05, hand_eye_rad=0.0)).view()
    true = clean(world).view()
    assert np.array_equal(off.T_world_camera, true.T_world_camera)
    assert not np.array_equal(off.depth_m, true.depth_m)


def test_what_the_calibration_got_wrong_stays_and_the_rest_changes_from_view_to_view():
    world = PileWorld()
    steady = clean(world, pose_noise=PoseNoise(0.01, 0.01, 0.0, 0.0))
    assert np.array_equal(steady.view().depth_m, steady.view().depth_m)
    shaky = clean(world, pose_noise=PoseNoise(0.0, 0.0, 0.01, 0.01))
    assert not np.array_equal(shaky.view().depth_m, shaky.view().depth_m)


@pytest.mark.parametrize("height_m", [0.5, 1.0])
def test_depth_scatters_as_stereo_does(height_m):
    noise = dataclasses.replace(NO_DEPTH_NOISE, disparity_px=0.08)
    camera = clean(PileWorld(), depth_noise=noise, camera=D415)
    camera.move_to(look_down(0, 0, height_m))
    scatter_m = np.std(camera.view().depth_m - height_m)
    assert scatter_m == pytest.approx(height_m**2 * 0.08 / (1005 * 0.055), rel=0.02)


def test_depths_are_whole_steps():
    depth_m = PileCamera(tiny().world(), np.random.default_rng(0), SMALL).view().depth_m
    steps = depth_m[np.isfinite(depth_m)] / 0.001
    assert np.abs(steps - np.round(steps)).max() < 1e-6


def test_nothing_nearer_than_the_least_range_is_seen():
    camera = clean(PileWorld(), depth_noise=NO_DEPTH_NOISE)
    camera.move_to(look_down(0, 0, 0.29))
    assert np.isnan(camera.view().depth_m).all()


def test_lost_pixels_are_beside_edges():
    world = one_of_each()
    view = clean(world, depth_noise=dataclasses.replace(NO_DEPTH_NOISE, edge_lost=1.0)).view()
    edges = beside_edges(cast_image(world, SMALL, look_down(0, 0, 0.7)).depth_m, 0.015)
    assert edges.any()
    assert (np.isnan(view.depth_m) == edges).all()


def test_an_edge_has_two_sides():
    depth_m = np.array([[1.0, 1.0, 2.0, 2.0]])
    assert beside_edges(depth_m, 0.5).tolist() == [[False, True, True, False]]
    assert beside_edges(depth_m.T, 0.5).ravel().tolist() == [False, True, True, False]


def test_equal_seeds_take_equal_images():
    one, two = (PileCamera(tiny().world(), np.random.default_rng(7), SMALL).view() for _ in range(2))
    assert np.array_equal(one.depth_m, two.depth_m, equal_nan=True)
    assert np.array_equal(one.colour, two.colour)


def test_a_scan_goes_round_a_square_and_looks_down():
    poses = scan_poses((0.1, -0.1), half_m=0.2, height_m=0.6)
    assert np.abs(poses[:, :2, 3] - [0.1, -0.1]).max(axis=1) == pytest.approx(0.2)
    assert len({tuple(place) for place in poses[:, :3, 3].round(6).tolist()}) == 8
    assert poses[:, 2, 3] == pytest.approx(0.6)
    assert poses[:, :3, 2] == pytest.approx(np.tile([0, 0, -1.0], (8, 1)))
    assert np.linalg.det(poses[:, :3, :3]) == pytest.approx(1)


def test_an_item_that_stands_alone_is_seen_whole_and_what_covers_it_hides_it():
    low, roof = item(1), item(2, size_m=(0.3, 0.3, 0.01))
    alone = sights(world_of((low, at(0, 0, 0.02))), [1], scan_poses())[1]
    assert alone.target_class == "open"
    assert alone.seen_px.tolist() == alone.alone_px.tolist()
    hidden = sights(world_of((low, at(0, 0, 0.02)), (roof, at(0, 0, 0.05))), [1], scan_poses())[1]
    assert hidden.target_class == "hidden"
    assert hidden.alone_px.tolist() == alone.alone_px.tolist()


def test_half_a_roof_hides_about_half():
    low, roof = item(1), item(2, size_m=(0.3, 0.3, 0.002))
    half = sights(world_of((low, at(0, 0, 0.02)), (roof, at(0.15, 0, 0.0415))), [1], look_down(0, 0, 0.7)[None])[1]
    assert half.target_class == "partly"
    assert half.share == pytest.approx(0.5, abs=0.05)


def test_what_no_view_can_see_has_no_class():
    world = world_of((item(1), at(5.0, 0, 0.02)))
    assert sights(world, [1], scan_poses())[1].target_class is None


@pytest.mark.parametrize("change", [{"width": 0}, {"height": 0}, {"across_rad": 0.0}, {"down_rad": np.pi}])
def test_a_camera_that_cannot_be_is_refused(change):
    with pytest.raises(PileError):
        CameraModel(**change)


@pytest.mark.parametrize("change", [{"disparity_px": -1}, {"lost": 1.5}, {"baseline_m": 0.0}, {"least_m": np.nan}])
def test_depth_noise_that_cannot_be_is_refused(change):
    with pytest.raises(PileError):
        DepthNoise(**change)


def test_pose_noise_and_poses_that_cannot_be_are_refused():
    with pytest.raises(PileError):
        PoseNoise(hand_eye_m=-1)
    with pytest.raises(PileError):
        sights(PileWorld(), [], np.eye(4))


def test_a_camera_inside_an_item_is_told_so_by_the_map():
    world = world_of((item(1, size_m=(0.3, 0.3, 0.3)), at(0.0, 0.0, 0.15)))
    camera = PileCamera(world, np.random.default_rng(0))
    camera.move_to(look_down(0.0, 0.0, 0.2))
    table = Workspace.between(np.array([-0.3, -0.3, 0.0]), np.array([0.3, 0.3, 0.3]), 0.02)
    with pytest.raises(CameraBlocked):
        map_views(table, [camera.view()])
