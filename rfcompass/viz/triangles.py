"""Flat and solid markers as triangles: hands, needles, ellipses. Many of a kind become one mesh, fast to draw."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.types.record import Record

# Of the hand's marker [m]; ours.
_FINGER_M, _BAR_M, _STEM_M = 0.04, 0.004, 0.03
# Corners and triangles of the cube [-1/2, 1/2]^3, outside seen counter-clockwise.
_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
_FACES = np.array([face for a, b, c, d in _SIDES for face in ((a, b, c), (a, c, d))])


@dataclass(frozen=True, slots=True)
class Triangles(Record):
    """A surface to draw.

    Attributes:
        vertices_m: Corners [m], shape (V, 3).
        corners: Corners of each triangle, shape (T, 3).
    """

    vertices_m: FloatArray
    corners: IntArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "vertices_m", read_only(self.vertices_m, "Triangles.vertices_m", (None, 3)))
        object.__setattr__(self, "corners", read_only(self.corners, "Triangles.corners", (None, 3), np.int64))

    def placed(self, T: FloatArray) -> "Triangles":
        """Move the surface by a homogeneous pose, shape (4, 4)."""
        return Triangles(self.vertices_m @ T[:3, :3].T + T[:3, 3], self.corners)


def join(pieces: Sequence[Triangles]) -> Triangles:
    """Make one surface of many, in their order."""
    first = np.cumsum([0, *(len(piece.vertices_m) for piece in pieces)])
    vertices_m = np.concatenate([np.zeros((0, 3)), *(piece.vertices_m for piece in pieces)])
    corners = [piece.corners + start for piece, start in zip(pieces, first[:-1], strict=True)]
    return Triangles(vertices_m, np.concatenate([np.zeros((0, 3), dtype=np.int64), *corners]))


def hand_glyph(aperture_m: float, approach: FloatArray, closing: FloatArray) -> Triangles:
    """Draw a hand as a fork in its tool frame: two fingers, a bar between them, a stem.

    Args:
        aperture_m: Distance of the fingers' inner sides [m].
        approach: Direction in which the hand moves towards a part, unit vector, shape (3,).
        closing: Direction along which the fingers close, unit vector, shape (3,).
    """
    along = (_FINGER_M + _BAR_M) / 2
    fingers = [
        _bar((side * (aperture_m + _BAR_M) / 2, 0.0, _BAR_M / 2 - along + _FINGER_M / 2), (_BAR_M, _BAR_M, _FINGER_M))
        for side in (-1, 1)
    ]
    back = _BAR_M / 2 - along - _BAR_M / 2
    bar = _bar((0.0, 0.0, back), (aperture_m + 2 * _BAR_M, _BAR_M, _BAR_M))
    stem = _bar((0.0, 0.0, back - _STEM_M / 2), (_BAR_M, _BAR_M, _STEM_M))
    T_tool_fork = np.eye(4)
    T_tool_fork[:3, :3] = np.column_stack([closing, np.cross(approach, closing), approach])
    return join([*fingers, bar, stem]).placed(T_tool_fork)


def needles(samples: FloatArray, length_m: float, height_m: float) -> Triangles:
    """Draw poses on the floor as thin flat arrowheads that point along their x axis.

    Args:
        samples: x, y, θ [m, m, rad], shape (S, 3).
        length_m: Length of a needle [m].
        height_m: Height over the floor [m].
    """
    ends_m = length_m * np.array([[0.5, 0.0], [-0.5, 0.05], [-0.5, -0.05]])
    c, s = np.cos(samples[:, 2])[:, None], np.sin(samples[:, 2])[:, None]
    x_m = samples[:, :1] + c * ends_m[:, 0] - s * ends_m[:, 1]
    y_m = samples[:, 1:2] + s * ends_m[:, 0] + c * ends_m[:, 1]
    vertices_m = np.stack([x_m, y_m, np.full_like(x_m, height_m)], axis=-1).reshape(-1, 3)
    return Triangles(vertices_m, np.arange(len(vertices_m)).reshape(-1, 3))


def polygon(vertices_m: FloatArray, height_m: float) -> Triangles:
    """Draw a convex polygon on the floor; vertices counter-clockwise [m], shape (V, 2)."""
    points_m = np.column_stack([vertices_m, np.full(len(vertices_m), height_m)])
    return Triangles(points_m, np.array([[0, i, i + 1] for i in range(1, len(points_m) - 1)]).reshape(-1, 3))


def ellipse(centre_m: FloatArray, covariance: FloatArray, probability: float) -> FloatArray:
    """Outline of the ellipse that holds a Gaussian point with a probability, counter-clockwise [m], shape (48, 2).

    Args:
        centre_m: Its mean [m], shape (2,).
        covariance: Its covariance [m²], shape (2, 2).
        probability: What the ellipse holds, below 1.
    """
    variances, axes = np.linalg.eigh(covariance)
    radii_m = np.sqrt(np.maximum(variances, 0.0) * -2.0 * np.log1p(-probability))
    turn = np.linspace(0.0, 2 * np.pi, 48, endpoint=False)
    outline = centre_m + np.column_stack([np.cos(turn), np.sin(turn)]) * radii_m @ axes.T
    return outline if np.linalg.det(axes) > 0 else outline[::-1]


def _bar(centre_m: tuple[float, float, float], size_m: tuple[float, float, float]) -> Triangles:
    return Triangles(_CORNERS * size_m + centre_m, _FACES)
