"""The map C: what a slow loop says, what more views may change, and what a blocked camera is told."""

import dataclasses
import pickle

import numpy as np
import pytest
from box_scenes import Block, intrinsics, looking_down, see, square_scan, views_of
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import CameraBlocked, InputError, ShapeError
from rfcompass.mapping import LogOdds, VisualMap, clean_depth_m, map_views
from rfcompass.mapping.view_kernels import FREE, OUTSIDE, SURFACE, UNOBSERVED
from rfcompass.mapping.visual_map import check_spacing
from rfcompass.types import DepthView, Workspace

TABLE = Workspace.between([-0.3, -0.25, 0.0], [0.3, 0.25, 0.2], 0.025)


def slowly_seen(view, workspace):
    """State of each voxel after one view, one voxel and one number at a time."""
    state = np.zeros(workspace.shape, dtype=np.uint8)
    T_camera_world = np.linalg.inv(view.T_world_camera)
    axis = view.T_world_camera[:3, 2]
    half_m = workspace.spacing_m * sum(abs(part) for part in axis) * 0.4999  # a touch is not enough
    x_m, y_m, z_m = workspace.axes_m()
    for i, j, k in np.ndindex(*workspace.shape):
        x, y, z = (T_camera_world @ [x_m[i], y_m[j], z_m[k], 1.0])[:3]
        if z <= 0:
            continue
        u, v, _ = view.intrinsics @ [x / z, y / z, 1.0]
        column, row = int(np.floor(u + 0.5)), int(np.floor(v + 0.5))
        if not (0 <= row < view.depth_m.shape[0] and 0 <= column < view.depth_m.shape[1]):
            continue
        d = view.depth_m[row, column]
        if np.isnan(d) or z > d + half_m:
            state[i, j, k] = UNOBSERVED
        else:
            state[i, j, k] = FREE if z < d - half_m else SURFACE
    return state


blocks = st.builds(
    Block,
    st.tuples(st.floats(-0.2, 0.2), st.floats(-0.15, 0.15), st.floats(0.0, 0.12)),
    st.tuples(*[st.floats(0.03, 0.2)] * 3),
    st.floats(0.0, 3.0),
)
poses = st.builds(
    looking_down,
    st.floats(-0.2, 0.2),
    st.floats(-0.2, 0.2),
    st.floats(0.5, 0.8),
    st.floats(-0.3, 0.3),
    st.floats(-3, 3),
)
piles = st.lists(blocks, max_size=3)
rigs = st.lists(poses, min_size=1, max_size=3)


@given(piles, poses)
def test_the_compiled_map_is_the_slow_one(pile, pose):
    view, _ = see(pile, pose)
    coarse = Workspace.between([-0.4, -0.3, 0.0], [0.4, 0.3, 0.2], 0.05)
    differ = map_views(coarse, [view]).state != slowly_seen(view, coarse)
    assert differ.mean() < 0.01  # voxels whose middle falls on the border of two pixels


@given(rigs)
def test_an_empty_table_hides_nothing(rig):
    seen = map_views(TABLE, views_of([], rig, shape=(120, 160)))
    assert seen.covered.any()
    assert not seen.unobserved.any()
    assert not seen.uncertainty().values.any()


@given(piles, rigs, poses, st.booleans())
def test_a_view_more_never_hides_what_was_seen(pile, rig, extra, add_up):
    rule = LogOdds() if add_up else None
    before = map_views(TABLE, views_of(pile, rig), rule=rule)
    after = before.with_views(views_of(pile, [extra]))
    assert not (after.unobserved & before.covered & ~before.unobserved).any()
    assert (after.covered | ~before.covered).all()
    seen_before, seen_after = before.state >= FREE, after.state >= FREE
    assert (seen_after | ~seen_before).all()


@given(piles, st.permutations(range(3)))
def test_the_order_of_views_means_nothing(pile, order):
    views = views_of(pile, [looking_down(0.1, 0.1), looking_down(-0.2, 0.0, 0.6, 0.2), looking_down(0.0, -0.2)])
    assert np.array_equal(map_views(TABLE, views).state, map_views(TABLE, [views[i] for i in order]).state)


