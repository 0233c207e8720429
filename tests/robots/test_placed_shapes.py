"""Shapes for viewers: read from a URDF without loading meshes, and checked."""

import numpy as np
import pytest

from rfcompass.errors import InputError, RobotModelError, ShapeError
from rfcompass.robots.shapes import read_visuals
from rfcompass.robots.urdf_xml import parse_urdf
from rfcompass.types.placed_shape import PlacedShape


def visuals(tmp_path, geometry, material=""):
    text = (
        '<robot name="r"><material name="red"><color rgba="1 0 0 0.5"/></material><link name="a"><visual>'
        f'<origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><geometry>{geometry}</geometry>{material}</visual>'
        "</link></robot>"
    )
    return read_visuals(parse_urdf(text.encode(), "r"), tmp_path / "r.urdf", ())


@pytest.mark.parametrize(
    ("geometry", "kind", "dimensions_m"),
    [
        ('<box size="1 2 3"/>', "box", [1, 2, 3]),
        ('<!-- note --><cylinder length="3" radius="2"/>', "cylinder", [2, 3]),
        ('<sphere radius="2"/>', "sphere", [2]),
    ],
)
def test_primitives_are_read_with_size_place_and_colour(tmp_path, geometry, kind, dimensions_m):
    (shape,) = visuals(tmp_path, geometry, '<material name="red"/>')
    placed = shape.placed(np.eye(4))
    assert (placed.link, placed.kind, placed.mesh) == ("a", kind, None)
    assert placed.dimensions_m.tolist() == dimensions_m
    assert placed.rgba.tolist() == [1, 0, 0, 0.5]
    assert placed.T_world_shape[:3, 3].tolist() == [1, 2, 3]
    assert placed.T_world_shape[:3, 0] == pytest.approx([0, 1, 0])


def test_a_mesh_is_named_and_not_opened_and_a_missing_one_is_left_out(tmp_path):
    (tmp_path / "broken.stl").write_text("no mesh at all")
    (shape,) = visuals(tmp_path, '<mesh filename="broken.stl" scale="1 1 -1"/>')
    assert (shape.mesh, shape.dimensions_m.tolist()) == (tmp_path / "broken.stl", [1, 1, -1])
    assert visuals(tmp_path, '<mesh filename="missing.stl"/>') == ()
    assert visuals(tmp_path, '<mesh filename="package://nobody/missing.stl"/>') == ()


def test_a_link_whose_meshes_cannot_be_drawn_shows_its_collision_shapes(tmp_path):
    for name in ("eye.dae", "solid.stl"):
        (tmp_path / name).touch()
    dae, missing = '<mesh filename="eye.dae"/>', '<mesh filename="missing.stl"/>'
    solids = '<geometry><mesh filename="solid.stl"/></geometry>', '<geometry><box size="1 2 3"/></geometry>'
    behind = "".join(f"</visual><collision>{solid}</collision><visual>" for solid in solids)
    for hidden in (dae, missing):
        shown = visuals(tmp_path, f"{hidden}</geometry>{behind}<geometry>{hidden}")
        assert [shape.kind for shape in shown] == ["mesh", "box"]
    assert visuals(tmp_path, dae) == ()


def test_a_colour_of_its_own_wins_and_no_colour_is_grey(tmp_path):
    (own,) = visuals(tmp_path, '<sphere radius="1"/>', '<material name="red"><color rgba="0 1 0 1"/></material>')
    (none,) = visuals(tmp_path, '<sphere radius="1"/>')
    assert own.rgba.tolist() == [0, 1, 0, 1]
    assert none.rgba[0] == none.rgba[1] < 1


def test_a_shape_that_is_none_is_refused(tmp_path):
    assert visuals(tmp_path, "") == ()
    with pytest.raises(RobotModelError, match="<teapot> is no box"):
        visuals(tmp_path, "<teapot/>")


def a_shape(**changes):
    fields = {"link": "a", "kind": "box", "dimensions_m": (1, 2, 3), "T_world_shape": np.eye(4), "rgba": (1, 0, 0, 1)}
    return PlacedShape(**{**fields, **changes})


def test_a_placed_shape_is_read_only():
    with pytest.raises(ValueError, match="read-only"):
        a_shape().T_world_shape[0, 3] = 1


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"kind": "cone"}, InputError),
        ({"kind": "mesh"}, InputError),
        ({"mesh": "a.stl"}, InputError),
        ({"dimensions_m": (1, 2)}, ShapeError),
        ({"dimensions_m": (1, 2, 0)}, ShapeError),
        ({"T_world_shape": 2 * np.eye(4)}, ShapeError),
        ({"T_world_shape": np.ones((4, 4))}, ShapeError),
        ({"rgba": (1, 0, 0)}, ShapeError),
    ],
)
def test_an_impossible_shape_is_refused(changes, error):
    with pytest.raises(error):
        a_shape(**changes)
