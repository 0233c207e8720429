"""Where two jaws can close on a part: pairs of opposite points, in the part frame.

On boxes, cylinders and balls they are known. On a mesh, points are drawn on the surface, evenly by area; from each a
ray goes through the solid along the closing direction c, and where it leaves is the other contact. With outward normals
n, m and the friction coefficient μ the two hold if

    angle(n, c) ≤ atan μ   and   angle(m, -c) ≤ atan μ            (both inside their friction cones)

which is right for concave solids too: each ray crosses one wall. c is level where the cone allows it, since a hand
that comes from above closes level; else it is the normal.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import PartError
from rfcompass.types.record import Record
from rfcompass.types.shapes import Box, Cylinder, Mesh, Shape, Sphere

if TYPE_CHECKING:
    import trimesh

X, Y, Z = np.eye(3)

# Ours. Distance of the outermost contacts from the end of a part: half a finger. A ray starts this far inside.
_EDGE_M = 0.01
_INSIDE_M = 1e-5


@dataclass(frozen=True, slots=True)
class ContactPair(Record):
    """Two opposite points.

    Attributes:
        middle_m: Half way between them [m], shape (3,).
        closing: Direction from the second to the first, unit vector, shape (3,).
        width_m: Distance between them [m].
        angle_rad: Larger of the two angles between closing direction and normal [rad].
        is_round: The part is round about the vertical here: any heading is as good.
    """

    middle_m: FloatArray
    closing: FloatArray
    width_m: float
    angle_rad: float = 0.0
    is_round: bool = False

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "middle_m", read_only(self.middle_m, "ContactPair.middle_m", (3,)))
        object.__setattr__(self, "closing", read_only(self.closing, "ContactPair.closing", (3,)))


def contact_pairs(
    shape: Shape, *, spacing_m: float, headings: int, samples: int, rng: np.random.Generator
) -> list[ContactPair]:
    """List pairs of opposite points, whether or not the jaws open wide enough or the friction holds.

    Args:
        shape: A solid in the part frame. A mesh whose surface has holes stands for the convex hull of its one piece.
        spacing_m: Distance between contacts along the part [m].
        headings: Closing directions about the vertical for what is round, over half a turn.
        samples: Points drawn on a mesh.
        rng: Draws them.

    Raises:
        PartError: If the surface of a mesh has holes, and no single convex piece stands for the solid.
    """
    match shape:
        case Box():
            return list(_box(shape.size_m, spacing_m))
        case Cylinder(axis="x"):
            return list(_lying(shape, spacing_m))
        case Cylinder():
            return [*_standing(shape, spacing_m, headings), ContactPair(np.zeros(3), Z, shape.length_m)]
        case Sphere():
            level = [ContactPair(np.zeros(3), c, 2 * shape.radius_m, is_round=True) for c in _level(headings)]
            return [*level, ContactPair(np.zeros(3), Z, 2 * shape.radius_m)]
        case Mesh():
            return _thinned(_on_mesh(closed_surface(shape), samples, rng), spacing_m)


def _box(size_m: FloatArray, spacing_m: float) -> Iterator[ContactPair]:
    """Opposite faces: places along the longer side, and in the middle and at both ends of the other."""
    for axis, others in ((1, (0, 2)), (0, (1, 2)), (2, (0, 1))):
        long, short = sorted(others, key=lambda k: -size_m[k])
        for u in _spread(float(size_m[long]), spacing_m):
            for v in _ends_and_middle(float(size_m[short]), spacing_m):
                yield ContactPair(u * np.eye(3)[long] + v * np.eye(3)[short], np.eye(3)[axis], float(size_m[axis]))


def _lying(shape: Cylinder, spacing_m: float) -> Iterator[ContactPair]:
    for closing in (Y, Z):
        for along in _spread(shape.length_m, spacing_m):
            yield ContactPair(along * X, closing, 2 * shape.radius_m)
    yield ContactPair(np.zeros(3), X, shape.length_m)


def _standing(shape: Cylinder, spacing_m: float, headings: int) -> Iterator[ContactPair]:
    for height in _spread(shape.length_m, spacing_m):
        for closing in _level(headings):
            yield ContactPair(height * Z, closing, 2 * shape.radius_m, is_round=True)


def _spread(length_m: float, spacing_m: float) -> FloatArray:
    """Places along a part, the middle among them, symmetric to it [m]."""
    half = max(0, int((length_m / 2 - _EDGE_M) / spacing_m))
    return np.asarray(spacing_m * np.arange(-half, half + 1), dtype=np.float64)


def _ends_and_middle(length_m: float, spacing_m: float) -> list[float]:
    end = length_m / 2 - _EDGE_M
    return [-end, 0.0, end] if end >= spacing_m else [0.0]


def _level(headings: int) -> FloatArray:
    turns = np.pi * np.arange(headings) / headings
    return np.column_stack([np.cos(turns), np.sin(turns), np.zeros(headings)])


def closed_surface(shape: Mesh) -> "trimesh.Trimesh":
    """The surface that rays are cast through: the mesh, or the hull that stands for one with holes.

    Raises:
        PartError: If there are holes, and more than one piece.
    """
    import trimesh  # noqa: PLC0415 - slow to import, and a part of primitives needs none

    surface = trimesh.Trimesh(shape.vertices_m, shape.triangles, process=False)
    surface.merge_vertices()
    if surface.is_watertight:
        return surface
    if len(shape.pieces_m) > 1:
        message = f"the surface has holes, and {len(shape.pieces_m)} pieces stand for the solid: no inside to close on"
        raise PartError(message, pieces=len(shape.pieces_m))
    return trimesh.convex.convex_hull(shape.pieces_m[0])


def _on_mesh(surface: "trimesh.Trimesh", samples: int, rng: np.random.Generator) -> list[ContactPair]:
    first_m, normals = _draw(surface, samples, rng)
    closing = _level_where_possible(normals)
    inside_m = first_m - _INSIDE_M * closing
    second_m, rays, faces = surface.ray.intersects_location(inside_m, -closing, multiple_hits=False)
    opposite = np.asarray(surface.face_normals)[faces]
    first_m, closing, normals = first_m[rays], closing[rays], normals[rays]
    cosines = np.minimum((normals * closing).sum(axis=1), -(opposite * closing).sum(axis=1))
    angles = np.arccos(np.clip(cosines, -1, 1))
    widths = np.linalg.norm(first_m - second_m, axis=1)
    rows = zip((first_m + second_m) / 2, closing, widths, angles, strict=True)
    return [ContactPair(middle, c, float(width), float(angle)) for middle, c, width, angle in rows]


def _draw(surface: "trimesh.Trimesh", samples: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Points spread evenly over a surface, and its outward normals there, (S, 3) each."""
    shares = np.asarray(surface.area_faces) / surface.area
    faces: IntArray = rng.choice(len(shares), samples, p=shares)
    u, v = rng.uniform(size=(2, samples))
    over = u + v > 1
    u[over], v[over] = 1 - u[over], 1 - v[over]
    corners = np.asarray(surface.triangles)[faces]
    edges = corners[:, 1:] - corners[:, :1]
    points_m = corners[:, 0] + u[:, None] * edges[:, 0] + v[:, None] * edges[:, 1]
    return points_m, np.asarray(surface.face_normals)[faces]


