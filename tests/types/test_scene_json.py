"""Scenes as JSON: there and back, and every defect is named."""

import copy

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import SceneError, ShapeError
from rfcompass.types.scene import Material, Obstacle, Room, Scene
from rfcompass.types.scene_json import scene_from_json, scene_to_json
from rfcompass.types.shapes import Box, Cylinder, Sphere

GOOD = {
    "schema": "rfcompass-scene/1",
    "name": "lab",
    "room": {"size_m": [6, 5, 2.7], "wall": "concrete", "floor": "concrete", "ceiling": "plaster"},
    "materials": {
        "concrete": {"permittivity": 5.24},
        "plaster": {"permittivity": 2.7, "surface_loss_db": 1},
        "metal": {"conductor": True},
    },
    "obstacles": [
        {"name": "desk", "box_m": [1.4, 0.7, 0.03], "position_m": [2, 2, 0.7], "yaw_rad": 0.3, "material": "plaster"},
        {
            "name": "bin",
            "cylinder_m": [0.2, 0.5],
            "position_m": [1, 1, 0.25],
            "material": "metal",
            "blocks_base": False,
        },
    ],
}


def test_a_scene_holds_what_its_file_says():
    scene = scene_from_json(GOOD)
    assert scene.room.surfaces == (("concrete", "concrete"),) * 2 + (("concrete", "plaster"),)
    desk, waste = scene.obstacles
    assert isinstance(desk.shape, Box)
    assert desk.T_scene_obstacle[0, 0] == pytest.approx(np.cos(0.3))
    assert isinstance(waste.shape, Cylinder)
    assert not waste.blocks_base
    assert scene.materials["metal"].conductor


@given(st.integers(0, 10_000))
def test_a_scene_survives_the_trip_through_json(seed):
    rng = np.random.default_rng(seed)
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R * np.linalg.det(R), rng.normal(size=3)
    shape = Box(rng.uniform(0.1, 2.0, 3)) if seed % 2 else Cylinder(0.3, 0.7, "x")
    scene = Scene("s", None, (Obstacle("o", shape, T, "m"),), {"m": Material("m", rng.uniform(1, 9), 3.0, 2.0)})
    assert scene_to_json(scene_from_json(scene_to_json(scene))) == scene_to_json(scene)


def broken(change):
    content = copy.deepcopy(GOOD)
    change(content)
    return content


@pytest.mark.parametrize(
    ("change", "key"),
    [
        (lambda c: c.update(schema="rfcompass-scene/9"), "scene.schema"),
        (lambda c: c.pop("name"), "scene.name"),
        (lambda c: c.update(extra=1), "scene"),
        (lambda c: c["room"].update(size_m=[6, 5]), "room.size_m"),
        (lambda c: c["room"].update(size_m=[6, 5, float("nan")]), "room.size_m"),
        (lambda c: c["room"].update(size_m=[6, 5, 0]), "size_m"),
        (lambda c: c["room"].update(wall="gold"), "the room"),
        (lambda c: c["materials"]["metal"].update(conductor="yes"), "materials.metal.conductor"),
        (lambda c: c["materials"]["concrete"].update(permittivity=0.5), "permittivity"),
        (lambda c: c["obstacles"][0].update(box_m=[1, 1, -1]), "obstacles[0]"),
        (lambda c: c["obstacles"][0].update(cylinder_m=[1, 1]), "obstacles[0].box_m"),
        (lambda c: c["obstacles"][0].update(rotation=[[1, 0, 0]]), "obstacles[0].yaw_rad"),
        (lambda c: c["obstacles"][1].update(name="desk"), "obstacles"),
        (lambda c: c["obstacles"][1].update(material="air"), "obstacle bin"),
        (lambda c: c["obstacles"].append("a chair"), "obstacles[2]"),
        (lambda c: c["obstacles"][1].update(position_m=[1, 2, True]), "obstacles[1].position_m"),
    ],
)  # fmt: skip
def test_a_defect_names_its_place(change, key):
    with pytest.raises(SceneError) as caught:
        scene_from_json(broken(change))
    assert key in (caught.value.numbers.get("key"), caught.value.message) or key in caught.value.message


@pytest.mark.parametrize("content", [None, 3, [], "lab"])
def test_what_is_no_object_is_no_scene(content):
    with pytest.raises(SceneError):
        scene_from_json(content)


def test_a_shape_that_waves_cannot_be_led_through_is_refused():
    with pytest.raises(SceneError):
        Obstacle("ball", Sphere(0.2), np.eye(4), "m")


def test_a_pose_that_is_not_rigid_is_refused():
    with pytest.raises(SceneError):
        Obstacle("box", Box(np.ones(3)), np.diag([2.0, 1.0, 1.0, 1.0]), "m")
    with pytest.raises(ShapeError):
        Obstacle("box", Box(np.ones(3)), np.eye(3), "m")


def test_the_box_around_an_obstacle_holds_it():
    T = np.eye(4)
    T[:3, :3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    low, high = Obstacle("o", Box(np.array([2.0, 1.0, 0.5])), T, "m").bounds_m
    assert np.allclose([low, high], [[-0.5, -1.0, -0.25], [0.5, 1.0, 0.25]])


def test_a_room_of_no_size_is_refused():
    with pytest.raises(SceneError):
        Room(np.array([1.0, 0.0, 1.0]), "m", "m", "m")
