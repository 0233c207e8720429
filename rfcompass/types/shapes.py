"""Shapes of parts, in the part frame.

Part frame, for every shape: origin at the centre of mass, z up as the part lies on a floor, x along its longest
horizontal side. The plane pose (x, y, θ) of [Wang2013], Eq. 1, is the pose of this frame.
"""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import PartError
from rfcompass.types.record import Record


def positive(value: float, name: str) -> float:
    """Return a finite number above zero.

    Raises:
        PartError: If it is anything else.
    """
    try:
        number = float(value)
    except (TypeError, ValueError) as cause:
        raise PartError(f"{name}: {value!r} is no number", name=name) from cause
    if not (np.isfinite(number) and number > 0):
        raise PartError(f"{name}: {value!r} is not a finite number above 0", name=name, got=number)
    return number


@dataclass(frozen=True, slots=True)
class Box(Record):
    """A solid cuboid.

    Attributes:
        size_m: Edges along x, y and z [m], shape (3,).
    """

    size_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze and check the edges."""
        size_m = read_only(self.size_m, "Box.size_m", (3,))
        for length_m in size_m:
            positive(length_m, "Box.size_m")
        object.__setattr__(self, "size_m", size_m)

    @property
    def lower_m(self) -> FloatArray:
        """Lowest corner of the bounding box [m], shape (3,)."""
        return -self.size_m / 2

    @property
    def upper_m(self) -> FloatArray:
        """Highest corner of the bounding box [m], shape (3,)."""
        return self.size_m / 2

    @property
    def volume_m3(self) -> float:
        """Volume [m³]."""
        return float(np.prod(self.size_m))

    @property
    def inertia_per_mass_m2(self) -> FloatArray:
        """Inertia of the homogeneous solid about its centre, divided by its mass [m²], shape (3, 3)."""
        squares = self.size_m**2
        return np.diag(squares.sum() - squares) / 12


@dataclass(frozen=True, slots=True)
class Cylinder(Record):
    """A solid cylinder.

    Attributes:
        radius_m: Radius [m].
        length_m: Length along its axis [m].
        axis: `"x"` when it lies on its side, `"z"` when it stands.
    """

    radius_m: float
    length_m: float
    axis: str = "x"

    def __post_init__(self) -> None:
        """Check the lengths and the axis."""
        object.__setattr__(self, "radius_m", positive(self.radius_m, "Cylinder.radius_m"))
        object.__setattr__(self, "length_m", positive(self.length_m, "Cylinder.length_m"))
        if self.axis not in ("x", "z"):
            raise PartError(f"Cylinder.axis: {self.axis!r} is neither 'x' nor 'z'", name="Cylinder.axis")

    @property
    def lower_m(self) -> FloatArray:
        """Lowest corner of the bounding box [m], shape (3,)."""
        return -self.upper_m

    @property
    def upper_m(self) -> FloatArray:
        """Highest corner of the bounding box [m], shape (3,)."""
        return np.where(self._along, self.length_m / 2, self.radius_m)

    @property
    def volume_m3(self) -> float:
        """Volume [m³]."""
        return float(np.pi * self.radius_m**2 * self.length_m)

    @property
    def inertia_per_mass_m2(self) -> FloatArray:
        """Inertia of the homogeneous solid about its centre, divided by its mass [m²], shape (3, 3)."""
        along, across = self.radius_m**2 / 2, (3 * self.radius_m**2 + self.length_m**2) / 12
        return np.diag(np.where(self._along, along, across))

    @property
    def _along(self) -> list[bool]:
        return [axis == self.axis for axis in "xyz"]


@dataclass(frozen=True, slots=True)
class Sphere(Record):
    """A solid ball.

    Attributes:
        radius_m: Radius [m].
    """

    radius_m: float

    def __post_init__(self) -> None:
        """Check the radius."""
        object.__setattr__(self, "radius_m", positive(self.radius_m, "Sphere.radius_m"))

    @property
    def lower_m(self) -> FloatArray:
        """Lowest corner of the bounding box [m], shape (3,)."""
        return -self.upper_m

    @property
    def upper_m(self) -> FloatArray:
        """Highest corner of the bounding box [m], shape (3,)."""
        return np.full(3, self.radius_m)

    @property
    def volume_m3(self) -> float:
        """Volume [m³]."""
        return float(4 / 3 * np.pi * self.radius_m**3)

    @property
    def inertia_per_mass_m2(self) -> FloatArray:
        """Inertia of the homogeneous solid about its centre, divided by its mass [m²], shape (3, 3)."""
        return np.eye(3) * 2 / 5 * self.radius_m**2


@dataclass(frozen=True, slots=True)
class Mesh(Record):
    """A surface of triangles.

    Attributes:
        vertices_m: Corners in the part frame [m], shape (V, 3).
        triangles: Corners of each triangle, outside seen counter-clockwise, shape (T, 3).
        pieces_m: Corners of each convex piece that the shape is made of, for collision and contact [m], each (P, 3).
        pieces_by: Where the pieces come from: `"convex"` (the shape is its own hull), `"vhacd"` (approximate
            decomposition) or `"hull"` (the hull stands for a shape that is not convex).
        T_part_file: Frame of the mesh file, scaled to metres, in the part frame, homogeneous, shape (4, 4).
    """

    vertices_m: FloatArray
    triangles: IntArray
    pieces_m: tuple[FloatArray, ...]
    pieces_by: str
    T_part_file: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays; check the triangles, the pieces and the frame."""
        set_ = object.__setattr__
        set_(self, "vertices_m", read_only(self.vertices_m, "Mesh.vertices_m", (None, 3)))
        set_(self, "triangles", read_only(self.triangles, "Mesh.triangles", (None, 3), np.int64))
        pieces_m = tuple(read_only(piece, f"Mesh.pieces_m[{i}]", (None, 3)) for i, piece in enumerate(self.pieces_m))
        set_(self, "pieces_m", pieces_m)
        set_(self, "T_part_file", rigid_transform(self.T_part_file, "Mesh.T_part_file"))
        V = len(self.vertices_m)
        if not len(self.triangles) or self.triangles.min() < 0 or self.triangles.max() >= V:
            raise PartError(f"Mesh.triangles: must be at least one, of corners 0 to {V - 1}", name="triangles")
        if not pieces_m or min(map(len, pieces_m)) < 4:
            raise PartError("Mesh.pieces_m: at least one piece, each of four corners or more, is needed", name="pieces")
        if self.pieces_by not in ("convex", "vhacd", "hull"):
            raise PartError(f"Mesh.pieces_by: {self.pieces_by!r} is none of convex, vhacd, hull", name="pieces_by")

    @property
    def lower_m(self) -> FloatArray:
        """Lowest corner of the bounding box [m], shape (3,)."""
        return np.asarray(self.vertices_m.min(axis=0))

    @property
    def upper_m(self) -> FloatArray:
        """Highest corner of the bounding box [m], shape (3,)."""
        return np.asarray(self.vertices_m.max(axis=0))

    def from_file_m(self, points_m: FloatArray) -> FloatArray:
        """Move points of the mesh file's frame into the part frame.

        Args:
            points_m: Points, for example tags measured in a drawing, in metres, shape (N, 3).
        """
        return np.asarray(points_m @ self.T_part_file[:3, :3].T + self.T_part_file[:3, 3])


def rigid_transform(value: FloatArray, name: str) -> FloatArray:
    """Return a homogeneous transform as a read-only array, shape (4, 4).

    Raises:
        PartError: If its rotation is none, or its last row is not (0, 0, 0, 1).
    """
    T = read_only(value, name, (4, 4))
    R = T[:3, :3]
    turns = np.allclose(R @ R.T, np.eye(3), atol=1e-6) and np.linalg.det(R) > 0
    if not (turns and np.array_equal(T[3], [0, 0, 0, 1])):
        raise PartError(f"{name}: is no rigid transform", name=name)
    return T


Solid: TypeAlias = Box | Cylinder | Sphere
Shape: TypeAlias = Solid | Mesh
