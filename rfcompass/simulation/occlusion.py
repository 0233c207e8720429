"""Compiled: what obstacles take from a straight leg of a path, and how much longer they make it.

A box or a cylinder that a leg passes over a chord of length t takes `surface + per_metre · t` [dB] and adds
(√ε - 1) t to the electrical length. Where the leg begins or ends inside, t is the part inside.
"""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.types.scene import Material, Scene
from rfcompass.types.shapes import Box


class ObstacleTable(NamedTuple):
    """All obstacles of a scene, ready for the kernels.

    Attributes:
        bounds_m: Lowest and highest corner along the axes of the scene [m], shape (N, 2, 3).
        rotations: From the scene into the obstacle's own frame; a cylinder's axis is its z, shape (N, 3, 3).
        centres_m: Centres in the scene [m], shape (N, 3).
        half_m: Half the edges of a box; radius, radius and half the length of a cylinder [m], shape (N, 3).
        round_: 1 for a cylinder, 0 for a box, shape (N,).
        losses_db: Loss of each passage [dB], and for each metre [dB/m], shape (N, 2).
        delay_ratio: Extra electrical length for each metre inside, shape (N,).
    """

    bounds_m: FloatArray
    rotations: FloatArray
    centres_m: FloatArray
    half_m: FloatArray
    round_: IntArray
    losses_db: FloatArray
    delay_ratio: FloatArray


def obstacle_table(scene: Scene) -> ObstacleTable:
    """Gather a scene's obstacles, but for those that a wave does not notice."""
    obstacles = [obstacle for obstacle in scene.obstacles if _matters(scene.materials[obstacle.material])]
    N = len(obstacles)
    table = ObstacleTable(
        np.empty((N, 2, 3)), np.empty((N, 3, 3)), np.empty((N, 3)), np.empty((N, 3)),
        np.zeros(N, dtype=np.int64), np.empty((N, 2)), np.empty(N),
    )  # fmt: skip
    for n, obstacle in enumerate(obstacles):
        material, shape = scene.materials[obstacle.material], obstacle.shape
        lying = not isinstance(shape, Box) and shape.axis == "x"
        own_z_first = np.eye(3)[[1, 2, 0]] if lying else np.eye(3)  # own x becomes z
        table.bounds_m[n] = obstacle.bounds_m
        table.rotations[n] = own_z_first @ obstacle.T_scene_obstacle[:3, :3].T
        table.centres_m[n] = obstacle.T_scene_obstacle[:3, 3]
        table.half_m[n] = own_z_first @ shape.upper_m
        table.round_[n] = not isinstance(shape, Box)
        table.losses_db[n] = material.surface_loss_db, material.loss_db_per_m
        table.delay_ratio[n] = material.delay_ratio
    return table


def _matters(material: Material) -> bool:
    return material.delay_ratio > 0 or material.loss_db_per_m > 0 or material.surface_loss_db > 0


@numba.njit(cache=True, error_model="numpy")
def pass_obstacles(ray: FloatArray, length_m: float, obstacles: ObstacleTable, totals: FloatArray) -> None:
    """Add loss [dB] and extra length [m] of one leg to `totals`, shape (2,); `ray` is start and direction, (2, 3)."""
    for n in range(len(obstacles.bounds_m)):
        if _misses(ray, length_m, obstacles.bounds_m[n]):
            continue
        chord = _chord(ray, length_m, obstacles, n)
        if chord > 1e-9:
            totals[0] += obstacles.losses_db[n, 0] + obstacles.losses_db[n, 1] * chord
            totals[1] += obstacles.delay_ratio[n] * chord


@numba.njit(cache=True, error_model="numpy")
def _misses(ray: FloatArray, length_m: float, bounds_m: FloatArray) -> bool:
    """Whether the leg lies wholly beyond one side of the box around an obstacle."""
    for axis in range(3):
        a = ray[0, axis]
        b = a + length_m * ray[1, axis]
        if (a < bounds_m[0, axis] and b < bounds_m[0, axis]) or (a > bounds_m[1, axis] and b > bounds_m[1, axis]):
            return True
    return False


@numba.njit(cache=True, error_model="numpy")
def _chord(ray: FloatArray, length_m: float, obstacles: ObstacleTable, n: int) -> float:
    """Length of the leg inside obstacle n [m]: what the slabs of a box, or lid and mantle of a cylinder, leave."""
    near, far = 0.0, length_m
    o0, o1, d0, d1 = 0.0, 0.0, 0.0, 0.0
    for axis in range(3):
        o, d = 0.0, 0.0
        for i in range(3):
            turn = obstacles.rotations[n, axis, i]
            o += turn * (ray[0, i] - obstacles.centres_m[n, i])
            d += turn * ray[1, i]
        if axis == 0:
            o0, d0 = o, d
        elif axis == 1:
            o1, d1 = o, d
        if obstacles.round_[n] == 0 or axis == 2:
            near, far = _slab(o, d, obstacles.half_m[n, axis], near, far)
    if obstacles.round_[n] == 1:
        near, far = _mantle(o0 * o0 + o1 * o1, o0 * d0 + o1 * d1, d0 * d0 + d1 * d1, obstacles.half_m[n, 0], near, far)
    return max(far - near, 0.0)


@numba.njit(cache=True, error_model="numpy")
def _slab(o: float, d: float, half: float, near: float, far: float) -> tuple[float, float]:
    """Part of [near, far] in which |o + s d| <= half."""
    if abs(d) < 1e-12:
        return (near, far) if abs(o) <= half else (1.0, 0.0)
    one, other = (-half - o) / d, (half - o) / d
    return max(near, min(one, other)), min(far, max(one, other))


@numba.njit(cache=True, error_model="numpy")
def _mantle(oo: float, od: float, dd: float, radius: float, near: float, far: float) -> tuple[float, float]:
    """Part of [near, far] in which |o + s d|² = oo + 2 s od + s² dd <= radius², o and d across the axis."""
    c = oo - radius * radius
    if dd < 1e-24:
        return (near, far) if c <= 0.0 else (1.0, 0.0)
    root = od * od - dd * c
    if root <= 0.0:
        return 1.0, 0.0
    root = np.sqrt(root)
    return max(near, (-od - root) / dd), min(far, (-od + root) / dd)
