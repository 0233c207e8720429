"""Records as meshcat geometry: shapes of robots, shapes of bodies and parts, triangles."""

import meshcat.geometry as shapes
import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.types.placed_shape import PlacedShape
from rfcompass.types.shapes import Box, Cylinder, Shape, Sphere
from rfcompass.viz.triangles import Triangles

# Turns meshcat's cylinders, which stand along y, to ours and URDF's z, and to x.
_Z_FROM_Y = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
_X_FROM_Y = np.array([[0, 1.0, 0, 0], [-1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]])
_LOADERS = {".stl": shapes.StlMeshGeometry, ".obj": shapes.ObjMeshGeometry}


def material(colour: int, opacity: float = 1.0) -> shapes.Material:
    """Make a lit surface; colour 0xRRGGBB."""
    return shapes.MeshPhongMaterial(color=colour, opacity=opacity, transparent=opacity < 1.0)


def flat_material(colour: int, opacity: float = 1.0, *, by_vertex: bool = False) -> shapes.Material:
    """Make a surface that shows its colour from both sides whatever the light; 0xRRGGBB, or each vertex's own."""
    return shapes.MeshBasicMaterial(
        color=colour, opacity=opacity, transparent=opacity < 1.0, side=2, vertexColors=by_vertex
    )


def placed_geometry(shape: PlacedShape) -> shapes.Geometry:
    """Turn a shape of a robot into geometry; `T_shape_geometry` says how it stands in the shape.

    Raises:
        InputError: If it is a mesh that is neither STL nor OBJ.
    """
    match shape.kind:
        case "box":
            return shapes.Box(shape.dimensions_m.tolist())
        case "cylinder":
            radius, length = shape.dimensions_m.tolist()
            return shapes.Cylinder(length, radius)
        case "sphere":
            return shapes.Sphere(float(shape.dimensions_m[0]))
        case "ellipsoid":
            return shapes.Ellipsoid(shape.dimensions_m.tolist())
    loader = None if shape.mesh is None else _LOADERS.get(shape.mesh.suffix.lower())
    if loader is None:
        raise InputError(f"link {shape.link}: cannot draw mesh {shape.mesh}", link=shape.link)
    return loader.from_file(str(shape.mesh))


def T_shape_geometry(shape: PlacedShape) -> FloatArray:
    """Pose of `placed_geometry` in its shape: turned if a cylinder, scaled if a mesh, shape (4, 4)."""
    if shape.kind == "cylinder":
        return _Z_FROM_Y
    return np.diag([*shape.dimensions_m, 1.0]) if shape.kind == "mesh" else np.eye(4)


def solid_geometry(shape: Shape) -> shapes.Geometry:
    """Turn the shape of a body or a part into geometry; `T_solid_geometry` says how it stands in the body."""
    if isinstance(shape, Box):
        return shapes.Box(shape.size_m.tolist())
    if isinstance(shape, Cylinder):
        return shapes.Cylinder(shape.length_m, shape.radius_m)
    if isinstance(shape, Sphere):
        return shapes.Sphere(shape.radius_m)
    return shapes.TriangularMeshGeometry(shape.vertices_m, shape.triangles)


def T_solid_geometry(shape: Shape) -> FloatArray:
    """Pose of `solid_geometry` in its body: turned if a cylinder, shape (4, 4)."""
    if isinstance(shape, Cylinder):
        return _X_FROM_Y if shape.axis == "x" else _Z_FROM_Y
    return np.eye(4)


def surface(triangles: Triangles, colours: FloatArray | None = None) -> shapes.Geometry:
    """Turn triangles into geometry; red, green, blue of each vertex in [0, 1], shape (V, 3), if it has its own."""
    return shapes.TriangularMeshGeometry(triangles.vertices_m, triangles.corners, colours)
