"""Compiled: what obstacles take from a straight leg of a path, and how much longer they make it.

A box or a cylinder that a leg passes over a chord of length t takes `surface + per_metre · t` [dB] and adds
(√ε - 1) t to the electrical length. Where the leg begins or ends inside, t is the part inside.
"""

from typing import TypeAlias

import numba
import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.types.scene import Material, Scene
from rfcompass.types.shapes import Box

# Vectors are tuples in the kernels: they live in registers.
Vector: TypeAlias = tuple[float, float, float]

# Columns of the obstacle table. One array for everything: handing records of arrays around costs more than the sums.
_LOW, _HIGH, _CENTRE, _HALF, _TURN = 0, 3, 6, 9, 12
_SURFACE_DB, _DB_PER_M, _DELAY, _CURVED, _COLUMNS = 21, 22, 23, 24, 25


def obstacle_table(scene: Scene) -> FloatArray:
    """Gather a scene's obstacles, but for those that a wave does not notice, one in each row.

    Columns: lowest and highest corner along the axes of the scene [m] (3 + 3), centre [m] (3), half the edges of a box,
    or radius, radius and half the length of a cylinder [m] (3), turn from the scene into its own frame, in which a
    cylinder's axis is z (9), loss of each passage [dB], loss for each metre [dB/m], extra electrical length for each
    metre, 1 for a cylinder.
    """
    obstacles = [obstacle for obstacle in scene.obstacles if _matters(scene.materials[obstacle.material])]
    table = np.zeros((len(obstacles), _COLUMNS))
    for row, obstacle in zip(table, obstacles, strict=True):
        material, shape = scene.materials[obstacle.material], obstacle.shape
        lying = not isinstance(shape, Box) and shape.axis == "x"
        own_z_first = np.eye(3)[[1, 2, 0]] if lying else np.eye(3)  # own x becomes z
        row[_LOW:_CENTRE] = obstacle.bounds_m.ravel()
        row[_CENTRE:_HALF] = obstacle.T_scene_obstacle[:3, 3]
        row[_HALF:_TURN] = own_z_first @ shape.upper_m
        row[_TURN:_SURFACE_DB] = (own_z_first @ obstacle.T_scene_obstacle[:3, :3].T).ravel()
        row[_SURFACE_DB:] = (
            material.surface_loss_db, material.loss_db_per_m, material.delay_ratio, not isinstance(shape, Box)
        )  # fmt: skip
    return table


def _matters(material: Material) -> bool:
    return material.delay_ratio > 0 or material.loss_db_per_m > 0 or material.surface_loss_db > 0


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def pass_obstacles(start: Vector, d: Vector, length_m: float, table: FloatArray) -> tuple[float, float]:
    """Loss [dB] and extra electrical length [m] of one leg, from `start` along the unit vector `d`."""
    loss_db, extra_m = 0.0, 0.0
    end = (start[0] + length_m * d[0], start[1] + length_m * d[1], start[2] + length_m * d[2])
    for n in range(len(table)):
        if not _misses(start, end, table, n):
            chord = _chord(start, d, length_m, table, n)
            if chord > 1e-9:
                loss_db += table[n, _SURFACE_DB] + table[n, _DB_PER_M] * chord
                extra_m += table[n, _DELAY] * chord
    return loss_db, extra_m


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _misses(start: Vector, end: Vector, table: FloatArray, n: int) -> bool:
    """Whether the leg lies wholly beyond one side of the box around an obstacle."""
    for axis in range(3):
        a, b = start[axis], end[axis]
        if min(a, b) > table[n, _HIGH + axis] or max(a, b) < table[n, _LOW + axis]:
            return True
    return False


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _chord(start: Vector, d: Vector, length_m: float, table: FloatArray, n: int) -> float:
    """Length of the leg inside obstacle n [m]: what the slabs of a box, or lid and mantle of a cylinder, leave."""
    apart = (start[0] - table[n, _CENTRE], start[1] - table[n, _CENTRE + 1], start[2] - table[n, _CENTRE + 2])
    ox, oy, oz = _turned(apart, table, n, 0), _turned(apart, table, n, 1), _turned(apart, table, n, 2)
    dx, dy, dz = _turned(d, table, n, 0), _turned(d, table, n, 1), _turned(d, table, n, 2)
    near, far = _slab(oz, dz, table[n, _HALF + 2], 0.0, length_m)
    if table[n, _CURVED] > 0.0:
        c = ox * ox + oy * oy - table[n, _HALF] ** 2
        near, far = _mantle(c, ox * dx + oy * dy, dx * dx + dy * dy, near, far)
    else:
        near, far = _slab(oy, dy, table[n, _HALF + 1], near, far)
        near, far = _slab(ox, dx, table[n, _HALF], near, far)
    return max(far - near, 0.0)


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _turned(v: Vector, table: FloatArray, n: int, axis: int) -> float:
    """One component of a vector in the frame of obstacle n."""
    first = _TURN + 3 * axis
    return table[n, first] * v[0] + table[n, first + 1] * v[1] + table[n, first + 2] * v[2]


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _slab(o: float, d: float, half: float, near: float, far: float) -> tuple[float, float]:
    """Part of [near, far] in which |o + s d| <= half."""
    if abs(d) < 1e-12:
        return (near, far) if abs(o) <= half else (1.0, 0.0)
    one, other = (-half - o) / d, (half - o) / d
    return max(near, min(one, other)), min(far, max(one, other))


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _mantle(c: float, b: float, a: float, near: float, far: float) -> tuple[float, float]:
    """Part of [near, far] in which a s² + 2 b s + c <= 0: within the radius of a cylinder."""
    if a < 1e-24:
        return (near, far) if c <= 0.0 else (1.0, 0.0)
    root = b * b - a * c
    if root <= 0.0:
        return 1.0, 0.0
    root = np.sqrt(root)
    return max(near, (-b - root) / a), min(far, (-b + root) / a)