def _level_where_possible(normals: FloatArray) -> FloatArray:
    """Closing directions: the normals, made level where they lean by less than 45 degrees, (S, 3)."""
    level = normals * [1.0, 1.0, 0.0]
    lengths = np.linalg.norm(level, axis=1, keepdims=True)
    leans = lengths[:, 0] > np.sqrt(0.5)
    return np.where(leans[:, None], level / np.maximum(lengths, 1e-12), normals)


def _thinned(pairs: list[ContactPair], spacing_m: float) -> list[ContactPair]:
    """Of pairs that are much alike, the one that is nearest to perpendicular: best first, in the order of place."""
    kept: dict[tuple[int, ...], ContactPair] = {}
    for pair in pairs:
        cell = _cell(pair, spacing_m)
        if cell not in kept or pair.angle_rad < kept[cell].angle_rad:
            kept[cell] = pair
    return [kept[cell] for cell in sorted(kept)]


def _cell(pair: ContactPair, spacing_m: float) -> tuple[int, ...]:
    """Place by the spacing and closing axis by about 15 degrees, without its sign: half a turn is the same grasp."""
    signs = np.sign(np.round(pair.closing, 6))
    axis = pair.closing * next((sign for sign in signs if sign), 1.0)
    return (*np.round(pair.middle_m / spacing_m).astype(int), *np.round(axis * 4).astype(int))
