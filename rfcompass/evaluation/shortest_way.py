"""The shortest way of a base around what stands on the floor: a bound that no drive without a touch can undercut.

Whatever its heading, the base contains a disc about its centre, so the centre stays at least the disc's radius away
from things that reach the floor. The shortest way of that disc runs along straight lines and around grown outlines: a
shortest path in their visibility graph [LozanoPerez1979], by Dijkstra's algorithm. Outlines are grown by a polygon
inside the disc, and what a robot bumps into above the floor is left out, so the length is a lower bound.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import ConvexHull

from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.types.scene import Obstacle
from rfcompass.types.shapes import Box

_AROUND = 8  # corners of the polygon in place of a disc
_TOUCH = 1e-9


def outlines_m(obstacles: Iterable[Obstacle], below_m: float, clear_m: float) -> list[FloatArray]:
    """Convex outlines of upright things that reach the floor, grown by a disc [m], counter-clockwise, (V, 2) each.

    Args:
        obstacles: Things in the scene.
        below_m: Those that begin below this height count [m].
        clear_m: Radius of the disc [m].
    """
    return [_outline_m(one, clear_m) for one in obstacles if one.bounds_m[0, 2] < below_m]


def shortest_way_m(start_m: FloatArray, end_m: FloatArray, outlines: Sequence[FloatArray]) -> float | None:
    """Length of the shortest way between two points that crosses no outline [m].

    Outlines that hold an end are left out, which keeps the length a lower bound.

    Args:
        start_m: One end [m], shape (2,).
        end_m: The other end [m], shape (2,).
        outlines: Convex polygons, counter-clockwise, shape (V, 2) each.

    Returns:
        The length; None if no way leads there.
    """
    ends_m = np.array([start_m, end_m])
    blocking = [outline for outline in outlines if not any(_holds(outline, end) for end in ends_m)]
    corners = [c for c in np.concatenate([ends_m, *blocking]) if not any(_holds(outline, c) for outline in blocking)]
    nodes_m = np.array(corners)
    n = len(nodes_m)
    i, j = np.triu_indices(n, 1)
    seen = np.ones(len(i), dtype=np.bool_)
    for outline in blocking:
        seen[seen] = ~_crossed(outline, nodes_m[i[seen]], nodes_m[j[seen]])
    lengths_m = np.linalg.norm(nodes_m[i[seen]] - nodes_m[j[seen]], axis=1)
    graph = csr_array((np.maximum(lengths_m, 1e-12), (i[seen], j[seen])), shape=(n, n))
    length_m = float(dijkstra(graph, directed=False, indices=0)[1])
    return length_m if np.isfinite(length_m) else None


def _outline_m(obstacle: Obstacle, clear_m: float) -> FloatArray:
    low_m, high_m = obstacle.shape.lower_m, obstacle.shape.upper_m
    corners_m = np.array(np.meshgrid(*zip(low_m, high_m, strict=True))).reshape(3, -1).T
    if not isinstance(obstacle.shape, Box) and obstacle.shape.axis == "z":
        corners_m = np.column_stack([obstacle.shape.radius_m * _circle(), np.zeros(_AROUND)])
    T = obstacle.T_scene_obstacle
    flat_m = (corners_m @ T[:3, :3].T + T[:3, 3])[:, :2]
    points_m = (flat_m[:, None] + clear_m * _circle()).reshape(-1, 2)
    return np.asarray(points_m[ConvexHull(points_m).vertices])


def _circle() -> FloatArray:
    angles_rad = 2 * np.pi * np.arange(_AROUND) / _AROUND
    return np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])


def _sides(outline: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit normals pointing outwards (V, 2), and offsets (V,) of the sides of a polygon."""
    along = np.roll(outline, -1, axis=0) - outline
    normals = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True)
    return normals, (normals * outline).sum(axis=1)


def _holds(outline: FloatArray, point_m: FloatArray) -> bool:
    normals, offsets = _sides(outline)
    return bool((normals @ point_m < offsets - _TOUCH).all())


def _crossed(outline: FloatArray, from_m: FloatArray, to_m: FloatArray) -> BoolArray:
    """Whether straight lines pass through the inside of an outline, shape (E,)."""
    normals, offsets = _sides(outline)
    at, rate = from_m @ normals.T - offsets + _TOUCH, (to_m - from_m) @ normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        meets = -at / rate
    enter = np.where(rate < 0, meets, np.where((rate == 0) & (at >= 0), np.inf, -np.inf)).max(axis=1)
    leave = np.where(rate > 0, meets, np.inf).min(axis=1)
    return np.asarray(np.minimum(leave, 1.0) - np.maximum(enter, 0.0) > _TOUCH)
