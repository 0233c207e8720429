"""Worlds are checked when they are made, and change only by making another."""

import numpy as np
import pytest
from collision_scenes import at

from rfcompass.errors import InputError, SceneError
from rfcompass.types import Body, Box, Cylinder, Sphere, World, world_of_scene
from rfcompass.types.scene import Material, Obstacle, Room, Scene

LEG = Body("leg", Box(np.array([0.4, 0.05, 0.05])), at(0.4, 0, 0.025))
WOOD = {"wood": Material("wood")}


def test_a_name_stands_once():
    with pytest.raises(SceneError, match="twice") as caught:
        World((LEG, LEG))
    assert caught.value.numbers["bodies"] == ["leg"]


@pytest.mark.parametrize("name", ["", "floor", "world"])
def test_a_body_needs_a_name_of_its_own(name):
    with pytest.raises(SceneError):
        Body(name, Sphere(0.1), np.eye(4))


@pytest.mark.parametrize("T", [np.eye(3), np.diag([2.0, 1, 1, 1]), np.diag([-1.0, 1, 1, 1]), np.full((4, 4), np.nan)])
def test_a_pose_must_be_rigid(T):
    with pytest.raises(InputError):
        Body("leg", Sphere(0.1), T)


def test_a_body_needs_a_shape():
    with pytest.raises(SceneError, match="str"):
        Body("leg", "box", np.eye(4))


def test_the_floor_is_at_a_finite_height():
    with pytest.raises(SceneError):
        World(floor_m=np.nan)


def test_attaching_moves_a_body_from_the_world_to_a_link():
    held = World((LEG,)).attach("leg", "gripper_palm_link", at(0, 0, 0.1), ["gripper_finger_link_l"])
    (body,) = held.bodies
    assert not body.stands_still
    assert body.parent == "gripper_palm_link"
    assert body.may_touch == {"gripper_palm_link", "gripper_finger_link_l"}
    assert body.shape is LEG.shape


def test_what_is_not_there_cannot_be_removed():
    with pytest.raises(SceneError, match="leg"):
        World((LEG,)).without("chair")


def test_a_scene_brings_its_obstacles_and_four_walls_around_the_room():
    room = Room(np.array([4.0, 3.0, 2.5]), "wood", "wood", "wood")
    scene = Scene("s", room, (Obstacle("post", Cylinder(0.1, 1.0, "z"), at(1, 1, 0.5), "wood"),), WOOD)
    world = world_of_scene(scene, at(-2, 0, 0.1))
    assert world.floor_m == pytest.approx(0.1)
    bodies = {body.name: body for body in world.bodies}
    assert set(bodies) == {"post", "wall_x_low", "wall_x_high", "wall_y_low", "wall_y_high"}
    assert bodies["post"].T_parent_body[:3, 3] == pytest.approx([-1, 1, 0.6])
    low, high = (bodies[name] for name in ("wall_x_low", "wall_x_high"))
    assert low.T_parent_body[0, 3] + low.shape.size_m[0] / 2 == pytest.approx(-2)
    assert high.T_parent_body[0, 3] - high.shape.size_m[0] / 2 == pytest.approx(2)


def test_a_tilted_scene_is_refused():
    tilted = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    with pytest.raises(SceneError, match="tilted"):
        world_of_scene(Scene("s"), at(0, 0, 0, tilted))
