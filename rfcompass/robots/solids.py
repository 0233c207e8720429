"""Convex solids: what collision checks are made of, whichever library does the check.

A robot's links and the bodies of a world become primitives and convex hulls, each on a carrier: a link, or the world.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import PartError, RobotModelError
from rfcompass.robots.robot import Robot
from rfcompass.robots.shapes import LinkShape
from rfcompass.types.record import Record
from rfcompass.types.shapes import Box, Cylinder, Shape, Sphere
from rfcompass.types.world import Body

# Rotation that lays a cylinder's axis from z along x.
_Z_ALONG_X = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


@dataclass(frozen=True, slots=True)
class Solid(Record):
    """One convex piece.

    Attributes:
        owner: Link or body that it belongs to; reports use this name.
        carrier: Link that moves it; `"world"` if it stands still.
        kind: `"box"`, `"cylinder"` (axis along z), `"sphere"` or `"hull"`.
        dimensions_m: Box: edges; cylinder: radius, length; sphere: radius; hull: empty [m].
        T_carrier_solid: Homogeneous pose, shape (4, 4).
        corners_m: Corners of a hull in its own frame [m], shape (V, 3); V = 0 for a primitive.
        triangles: Faces of a hull, counter-clockwise from outside, shape (F, 3).
    """

    owner: str
    carrier: str
    kind: str
    dimensions_m: FloatArray
    T_carrier_solid: FloatArray
    corners_m: FloatArray
    triangles: IntArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        name, set_ = f"Solid[{self.owner}]", object.__setattr__
        set_(self, "dimensions_m", read_only(self.dimensions_m, f"{name}.dimensions_m", (None,)))
        set_(self, "T_carrier_solid", read_only(self.T_carrier_solid, f"{name}.T_carrier_solid", (4, 4)))
        set_(self, "corners_m", read_only(self.corners_m, f"{name}.corners_m", (None, 3)))
        set_(self, "triangles", read_only(self.triangles, f"{name}.triangles", (None, 3), np.int64))

    @property
    def half_size_m(self) -> FloatArray:
        """Half the edges of its bounding box [m], shape (3,)."""
        if self.kind == "box":
            return self.dimensions_m / 2
        if self.kind == "cylinder":
            radius, length = self.dimensions_m
            return np.array([radius, radius, length / 2])
        if self.kind == "sphere":
            return np.full(3, self.dimensions_m[0])
        return np.asarray(np.ptp(self.corners_m, axis=0) / 2)

    @property
    def T_carrier_box(self) -> FloatArray:
        """Pose of the centre of its bounding box, shape (4, 4)."""
        T = self.T_carrier_solid.copy()
        if self.kind == "hull":
            middle = (self.corners_m.min(axis=0) + self.corners_m.max(axis=0)) / 2
            T[:3, 3] += T[:3, :3] @ middle
        return T

    def lowest_m(self, T_world_solid: FloatArray) -> float:
        """Height of its lowest point [m] at a pose of shape (4, 4): exact, the support function downwards."""
        down, height = -T_world_solid[2, :3], float(T_world_solid[2, 3])
        if self.kind == "box":
            return height - float(np.abs(down) @ self.dimensions_m) / 2
        if self.kind == "cylinder":
            radius, length = self.dimensions_m
            return height - float(radius * np.hypot(down[0], down[1]) + abs(down[2]) * length / 2)
        if self.kind == "sphere":
            return height - float(self.dimensions_m[0])
        return height - float((self.corners_m @ down).max())


def padded(solid: Solid, padding_m: float) -> Solid:
    """Grow a solid by at least `padding_m` to all sides; corners grow a little more, since a box stays a box.

    A hull becomes its Minkowski sum with a cube of twice that edge.
    """
    if padding_m == 0.0:
        return solid
    if solid.kind == "hull":
        cube = padding_m * np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
        grown = (solid.corners_m[:, None] + cube).reshape(-1, 3)
        return _hull(solid.owner, solid.carrier, solid.T_carrier_solid, grown)
    growth = {"box": np.full(3, 2.0), "cylinder": np.array([1.0, 2.0]), "sphere": np.ones(1)}[solid.kind]
    return _primitive(solid, solid.kind, solid.dimensions_m + padding_m * growth, solid.T_carrier_solid)


def robot_solids(robot: Robot, *, with_tags: bool = False) -> tuple[Solid, ...]:
    """Convex pieces of a robot; a mesh becomes its hull.

    Args:
        robot: Whose.
        with_tags: Take the tags for solid bodies as well.

    Raises:
        RobotModelError: If a mesh is missing or has no volume.
    """
    shapes = (*robot.collision_shapes, *(robot.tag_shapes if with_tags else ()))
    return tuple(_of_link_shape(shape) for shape in shapes)


def body_solids(body: Body) -> tuple[Solid, ...]:
    """Convex pieces of a body; a mesh becomes its pieces.

    Raises:
        PartError: If a piece of a mesh lies in a plane.
    """
    return tuple(_of_shape(body, body.shape))


def _of_link_shape(shape: LinkShape) -> Solid:
    if shape.mesh is None:
        return _primitive(_Frame(shape.link, shape.link), shape.kind, shape.dimensions_m, shape.T_link_shape)
    corners_m = _mesh_corners(shape.mesh) * shape.dimensions_m
    if _is_flat(corners_m):
        message = f"link {shape.link!r}: mesh {shape.mesh} has no volume"
        raise RobotModelError(message, link=shape.link, file=str(shape.mesh))
    return _hull(shape.link, shape.link, shape.T_link_shape, corners_m)


def _of_shape(body: Body, shape: Shape) -> Iterator[Solid]:
    T = body.T_parent_body
    frame = _Frame(body.name, body.parent)
    if isinstance(shape, Box):
        yield _primitive(frame, "box", shape.size_m, T)
    elif isinstance(shape, Cylinder):
        turned = T.copy()
        if shape.axis == "x":
            turned[:3, :3] = T[:3, :3] @ _Z_ALONG_X
        yield _primitive(frame, "cylinder", np.array([shape.radius_m, shape.length_m]), turned)
    elif isinstance(shape, Sphere):
        yield _primitive(frame, "sphere", np.array([shape.radius_m]), T)
    else:
        if any(map(_is_flat, shape.pieces_m)):
            raise PartError(f"body {body.name}: a piece of its mesh lies in a plane", body=body.name)
        yield from (_hull(body.name, body.parent, T, piece) for piece in shape.pieces_m)


@dataclass(frozen=True, slots=True)
class _Frame:
    owner: str
    carrier: str


def _primitive(of: Solid | _Frame, kind: str, dimensions_m: FloatArray, T: FloatArray) -> Solid:
    none = np.zeros((0, 3))
    return Solid(of.owner, of.carrier, kind, dimensions_m, T, none, none.astype(np.int64))


def _hull(owner: str, carrier: str, T: FloatArray, points_m: FloatArray) -> Solid:
    """Convex hull of points that do not lie in a plane."""
    import trimesh  # noqa: PLC0415 - slow to import, and a robot of primitives needs none

    hull = trimesh.convex.convex_hull(points_m)
    return Solid(owner, carrier, "hull", np.zeros(0), T, np.asarray(hull.vertices), np.asarray(hull.faces))


def _is_flat(points_m: FloatArray) -> bool:
    """True if points lie in a plane, up to a nanometre."""
    return bool(np.linalg.svd(points_m - points_m.mean(axis=0), compute_uv=False)[-1] < 1e-9)


@cache
def _mesh_corners(file: Path) -> FloatArray:
    """Vertices of a mesh file's hull, unscaled, shape (V, 3)."""
    import trimesh  # noqa: PLC0415

    try:
        return np.asarray(trimesh.load_mesh(file).convex_hull.vertices)
    except (ValueError, OSError, ImportError, IndexError) as cause:
        raise RobotModelError(f"mesh {file} cannot be read: {cause}", file=str(file)) from cause
