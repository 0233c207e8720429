"""Shapes know their box and their inertia, and refuse lengths that cannot be."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError, PartError
from rfcompass.types.shapes import Box, Cylinder, Mesh, Sphere

LENGTHS = st.floats(0.01, 2.0)


def inside(shape, points):
    match shape:
        case Box():
            return (np.abs(points) <= shape.size_m / 2).all(axis=1)
        case Sphere():
            return np.linalg.norm(points, axis=1) <= shape.radius_m
        case Cylinder():
            along = "xyz".index(shape.axis)
            across = np.delete(points, along, axis=1)
            return (np.abs(points[:, along]) <= shape.length_m / 2) & (np.linalg.norm(across, axis=1) <= shape.radius_m)


@pytest.mark.parametrize("shape", [Box([0.4, 0.1, 0.2]), Sphere(0.2), Cylinder(0.1, 0.5), Cylinder(0.1, 0.5, "z")])
def test_box_volume_and_inertia_agree_with_counting_points(shape):
    low, high = shape.lower_m, shape.upper_m
    axes = [np.linspace(a, b, 61)[:-1] + (b - a) / 120 for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    held = points[inside(shape, points)]
    assert np.isclose(shape.volume_m3, len(held) / len(points) * np.prod(high - low), rtol=0.01)
    counted = np.eye(3) * (held**2).sum(axis=1).mean() - held.T @ held / len(held)
    assert np.allclose(shape.inertia_per_mass_m2, counted, rtol=0.01, atol=1e-6)
    assert np.allclose(held.max(axis=0), high, rtol=0.1)


@given(LENGTHS, LENGTHS)
def test_a_lying_cylinder_is_as_high_as_its_diameter_and_a_standing_one_as_its_length(radius_m, length_m):
    lying, standing = Cylinder(radius_m, length_m), Cylinder(radius_m, length_m, "z")
    assert np.isclose(2 * lying.upper_m[2], 2 * radius_m)
    assert np.isclose(2 * standing.upper_m[2], length_m)


@pytest.mark.parametrize("bad", [0.0, -0.1, np.nan, np.inf, None, "wide"])
@pytest.mark.parametrize(
    "build",
    [lambda x: Box([0.1, x, 0.1]), lambda x: Cylinder(x, 1.0), lambda x: Cylinder(1.0, x), Sphere],
    ids=["box", "radius", "length", "sphere"],
)
def test_a_length_that_cannot_be_is_refused(build, bad):
    with pytest.raises(InputError):
        build(bad)


def test_a_cylinder_does_not_lie_across():
    with pytest.raises(PartError, match="axis"):
        Cylinder(0.1, 0.2, "y")


def a_tetrahedron(**changes):
    corners = np.vstack([np.zeros(3), np.eye(3)])
    fields = {
        "vertices_m": corners,
        "triangles": np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
        "pieces_m": (corners,),
        "pieces_by": "convex",
        "T_part_file": np.eye(4),
    }
    return Mesh(**{**fields, **changes})


def test_places_of_the_mesh_file_move_into_the_part_frame():
    T_part_file = np.array([[0, -1, 0, 1.0], [1, 0, 0, 2.0], [0, 0, 1, 3.0], [0, 0, 0, 1]])
    mesh = a_tetrahedron(T_part_file=T_part_file)
    assert np.allclose(mesh.from_file_m(np.array([[1.0, 0, 0], [0, 0, 0]])), [[1, 3, 3], [1, 2, 3]])


@pytest.mark.parametrize(
    "changes",
    [
        {"triangles": np.array([[0, 1, 4]])},
        {"triangles": np.array([[0, 1, -1]])},
        {"triangles": np.zeros((0, 3), int)},
        {"triangles": np.array([[0.0, 1.0, 2.0]])},
        {"pieces_m": ()},
        {"pieces_m": (np.eye(3),)},
        {"pieces_by": "guess"},
        {"vertices_m": np.full((4, 3), np.nan)},
        {"T_part_file": np.diag([1.0, 1, -1, 1])},
        {"T_part_file": np.diag([2.0, 2, 2, 1])},
        {"T_part_file": np.diag([1.0, 1, 1, 2])},
    ],
)
def test_a_mesh_that_cannot_be_is_refused(changes):
    with pytest.raises(InputError):
        a_tetrahedron(**changes)
