"""Shapes to draw, placed in the world: all that a viewer needs to know about a robot or a pile."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.types.record import Record

# Kinds of mesh files that viewers draw.
DRAWN_MESHES = (".stl", ".obj")
# Numbers that each kind of shape has.
DIMENSIONS = {"box": 3, "cylinder": 2, "sphere": 1, "ellipsoid": 3, "mesh": 3}


@dataclass(frozen=True, slots=True)
class PlacedShape(Record):
    """One coloured shape at its place in the world.

    Attributes:
        link: Link that it belongs to.
        kind: `"box"`, `"cylinder"` (axis along z), `"sphere"`, `"ellipsoid"` or `"mesh"`.
        dimensions_m: Box: edges along x, y, z; cylinder: radius, length; sphere: radius; ellipsoid: half-axes
            along x, y, z [m]. Mesh: scale along x, y, z, a plain factor. The origin of a primitive is its centre.
        T_world_shape: Homogeneous pose, shape (4, 4).
        rgba: Red, green, blue, opacity, each in [0, 1], shape (4,).
        mesh: File of a mesh; None for a primitive.
    """

    link: str
    kind: str
    dimensions_m: FloatArray
    T_world_shape: FloatArray
    rgba: FloatArray
    mesh: Path | None = None

    def __post_init__(self) -> None:
        """Freeze the arrays; check the kind, the number of dimensions and the pose."""
        name, set_ = f"PlacedShape[{self.link}]", object.__setattr__
        if self.kind not in DIMENSIONS:
            raise InputError(f"{name}: unknown kind {self.kind!r}; known: {', '.join(DIMENSIONS)}", kind=self.kind)
        if (self.kind == "mesh") != (self.mesh is not None):
            raise InputError(f"{name}: a mesh has a file, anything else has none", kind=self.kind)
        dimensions_m = read_only(self.dimensions_m, f"{name}.dimensions_m", (DIMENSIONS[self.kind],))
        set_(self, "dimensions_m", dimensions_m)
        if self.kind != "mesh" and not (dimensions_m > 0).all():
            raise ShapeError(f"{name}: {self.kind} of size {dimensions_m.tolist()} m", name=name)
        set_(self, "T_world_shape", read_only(self.T_world_shape, f"{name}.T_world_shape", (4, 4)))
        R, last_row = self.T_world_shape[:3, :3], self.T_world_shape[3].tolist()
        if np.abs(R @ R.T - np.eye(3)).max() > 1e-6 or last_row != [0, 0, 0, 1]:
            raise ShapeError(f"{name}.T_world_shape: is no rigid pose", name=name)
        set_(self, "rgba", read_only(self.rgba, f"{name}.rgba", (4,)))