@given(piles, rigs)
def test_what_is_deep_inside_a_block_is_never_observed(pile, rig):
    seen = map_views(TABLE, views_of(pile, rig, shape=(120, 160)))
    x, y, z = np.meshgrid(*TABLE.axes_m(), indexing="ij")
    for block in pile:
        c, s = np.cos(block.yaw_rad), np.sin(block.yaw_rad)
        dx, dy, dz = (axis - middle for axis, middle in zip((x, y, z), block.centre_m, strict=True))
        off = np.stack([c * dx + s * dy, c * dy - s * dx, dz], axis=-1)
        deep = (np.abs(off) < np.array(block.size_m) / 2 - 0.035).all(axis=-1)
        assert (seen.state[deep] <= UNOBSERVED).all()


@given(piles, st.integers(-4, 4), st.integers(-4, 4))
def test_a_move_of_scene_and_cameras_by_whole_voxels_moves_the_map(pile, along_x, along_y):
    h = 2.0**-5
    workspace = Workspace([-0.5, -0.5, 0.0], (32, 32, 8), h)
    pile = [dataclasses.replace(b, centre_m=tuple(np.round(np.array(b.centre_m) * 256) / 256)) for b in pile]
    moved = [dataclasses.replace(b, centre_m=tuple(np.add(b.centre_m, (along_x * h, along_y * h, 0)))) for b in pile]
    here = looking_down(0.0, 0.0, 0.75)
    there = looking_down(along_x * h, along_y * h, 0.75)
    one = map_views(workspace, views_of(pile, [here])).state
    other = map_views(workspace, views_of(moved, [there])).state
    rolled = np.roll(one, (along_x, along_y), axis=(0, 1))
    inner = (slice(4, -4), slice(4, -4))
    assert (rolled[inner] != other[inner]).mean() < 2e-3  # edges of a block that fall on the border of two pixels


def test_a_block_hides_its_own_volume_from_many_sides():
    block = Block((0.0, 0.0, 0.05), (0.2, 0.16, 0.1))
    workspace = Workspace.between([-0.3, -0.25, 0.0], [0.3, 0.25, 0.2], 0.01)
    seen = map_views(workspace, views_of([block], square_scan(0.5), shape=(240, 320)))
    assert seen.unobserved_m3 == pytest.approx(0.2 * 0.16 * 0.1, rel=0.25)
    assert seen.heights_m().max() == pytest.approx(0.1, abs=1e-9)
    assert seen.heights_m()[0, 0] == 0.0


def test_space_that_no_camera_was_turned_to_is_not_uncertain():
    narrow = see([], looking_down(), intrinsics(80, 60, 300.0))[0]
    seen = map_views(TABLE, [narrow])
    assert (seen.state == OUTSIDE).any()
    assert seen.uncertainty().values[seen.state == OUTSIDE].max() == 0.0


def test_a_pixel_without_depth_leaves_its_voxels_unobserved():
    view = see([], looking_down())[0]
    depth_m = view.depth_m.copy()
    depth_m[20:40, 30:50] = np.nan
    seen = map_views(TABLE, [dataclasses.replace(view, depth_m=depth_m)])
    assert seen.unobserved.any()
    assert not seen.with_views([see([], looking_down(0.1))[0]]).unobserved.any()


# --- contradicting views -------------------------------------------------------------------------


def test_log_odds_take_back_a_surface_that_most_views_look_through():
    flying = see([Block((0.0, 0.0, 0.1), (0.1, 0.1, 0.04))], looking_down())[0]
    clear = [see([], looking_down())[0]] * 4
    believed = map_views(TABLE, [flying, *clear])
    judged = map_views(TABLE, [flying, *clear], rule=LogOdds())
    assert (believed.states == SURFACE).any()
    assert not (judged.states == SURFACE).any()
    assert np.array_equal(believed.unobserved, judged.unobserved)
    assert judged.log_odds.min() >= -2.0


