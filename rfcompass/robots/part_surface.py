"""Outward normals of a part's surface: which of its faces a jaw presses on."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.types.shapes import Box, Cylinder, Mesh, Shape, Sphere

# A face this near to a point is one that the point lies on [m].
_ON_M = 2e-5


@dataclass(frozen=True, slots=True)
class Surface:
    """A shape with its triangles, where it is made of some.

    Attributes:
        shape: The shape.
        corners_m: Corners of its triangles [m], shape (F, 3, 3); F = 0 for a sphere and a cylinder.
        normals: Outward normals of the triangles, shape (F, 3).
    """

    shape: Shape
    corners_m: FloatArray
    normals: FloatArray


def surface_of(shape: Shape) -> Surface:
    """Triangles of boxes and meshes; where the hull stands for a mesh, those of the hull."""
    if isinstance(shape, Mesh | Box):
        vertices_m, triangles = triangles_of(shape)
        corners_m = vertices_m[triangles]
        normals = np.cross(corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0])
        lengths = np.linalg.norm(normals, axis=1)
        proper = lengths > 0
        return Surface(shape, corners_m[proper], normals[proper] / lengths[proper, None])
    return Surface(shape, np.zeros((0, 3, 3)), np.zeros((0, 3)))


def triangles_of(shape: Box | Mesh) -> tuple[FloatArray, IntArray]:
    """Vertices [m] (V, 3) and triangles (F, 3), counter-clockwise from outside."""
    import trimesh  # noqa: PLC0415 - slow to import

    if isinstance(shape, Box):
        solid = trimesh.creation.box(shape.size_m)
    elif shape.pieces_by == "hull":
        solid = trimesh.convex.convex_hull(np.concatenate(shape.pieces_m))
    else:
        return shape.vertices_m, shape.triangles
    return np.asarray(solid.vertices), np.asarray(solid.faces)


def facing_normal(surface: Surface, point_m: FloatArray, towards: FloatArray) -> FloatArray:
    """Outward normal at a point of the surface; at an edge or a corner that of the face which looks `towards` most.

    Args:
        surface: Of the part.
        point_m: A point on it, part frame [m], shape (3,).
        towards: Direction to the jaw, unit vector, shape (3,).

    Returns:
        Unit vector, shape (3,).
    """
    if isinstance(surface.shape, Sphere):
        return np.asarray(point_m / np.linalg.norm(point_m))
    if isinstance(surface.shape, Cylinder):
        normals = _cylinder_normals(surface.shape, point_m)
    else:
        normals = surface.normals[_distances_m(surface, point_m) <= _ON_M]
    return np.asarray(normals[(normals @ towards).argmax()])


def _cylinder_normals(shape: Cylinder, point_m: FloatArray) -> FloatArray:
    """Normals of its faces at a point of its surface, (N, 3)."""
    along = np.array([float(letter == shape.axis) for letter in "xyz"])
    height_m = point_m @ along
    outward = point_m - height_m * along
    radius_m = float(np.linalg.norm(outward))
    off_side, off_end = shape.radius_m - radius_m, shape.length_m / 2 - abs(height_m)
    normals = []
    if off_side <= max(_ON_M, off_end):
        normals.append(outward / radius_m)
    if off_end <= max(_ON_M, off_side):
        normals.append(np.sign(height_m) * along)
    return np.array(normals)


def _distances_m(surface: Surface, point_m: FloatArray) -> FloatArray:
    """Distance of a point from each triangle [m], shape (F,)."""
    import trimesh  # noqa: PLC0415

    points_m = np.broadcast_to(point_m, (len(surface.corners_m), 3))
    nearest_m = trimesh.triangles.closest_point(surface.corners_m, points_m)  # type: ignore[no-untyped-call]
    distances_m = np.linalg.norm(nearest_m - point_m, axis=1)
    # A point that rounding put beside the surface still lies on its nearest face.
    return np.asarray(np.where(distances_m == distances_m.min(), 0.0, distances_m))
