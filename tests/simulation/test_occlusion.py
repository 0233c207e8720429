"""What a leg loses in boxes and cylinders: the chord, counted by sampling the leg, whichever way one goes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.simulation.occlusion import obstacle_table, pass_obstacles
from rfcompass.types.scene import Material, Obstacle, Scene
from rfcompass.types.shapes import Box, Cylinder

WOOD = Material("wood", permittivity=2.25, loss_db_per_m=10.0, surface_loss_db=3.0)
AIR = Material("air", permittivity=1.0)
places = st.tuples(*[st.floats(-1.5, 1.5)] * 3).map(np.array)


def turned(yaw_rad, at_m):
    T = np.eye(4)
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    T[:2, :2], T[:3, 3] = [[c, -s], [s, c]], at_m
    return T


def scene_of(*obstacles):
    named = tuple(replace(obstacle, name=f"thing_{n}") for n, obstacle in enumerate(obstacles))
    return Scene("test", None, named, {"wood": WOOD, "air": AIR})


def box(yaw_rad=0.4, at_m=(0.1, -0.2, 0.0), material="wood"):
    return Obstacle("box", Box(np.array([0.6, 0.4, 0.8])), turned(yaw_rad, at_m), material)


def cylinder(axis="z", at_m=(0.1, 0.2, -0.1)):
    return Obstacle("can", Cylinder(0.3, 0.9, axis), turned(0.7, at_m), "wood")


def passed(scene, start_m, end_m):
    length_m = float(np.linalg.norm(end_m - start_m))
    d = (end_m - start_m) / length_m
    return pass_obstacles(tuple(start_m), tuple(d), length_m, obstacle_table(scene))


def sampled_chord_m(obstacle, start_m, end_m, count=20_001):
    """Share of the leg's points that lie inside, times its length."""
    points_m = start_m + np.linspace(0, 1, count)[:, None] * (end_m - start_m)
    own_m = (points_m - obstacle.T_scene_obstacle[:3, 3]) @ obstacle.T_scene_obstacle[:3, :3]
    shape = obstacle.shape
    if isinstance(shape, Box):
        inside = (np.abs(own_m) <= shape.upper_m).all(axis=1)
    else:
        along, across = (0, [1, 2]) if shape.axis == "x" else (2, [0, 1])
        inside = (np.abs(own_m[:, along]) <= shape.upper_m[along]) & (
            np.linalg.norm(own_m[:, across], axis=1) <= 0.3
        )  # fmt: skip
    return inside.mean() * np.linalg.norm(end_m - start_m)


@pytest.mark.parametrize("obstacle", [box(), cylinder("z"), cylinder("x")], ids=["box", "standing", "lying"])
@settings(max_examples=40)
@given(start_m=places, end_m=places)
def test_loss_and_delay_follow_the_chord(obstacle, start_m, end_m):
    if np.linalg.norm(end_m - start_m) < 0.1:
        return
    loss_db, extra_m = passed(scene_of(obstacle), start_m, end_m)
    chord_m = sampled_chord_m(obstacle, start_m, end_m)
    assert extra_m == pytest.approx((np.sqrt(2.25) - 1) * chord_m, abs=1e-3)
    if chord_m > 1e-3:
        assert loss_db == pytest.approx(3.0 + 10.0 * chord_m, abs=1e-2)


@settings(max_examples=40)
@given(start_m=places, end_m=places)
def test_the_way_back_costs_what_the_way_there_did(start_m, end_m):
    if np.linalg.norm(end_m - start_m) < 0.1:
        return
    scene = scene_of(box(), cylinder("x"))
    np.testing.assert_allclose(passed(scene, start_m, end_m), passed(scene, end_m, start_m), atol=1e-9)


def test_two_obstacles_cost_what_each_of_them_does():
    start_m, end_m = np.array([-1.5, 0.0, 0.0]), np.array([1.5, 0.0, 0.0])
    one, other = box(at_m=(-0.6, 0, 0)), box(at_m=(0.6, 0, 0))
    both = np.array(passed(scene_of(one, other), start_m, end_m))
    single = [np.array(passed(scene_of(alone), start_m, end_m)) for alone in (one, other)]
    np.testing.assert_allclose(both, single[0] + single[1])


def test_a_leg_that_ends_inside_pays_for_what_is_inside():
    start_m, end_m = np.array([-1.0, -0.2, 0.0]), np.array([0.1, -0.2, 0.0])
    loss_db, _ = passed(scene_of(box(yaw_rad=0.0)), start_m, end_m)
    assert loss_db == pytest.approx(3.0 + 10.0 * 0.3)  # from the face at -0.2 to the middle at 0.1


def test_what_a_wave_does_not_notice_is_not_in_the_table():
    assert len(obstacle_table(scene_of(box(material="air"), box()))) == 1