def test_log_odds_with_wrong_signs_are_refused():
    with pytest.raises(InputError, match="signs or order"):
        LogOdds(free=0.4)
    with pytest.raises(ShapeError, match="come together"):
        VisualMap(TABLE, np.zeros(TABLE.shape, np.uint8), rule=LogOdds())


# --- looking again -------------------------------------------------------------------------------


@given(st.floats(-0.25, 0.25), st.floats(-0.2, 0.2), st.floats(0.02, 0.15), st.booleans())
def test_looking_again_changes_the_cube_only(x_m, y_m, z_m, add_up):
    piled = views_of([Block((0, 0, 0.05), (0.3, 0.3, 0.1))], [looking_down(), looking_down(0.1)])
    before = map_views(TABLE, piled, rule=LogOdds() if add_up else None)
    after = before.refreshed(views_of([], [looking_down()]), [x_m, y_m, z_m])
    centres = np.stack(np.meshgrid(*TABLE.axes_m(), indexing="ij"), axis=-1)
    cube = (np.abs(centres - [x_m, y_m, z_m]) <= 0.05 + 1e-9).all(axis=-1)
    assert np.array_equal(after.states[~cube], before.states[~cube])
    assert not after.unobserved[cube].any()


def test_looking_again_forgets_free_space_that_an_item_fell_into():
    before = map_views(TABLE, views_of([], [looking_down()]))
    fallen = [Block((0.0, 0.0, 0.04), (0.2, 0.2, 0.08))]
    after = before.refreshed(views_of(fallen, [looking_down()]), [0.0, 0.0, 0.03])
    assert after.unobserved.any()
    assert not before.with_views(views_of(fallen, [looking_down()])).unobserved.any()


def test_looking_elsewhere_keeps_what_was_known_of_the_cube():
    before = map_views(TABLE, views_of([Block((0, 0, 0.05), (0.2, 0.2, 0.1))], [looking_down()]))
    away = see([], looking_down(3.0))[0]
    assert np.array_equal(before.refreshed([away], [0.0, 0.0, 0.05]).state, before.state)


def test_a_cube_beside_the_workspace_is_refused():
    with pytest.raises(InputError, match="no voxel"):
        VisualMap.empty(TABLE).refreshed(views_of([], [looking_down()]), [2.0, 0.0, 0.0])


# --- bad input -----------------------------------------------------------------------------------


def test_what_cameras_write_for_no_depth_becomes_nan_or_is_refused():
    raw = np.array([[0.0, -1.0, np.inf], [np.nan, 0.5, 1.0]])
    assert np.array_equal(clean_depth_m(raw), [[np.nan] * 3, [np.nan, 0.5, 1.0]], equal_nan=True)
    for bad in (0.0, -1.0, np.inf):
        with pytest.raises(ShapeError, match="depth_m"):
            DepthView(np.full((4, 5), bad), intrinsics(5, 4), looking_down())


def test_a_camera_that_cannot_be_is_refused():
    depth_m, K, T = np.ones((4, 5)), intrinsics(5, 4), looking_down()
    with pytest.raises(ShapeError, match="focal"):
        DepthView(depth_m, K * [[-1], [1], [1]], T)
    with pytest.raises(ShapeError, match="last row"):
        DepthView(depth_m, K * 2, T)
    with pytest.raises(ShapeError, match="rigid"):
        DepthView(depth_m, K, T * 1.1)
    with pytest.raises(ShapeError, match="no pixel"):
        DepthView(np.ones((0, 5)), K, T)


@pytest.mark.parametrize("middle", [(319.5, 239.5), (80.0, -1.0), (161.0, 60.0)])
def test_intrinsics_of_another_image_size_are_refused(middle):
    K = intrinsics(160, 120)
    DepthView(np.ones((120, 160)), K, looking_down())
    K[:2, 2] = middle
    with pytest.raises(ShapeError, match="another image size"):
        DepthView(np.ones((120, 160)), K, looking_down())


