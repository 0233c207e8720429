"""Bounds of searches: what the simulator tells is true, and sharper than the posterior."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from simulation.pile_scenes import tiny

from rfcompass.mapping import map_views, posterior_map
from rfcompass.simulation.piles import PileItem
from rfcompass.simulation.piles.engine import load_mujoco
from rfcompass.simulation.piles.items import KINDS
from rfcompass.studies.pile_scan import workspace
from rfcompass.studies.search_bounds import TrueOthers, TruePlace, inside
from rfcompass.studies.searching import SearchTask, tagged_items_of


@pytest.fixture(scope="module")
def seen():
    scene = tiny()
    task = SearchTask(scene, tagged_items_of(scene, "any", 0, 1), 1)
    robot = task.robot()
    return robot, map_views(workspace(0.01), robot.scan().views), task.tags.target_size


def places_m(grid):
    axes = [low + grid.spacing_m * np.arange(n) for low, n in zip(grid.origin_m, grid.values.shape, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def mass_near(grid, point_m, reach_m):
    off_m = np.linalg.norm(places_m(grid) - point_m, axis=-1)
    return grid.values[off_m < reach_m].sum() / grid.values.sum()


def test_the_true_place_is_the_voxel_of_the_targets_middle(seen):
    robot, visual, target = seen
    grid = TruePlace(robot).believe(visual, target, {}, ())
    (peak,) = np.argwhere(grid.values > 0)
    middle_m = robot.world.pose(robot.scene.target)[:3, 3]
    assert np.abs(grid.origin_m + grid.spacing_m * peak - middle_m).max() <= grid.spacing_m / 2 + 1e-9


def test_where_all_others_are_known_more_of_the_map_is_at_the_target(seen):
    robot, visual, target = seen
    middle_m = robot.world.pose(robot.scene.target)[:3, 3]
    told = mass_near(TrueOthers(robot).believe(visual, target, {}, ()), middle_m, 0.03)
    assert told > mass_near(posterior_map(visual, target), middle_m, 0.03)


SIZES = {
    "cylinder": (0.06, 0.06, 0.1),
    "capsule": (0.05, 0.05, 0.12),
    "cover": (0.2, 0.15, 0.01),
    "cushion": (0.1, 0.1, 0.08),
}
GEOMS = {
    "box": "box",
    "cylinder": "cylinder",
    "capsule": "capsule",
    "ellipsoid": "ellipsoid",
    "cover": "box",
    "cushion": "box",
}


@settings(max_examples=20)
@given(kind=st.sampled_from(KINDS), seed=st.integers(0, 2**32 - 1))
def test_inside_is_where_a_ray_of_mujoco_leaves_the_same_shape(kind, seed):
    """From inside a convex thing rays to either side meet its surface; from outside they do not both."""
    rng = np.random.default_rng(seed)
    item = PileItem(1, kind, np.array(SIZES.get(kind, (0.1, 0.07, 0.04))), "card", (1, 2, 3))
    half_m = item.panel_size_m / 2
    size = {"cylinder": (half_m[0], half_m[2]), "capsule": (half_m[0], half_m[2] - half_m[0])}.get(kind, half_m)
    text = f'<mujoco><worldbody><geom type="{GEOMS[kind]}" size="{" ".join(map(str, size))}"/></worldbody></mujoco>'
    mujoco = load_mujoco()
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    points_m = rng.uniform(-1.3, 1.3, (40, 3)) * half_m
    met, way = np.zeros(1, np.int32), np.array([0.0, 0.0, 1.0])
    by_rays = []
    for point_m in points_m:
        ends_m = [mujoco.mj_ray(model, data, point_m, sign * way, None, 1, -1, met) for sign in (1, -1)]
        by_rays.append(min(ends_m) >= 0)
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R * np.sign(np.linalg.det(R)), rng.normal(size=3)
    assert inside(item, T, points_m @ T[:3, :3].T + T[:3, 3]).tolist() == by_rays
