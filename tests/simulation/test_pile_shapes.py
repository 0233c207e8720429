"""A pile as others take it: obstacles of the radio channel and shapes to draw are where the items are."""

import numpy as np
import pytest
from pile_scenes import at, item, one_of_each, world_of

from rfcompass.simulation.piles import drawn_shapes, radio_scene
from rfcompass.simulation.piles.items import PANELS
from rfcompass.viz.meshcat_page import write_scene
from rfcompass.viz.robot_scene import RobotScene


def test_every_item_is_an_obstacle_where_it_is_and_a_cover_one_for_each_panel():
    world = one_of_each()
    shift = at(1.0, 2.0, 0.7)
    obstacles = {ob.name: ob for ob in radio_scene(world, shift).obstacles}
    assert len(obstacles) == 4 + PANELS
    for thing in world.items:
        for panel, T in enumerate(world.panel_poses(thing.number)):
            assert np.allclose(obstacles[f"{thing.name}_{panel}"].T_scene_obstacle, shift @ T)


def test_what_is_drawn_fills_the_boxes_of_the_items():
    world = one_of_each()
    for thing in world.items:
        drawn = [shape for shape in drawn_shapes(world) if shape.link.startswith(thing.name)]
        reach = np.array([np.abs(shape.T_world_shape[:3, :3]) @ half_edges(shape) for shape in drawn])
        centres = np.array([shape.T_world_shape[:3, 3] for shape in drawn])
        corners = world.corners_m(thing.number)
        assert (centres + reach).max(axis=0) == pytest.approx(corners.max(axis=0), abs=1e-9)
        assert (centres - reach).min(axis=0) == pytest.approx(corners.min(axis=0), abs=1e-9)


def half_edges(shape):
    d = shape.dimensions_m
    return {"box": d / 2, "ellipsoid": d, "sphere": np.repeat(d[0], 3), "cylinder": np.array([d[0], d[0], d[-1] / 2])}[
        shape.kind
    ]


def test_only_what_is_asked_to_be_solid_is():
    world = world_of((item(1), at(0, 0, 0.02)), (item(2), at(0.2, 0, 0.02)))
    opacity = {shape.link: shape.rgba[3] for shape in drawn_shapes(world, opacity=0.3, solid=(2,))}
    assert opacity == {"table": 1.0, "box_01_0_0": 0.3, "box_02_0_0": 1.0}


def test_a_page_shows_every_shape(tmp_path):
    world, scene = one_of_each(), RobotScene()
    shapes = drawn_shapes(world)
    scene.draw_shapes("pile", shapes)
    drawn = {command["path"] for command in scene.window.commands if command["type"] == "set_object"}
    assert {f"/meshcat/pile/{shape.link}" for shape in shapes} <= drawn
    write_scene(tmp_path / "pile.html", scene.window, "a pile")
    assert (tmp_path / "pile.html").stat().st_size > 10_000