@pytest.mark.parametrize("dtype", [np.float64, np.uint16])
def test_depths_in_millimetres_are_no_map(dtype):
    view = see([], looking_down())[0]
    with pytest.raises(InputError, match="millimetres") as refusal:
        map_views(TABLE, [dataclasses.replace(view, depth_m=(1000 * view.depth_m).astype(dtype))])
    assert refusal.value.numbers["median_m"] == pytest.approx(750.0)
    floor = see([], looking_down(height_m=2.0), table_m=-2.0)[0]
    assert map_views(TABLE, [floor]).covered.any()  # a camera that looks past the table, onto the floor


def test_a_camera_inside_an_item_is_told_so():
    inside = dataclasses.replace(see([], looking_down())[0], depth_m=np.full((60, 80), 0.02))
    with pytest.raises(CameraBlocked, match="before the camera") as refusal:
        map_views(TABLE, [inside])
    assert refusal.value.numbers["median_m"] == pytest.approx(0.02)
    with pytest.raises(CameraBlocked, match="none of the 4800"):
        map_views(TABLE, [dataclasses.replace(inside, depth_m=np.full((60, 80), np.nan))])


def test_a_camera_under_the_table_is_refused():
    with pytest.raises(InputError, match="below the table"):
        map_views(TABLE, [see([], looking_down(height_m=-0.5), table_m=-1.0)[0]])


def test_a_map_survives_a_pickle():
    seen = map_views(TABLE, views_of([Block((0, 0, 0.05), (0.2, 0.2, 0.1))], [looking_down()]), rule=LogOdds())
    loaded = pickle.loads(pickle.dumps(seen))
    assert np.array_equal(loaded.state, seen.state)
    assert np.array_equal(loaded.log_odds, seen.log_odds)
    with pytest.raises(ValueError, match="read-only"):
        loaded.state[0, 0, 0] = 1


def rooms(*shown, shape=(12, 12, 8), spacing_m=0.01):
    """A map whose unobserved voxels are those of some boxes, given as slices."""
    workspace = Workspace.between([0, 0, 0], np.array(shape) * spacing_m, spacing_m)
    state = np.full(workspace.shape, FREE, dtype=np.uint8)
    for box in shown:
        state[box] = UNOBSERVED
    return VisualMap(workspace, state)


def test_slivers_are_no_room_and_boxes_are():
    sliver, box = np.s_[:, :, 0:1], np.s_[2:7, 2:7, 0:5]
    assert rooms(sliver).unobserved_m3 > 0
    assert rooms(sliver).room_m3(0.05) == 0.0
    assert 100e-6 < rooms(box).room_m3(0.05) <= 125e-6
    assert rooms(box).room_m3(0.05) <= rooms(box, sliver).room_m3(0.05) < rooms(box, sliver).unobserved_m3
    assert rooms(box).room_m3(0.12) == 0.0


def test_what_lies_under_its_own_surface_counts_as_far_as_nobody_saw_it():
    """A target of five layers, of which cameras see the upper two."""
    seen = rooms(np.s_[2:7, 2:7, 0:3])
    assert seen.room_m3(0.06) == 0.0
    state = seen.state.copy()
    state[2:7, 2:7, 3:5] = SURFACE
    assert 0 < VisualMap(seen.workspace, state).room_m3(0.06) <= seen.unobserved_m3


@given(edge_m=st.floats(0.015, 0.12), seed=st.integers(0, 99))
def test_room_is_never_more_than_what_was_not_seen(edge_m, seed):
    rng = np.random.default_rng(seed)
    seen = rooms(rng.random((12, 12, 8)) < 0.8)
    assert 0 <= seen.room_m3(edge_m) <= seen.unobserved_m3 + 1e-12


