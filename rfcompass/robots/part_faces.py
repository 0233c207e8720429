"""A part as faces in a tree of boxes: what the fast judge of grasps works on."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.robots.part_surface import triangles_of
from rfcompass.types.shapes import Box, Cylinder, Shape, Sphere

# Where normals come from: the faces, or the round surface that they stand for.
FLAT, ROUND_X, ROUND_Z, BALL = 0, 1, 2, 3

# Ours. A circle becomes this many edges, 7 µm off at a radius of 25 mm; a ball an icosahedron halved so often, 35 µm
# off at 30 mm.
_SECTIONS, _HALVINGS = 96, 3
# Faces in a leaf of the tree.
_LEAF = 4
# Parts whose trees are kept.
_KEPT = 16


@dataclass(frozen=True, slots=True)
class PartFaces:
    """Faces of a closed surface in the part frame, in the order of the tree's leaves.

    Attributes:
        corners_m: Corners of each face, a triangle's last one twice [m], shape (F, 4, 3).
        normals: Outward unit normals, shape (F, 3).
        box_m: Lower and upper corner of a box; for anything else there is none [m], shape (1, 2, 3) or (0, 2, 3).
        round_kind: `FLAT`, or what the faces stand for.
        round_m: Radius and half the length of what they stand for [m], shape (2,).
        nodes_m: Lower and upper corner of each node's box [m], shape (N, 2, 3).
        children: Each node's two children, or -1 and -1 for a leaf; then its first face and their number, shape (N, 4).
    """

    corners_m: FloatArray
    normals: FloatArray
    box_m: FloatArray
    round_kind: int
    round_m: FloatArray
    nodes_m: FloatArray
    children: IntArray

    @property
    def radius_m(self) -> float:
        """Distance of the farthest corner from the part frame's origin [m]."""
        return float(np.linalg.norm(self.corners_m, axis=2).max())


def part_faces(shape: Shape) -> PartFaces:
    """Faces of a shape; those of the last few shapes are kept."""
    return _kept_faces(_Same(shape))


class _Same:
    """A shape as a key: records of arrays have no hash, and one that is the same object has the same faces."""

    def __init__(self, shape: Shape) -> None:
        self.shape = shape

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other.shape is self.shape

    def __hash__(self) -> int:
        return id(self.shape)


@lru_cache(maxsize=_KEPT)
def _kept_faces(key: _Same) -> PartFaces:
    shape, none = key.shape, np.zeros((0, 2, 3))
    if isinstance(shape, Box):
        return _with_tree(_box_faces(shape), np.array([[shape.lower_m, shape.upper_m]]), FLAT, np.zeros(2))
    if isinstance(shape, Cylinder):
        kind = ROUND_X if shape.axis == "x" else ROUND_Z
        return _with_tree(_rod_faces(shape), none, kind, np.array([shape.radius_m, shape.length_m / 2]))
    if isinstance(shape, Sphere):
        return _with_tree(_ball_faces(shape), none, BALL, np.array([shape.radius_m, 0.0]))
    vertices_m, triangles = triangles_of(shape)
    return _with_tree(vertices_m[triangles], none, FLAT, np.zeros(2))


def _box_faces(box: Box) -> FloatArray:
    """Six rectangles, (6, 4, 3)."""
    square = np.array([[1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]])
    turned = [np.roll(square, axis, axis=1) for axis in range(3)]
    # Mirrored through the centre the corners run the other way round.
    return np.array([*turned, *(-face[::-1] for face in turned)]) * box.size_m / 2


def _rod_faces(rod: Cylinder) -> FloatArray:
    """A side of rectangles, ends of quadrangles, (F, 4, 3)."""
    # Between the circle's inscribed and circumscribed polygon.
    radius_m = 2 * rod.radius_m / (1 + np.cos(np.pi / _SECTIONS))
    turns = 2 * np.pi * np.arange(_SECTIONS) / _SECTIONS
    high = np.column_stack([radius_m * np.cos(turns), radius_m * np.sin(turns), np.full(_SECTIONS, rod.length_m / 2)])
    low = high * [1.0, 1.0, -1.0]
    side = np.stack([low, np.roll(low, -1, axis=0), np.roll(high, -1, axis=0), high], axis=1)
    fan = np.arange(1, _SECTIONS - 1, 2)
    top = np.stack([high[np.zeros_like(fan)], high[fan], high[fan + 1], high[(fan + 2) % _SECTIONS]], axis=1)
    faces_m = np.concatenate([side, top, top[:, ::-1] * [1.0, 1.0, -1.0]])
    return np.roll(faces_m, 1, axis=2) if rod.axis == "x" else faces_m


def _ball_faces(ball: Sphere) -> FloatArray:
    import trimesh  # noqa: PLC0415

    solid = trimesh.creation.icosphere(subdivisions=_HALVINGS, radius=1.0)
    corners = np.asarray(solid.vertices[solid.faces])
    lowest = float(np.linalg.norm(corners.mean(axis=1), axis=1).min())
    return corners * (2 * ball.radius_m / (1 + lowest))


def _with_tree(corners_m: FloatArray, box_m: FloatArray, kind: int, round_m: FloatArray) -> PartFaces:
    normals = np.cross(corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    proper = lengths > 0
    corners_m, normals = corners_m[proper], normals[proper] / lengths[proper, None]
    if corners_m.shape[1] == 3:
        corners_m = corners_m[:, [0, 1, 2, 2]]
    order, rows = np.arange(len(corners_m)), []
    bounds_m = np.stack([corners_m.min(axis=1), corners_m.max(axis=1)], axis=1)
    for first, last, children in _nodes(order, bounds_m):
        own = bounds_m[order[first:last]]
        rows.append((own[:, 0].min(axis=0), own[:, 1].max(axis=0), (*children, first, last - first)))
    return PartFaces(
        corners_m=corners_m[order],
        normals=normals[order],
        box_m=box_m,
        round_kind=kind,
        round_m=round_m,
        nodes_m=np.array([(lower, upper) for lower, upper, _ in rows]),
        children=np.array([children for *_, children in rows], dtype=np.int64),
    )


def _nodes(order: IntArray, bounds_m: FloatArray) -> Iterator[tuple[int, int, tuple[int, int]]]:
    """Halve the faces along the longest side, breadth first; sorts `order` on the way. Yields first, last, children."""
    waiting, known = [(0, len(order))], 1
    while waiting:
        first, last = waiting.pop(0)
        if last - first <= _LEAF:
            yield first, last, (-1, -1)
            continue
        middles_m = bounds_m[order[first:last]].mean(axis=1)
        axis = int(np.ptp(middles_m, axis=0).argmax())
        order[first:last] = order[first:last][np.argsort(middles_m[:, axis], kind="stable")]
        middle = (first + last) // 2
        waiting += [(first, middle), (middle, last)]
        yield first, last, (known, known + 1)
        known += 2
