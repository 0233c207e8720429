"""Solids: the same shape in our formulas, in coal and in fcl."""

import coal
import numpy as np
import pinocchio as pin
import pytest
from collision_scenes import ROBOT, at
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import PartError
from rfcompass.robots.quick_collisions import coal_shape
from rfcompass.robots.solids import body_solids, padded, robot_solids
from rfcompass.types import Body, Box, Cylinder, Mesh, Sphere

CORNERS = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T
WEDGE = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.1, 0], [0, 0, 0.3], [0.1, 0.1, 0.1]], dtype=float)
SHAPES = {
    "box": Box(np.array([0.1, 0.2, 0.3])),
    "rod along x": Cylinder(0.03, 0.4, "x"),
    "post": Cylinder(0.03, 0.4, "z"),
    "ball": Sphere(0.1),
    "wedge": Mesh(WEDGE, np.array([[0, 2, 1]]), (WEDGE,), "hull", np.eye(4)),
}
SOLIDS = {name: body_solids(Body(name, shape, np.eye(4)))[0] for name, shape in SHAPES.items()}
ANGLES = st.tuples(*[st.floats(-3, 3)] * 3)


@pytest.mark.parametrize("name", SOLIDS)
@given(angles=ANGLES, height=st.floats(-0.5, 0.5))
def test_the_lowest_point_is_as_far_from_a_floor_as_coal_says(name, angles, height):
    solid = SOLIDS[name]
    T = at(0.1, -0.2, height, pin.rpy.rpyToMatrix(*angles)) @ solid.T_carrier_solid
    floor, result = coal.Halfspace(np.array([0.0, 0, 1]), 0.0), coal.DistanceResult()
    pose = coal.Transform3s(T[:3, :3], T[:3, 3])
    expected = coal.distance(coal_shape(solid), pose, floor, coal.Transform3s(), coal.DistanceRequest(), result)
    assert solid.lowest_m(T) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("name", SOLIDS)
def test_the_bounding_box_holds_the_solid_and_no_smaller_one_does(name):
    solid = SOLIDS[name]
    for axis in range(3):
        R = np.roll(np.eye(3), 2 - axis, axis=0)  # turns this axis up
        centred = np.linalg.inv(solid.T_carrier_box)
        local = at(0, 0, 0, R) @ centred @ solid.T_carrier_solid
        assert solid.lowest_m(local) == pytest.approx(-solid.half_size_m[axis], abs=1e-9)


@pytest.mark.parametrize("name", SOLIDS)
@given(angles=ANGLES, padding_mm=st.floats(0.1, 50))
def test_padding_reaches_at_least_so_far_in_every_direction(name, angles, padding_mm):
    solid, padding_m = SOLIDS[name], padding_mm * 1e-3
    T = at(0, 0, 0, pin.rpy.rpyToMatrix(*angles))
    grown = padded(solid, padding_m)
    gain = solid.lowest_m(T @ solid.T_carrier_solid) - grown.lowest_m(T @ grown.T_carrier_solid)
    assert padding_m - 1e-9 <= gain <= np.sqrt(3) * padding_m + 1e-9


def test_every_collision_shape_of_the_robot_is_a_solid_and_tags_come_on_demand():
    plain, tagged = robot_solids(ROBOT), robot_solids(ROBOT, with_tags=True)
    assert len(plain) == len(ROBOT.collision_shapes) == 17
    assert {solid.owner for solid in tagged} - {solid.owner for solid in plain} == {f"tag_{i}" for i in range(1, 10)}


def test_a_mesh_with_pieces_is_as_many_solids():
    pieces = (CORNERS * 0.1, CORNERS * 0.1 + [0.3, 0, 0])
    mesh = Mesh(np.vstack(pieces), np.array([[0, 1, 2]]), pieces, "vhacd", np.eye(4))
    solids = body_solids(Body("chair", mesh, at(0, 0, 1)))
    assert [solid.owner for solid in solids] == ["chair", "chair"]
    assert solids[1].lowest_m(solids[1].T_carrier_solid) == pytest.approx(0.95)


def test_a_flat_mesh_has_no_volume():
    flat = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    with pytest.raises(PartError, match="plane"):
        body_solids(Body("sheet", Mesh(flat, np.array([[0, 1, 2]]), (flat,), "hull", np.eye(4)), np.eye(4)))