@given(edge_m=st.floats(0.02, 0.07), middle=st.tuples(*[st.floats(0.035, 0.045)] * 3))
def test_where_a_ball_lies_that_nobody_saw_there_is_room_for_it(edge_m, middle):
    workspace = Workspace.between([0, 0, 0], [0.12, 0.12, 0.08], 0.01)
    centres_m = np.stack(np.meshgrid(*workspace.axes_m(), indexing="ij"), axis=-1)
    inside = np.linalg.norm(centres_m - middle, axis=-1) <= edge_m / 2
    state = np.where(inside, UNOBSERVED, FREE).astype(np.uint8)
    assert (VisualMap(workspace, state).room_m3(edge_m) > 0) == bool(inside.any())


# --- how coarse voxels may be for a hidden item not to be overlooked -----------------------------

EDGE_M = 0.02
COARSE = Workspace.between([-0.1, -0.1, 0.0], [0.1, 0.1, 0.2], EDGE_M)


def see_ball(middle_m, diameter_m, pose, K, shape):
    """Depth of a ball over the endless table."""
    v, u = np.indices(shape)
    rays = np.stack([u, v, np.ones(shape)], axis=-1) @ np.linalg.inv(K).T @ pose[:3, :3].T
    eye_m = pose[:3, 3]
    table = -eye_m[2] / rays[..., 2]
    a, b = (rays**2).sum(axis=-1), rays @ (eye_m - middle_m)
    root = b**2 - a * (((eye_m - middle_m) ** 2).sum() - diameter_m**2 / 4)
    ball = (-b - np.sqrt(np.maximum(root, 0.0))) / a
    return DepthView(np.where(root > 0, np.minimum(ball, table), table), K, pose)


def from_straight_above(middle_m, diameter_m):
    """From 20 m, a pixel for each millimetre."""
    view = see_ball(middle_m, diameter_m, looking_down(height_m=20.0), intrinsics(220, 220, 20000.0), (220, 220))
    return map_views(COARSE, [view])


@given(
    edges=st.floats(1.6, 4.0),
    at=st.tuples(st.floats(-0.02, 0.02), st.floats(-0.02, 0.02), st.one_of(st.just(0.0), st.floats(0.0, 0.05))),
)
def test_in_voxels_of_two_thirds_a_ball_is_not_overlooked_from_straight_above(edges, at):
    diameter_m = edges * EDGE_M
    seen = from_straight_above(np.add(at, (0.0, 0.0, diameter_m / 2)), diameter_m)
    assert seen.room_m3(diameter_m) > 0


def test_in_coarser_ones_it_is_and_they_are_refused():
    """A ball between four columns of voxels, whose middles see it low or not at all."""
    for edges, hides in ((1.4, False), (1.45, False), (1.6, True)):
        diameter_m = edges * EDGE_M
        seen = from_straight_above(np.array([0.0, 0.0, diameter_m / 2]), diameter_m)
        assert bool(seen.unobserved.any()) == hides
        if not hides:
            with pytest.raises(InputError, match="too coarse") as refusal:
                seen.room_m3(diameter_m)
            assert refusal.value.numbers["spacing_m"] == EDGE_M
            assert refusal.value.numbers["edge_m"] == diameter_m


@given(
    edges=st.floats(3.1, 4.0),
    at=st.tuples(st.floats(-0.02, 0.02), st.floats(-0.02, 0.02), st.floats(0.0, 0.05)),
)
def test_in_voxels_of_a_third_a_ball_is_not_overlooked_by_slanted_views_either(edges, at):
    diameter_m = edges * EDGE_M
    middle_m = np.add(at, (0.0, 0.0, diameter_m / 2))
    views = [see_ball(middle_m, diameter_m, pose, intrinsics(320, 180, 251.0), (180, 320)) for pose in square_scan()]
    assert map_views(COARSE, views).room_m3(diameter_m) > 0


@pytest.mark.parametrize(("spacing_m", "edge_m"), [(0.1, 0.05), (0.021, 0.03), (0.01, np.nan), (0.01, 0.0)])
def test_voxels_that_are_too_coarse_are_refused(spacing_m, edge_m):
    with pytest.raises(InputError, match="too coarse"):
        check_spacing(spacing_m, edge_m)
