"""Compiled one-way field: images of the tag behind walls, and scatterers.

Each image is a path with known bounces. The ray is walked through the real room, from wall to wall, so that every leg
meets the obstacles that are really there and every bounce turns the field vector by Fresnel's coefficients:

    E' = r_TE E_s s + r_TM E_p p',   s across the plane of incidence, p and p' in it, across the ray.

A phasor for each carrier follows from the one before by a multiplication, as long as carriers are equally far apart.
"""

from typing import NamedTuple, TypeAlias

import numba
import numpy as np

from rfcompass.arrays import ComplexArray, FloatArray, IntArray
from rfcompass.simulation.occlusion import Vector, pass_obstacles

# Distances below this are taken as this, for the field's size only: the far field ends there (λ / 2π at 920 MHz). Ours.
NEAREST_M = 0.05

ComplexVector: TypeAlias = tuple[complex, complex, complex]

_DB_TO_NEPER = np.log(10.0) / 20.0


class AntennaRows(NamedTuple):
    """One antenna at M places.

    Attributes:
        positions_m: Phase centres [m], shape (M, 3).
        vectors: Polarisation p in the scene, shape (M, 3).
        boresights: Unit vectors in the scene, shape (M, 3).
        kind: 0 isotropic, 1 dipole, 2 patch.
        exponent: Exponent of a patch's pattern.
        back_field: Field behind a patch.
    """

    positions_m: FloatArray
    vectors: ComplexArray
    boresights: FloatArray
    kind: int
    exponent: float
    back_field: float


class Beam(NamedTuple):
    """One row of them: polarisation p, boresight, kind, exponent and field behind. Numbers only: no array to count."""

    vector: ComplexVector
    boresight: Vector
    kind: int
    exponent: float
    back_field: float


class RoomTable(NamedTuple):
    """The walls.

    Attributes:
        size_m: Edges [m], shape (3,).
        images: Bounces along each axis, signed by the side that the first one is at, shape (I, 3).
        permittivity: At the lower and upper plane of each axis; -1 for a conductor, shape (3, 2).
    """

    size_m: FloatArray
    images: IntArray
    permittivity: FloatArray


class Walls(NamedTuple):
    """The same as numbers: edges, and permittivity at the lower and upper plane of x, y and z."""

    size_m: Vector
    permittivity: tuple[float, float, float, float, float, float]


class ScattererTable(NamedTuple):
    """Small things.

    Attributes:
        points_m: Places [m], shape (S, 3).
        amplitudes: sqrt(σ / 4π) e^{jψ} [m], shape (S,).
        matrices: Turn of the field, shape (S, 3, 3).
    """

    points_m: FloatArray
    amplitudes: ComplexArray
    matrices: FloatArray


class TagRows(NamedTuple):
    """Tags: places [m], shape (T, 3), and the dipole of each port, shape (T, P, 3)."""

    points_m: FloatArray
    axes: FloatArray


class Surroundings(NamedTuple):
    """What every leg of a path meets: the walls and the obstacles."""

    room: RoomTable
    obstacles: FloatArray


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def add_images(
    antenna: AntennaRows, tags: TagRows, room: RoomTable, obstacles: FloatArray, k: FloatArray, field: ComplexArray
) -> None:
    """Add Σ_images e·u e^{-jkL} / r for every antenna row, tag, port and wavenumber to `field`, (M, T, P, F)."""
    walls, images, points_m, axes = _walls(room), room.images, tags.points_m, tags.axes
    for m in range(len(field)):
        start, beam = _row(antenna.positions_m, m), _beam(antenna, m)
        for t in range(len(points_m)):
            tag = _row(points_m, t)
            for i in range(len(images)):
                bounces = (images[i, 0], images[i, 1], images[i, 2])
                d, r = _aim(start, _image(tag, bounces, walls.size_m))
                e, loss_db, extra_m = _walk((start, d), r, _launch(beam, d), bounces, walls, obstacles)
                scale = _left(loss_db) / max(r, NEAREST_M)
                _add_ray((scale * e[0], scale * e[1], scale * e[2]), axes, r + extra_m, k, field, (m, t))


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def add_scatterers(
    antenna: AntennaRows,
    tags: TagRows,
    scatterers: ScattererTable,
    surroundings: Surroundings,
    k: FloatArray,
    field: ComplexArray,
) -> None:
    """Add Σ_s sqrt(σ/4π) e^{jψ} b·B a to `field`, (M, T, P, F).

    a is the field of the antenna at the scatterer, b that of the tag's dipole as an antenna: by reciprocity what the
    dipole takes of the scatterer. Both come directly and by one bounce; legs are walked once.
    """
    M, T, P, F = field.shape
    out, back = _legs_out(antenna, scatterers, surroundings, k), _legs_back(tags, scatterers, surroundings, k)
    for m in range(M):
        for t in range(T):
            for s in range(len(scatterers.points_m)):
                for p in range(P):
                    for f in range(F):
                        a, b = out[m, s, f], back[t, s, p, f]
                        field[m, t, p, f] += a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _legs_out(
    antenna: AntennaRows, scatterers: ScattererTable, surroundings: Surroundings, k: FloatArray
) -> ComplexArray:
    """Field that each scatterer sends on, sqrt(σ/4π) e^{jψ} B a, (M, S, F, 3)."""
    M, S = len(antenna.positions_m), len(scatterers.points_m)
    out, arriving = np.zeros((M, S, len(k), 3), np.complex128), np.empty((len(k), 3), np.complex128)
    for m in range(M):
        start, beam = _row(antenna.positions_m, m), _beam(antenna, m)
        for s in range(S):
            arriving[:] = 0.0
            ends, size_m = (start, _row(scatterers.points_m, s)), abs(scatterers.amplitudes[s])
            _add_leg(ends, size_m, beam, surroundings, k, arriving)
            for f in range(len(k)):
                for i in range(3):
                    for j in range(3):
                        out[m, s, f, i] += scatterers.amplitudes[s] * scatterers.matrices[s, i, j] * arriving[f, j]
    return out


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _legs_back(tags: TagRows, scatterers: ScattererTable, surroundings: Surroundings, k: FloatArray) -> ComplexArray:
    """Field that the dipole of each tag port would send to each scatterer, (T, S, P, F, 3)."""
    T, P, S = len(tags.points_m), tags.axes.shape[1], len(scatterers.points_m)
    back = np.zeros((T, S, P, len(k), 3), np.complex128)
    for t in range(T):
        for s in range(S):
            ends, size_m = (_row(tags.points_m, t), _row(scatterers.points_m, s)), abs(scatterers.amplitudes[s])
            for p in range(P):
                u = tags.axes[t, p]
                dipole = Beam((u[0] + 0j, u[1] + 0j, u[2] + 0j), (1.0, 0.0, 0.0), 1, 0.0, 0.0)
                _add_leg(ends, size_m, dipole, surroundings, k, back[t, s, p])
    return back


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _add_leg(
    ends: tuple[Vector, Vector],
    size_m: float,
    beam: Beam,
    surroundings: Surroundings,
    k: FloatArray,
    arriving: ComplexArray,
) -> None:
    """Add the field at a scatterer, e e^{-jkL} / r, directly and by one bounce, to `arriving`, (F, 3).

    Nothing near a scatterer gets more than what reached it: r is at least its size, sqrt(σ/4π).
    """
    start, point = ends
    room, obstacles = surroundings
    walls = _walls(room)
    for i in range(len(room.images)):
        bounces = (room.images[i, 0], room.images[i, 1], room.images[i, 2])
        if abs(bounces[0]) + abs(bounces[1]) + abs(bounces[2]) > 1:
            break
        d, r = _aim(start, _image(point, bounces, walls.size_m))
        e, loss_db, extra_m = _walk((start, d), r, _launch(beam, d), bounces, walls, obstacles)
        scale = _left(loss_db) / max(r, NEAREST_M, size_m)
        for f in range(len(k)):
            phasor = scale * _phasor(k[f] * (r + extra_m))
            for axis in range(3):
                arriving[f, axis] += e[axis] * phasor


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _row(array: FloatArray, i: int) -> Vector:
    return (array[i, 0], array[i, 1], array[i, 2])


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _image(tag: Vector, bounces: tuple[int, int, int], size: Vector) -> Vector:
    """Where the tag seems to be behind the walls [m]."""
    return (
        _mirrored(tag[0], bounces[0], size[0]),
        _mirrored(tag[1], bounces[1], size[1]),
        _mirrored(tag[2], bounces[2], size[2]),
    )


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _mirrored(x: float, n: int, size: float) -> float:
    return n * size + x if n % 2 == 0 else (n + 1) * size - x


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _aim(start: Vector, end: Vector) -> tuple[Vector, float]:
    """Unit direction and distance [m]."""
    x, y, z = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    r = np.sqrt(x * x + y * y + z * z)
    return (x / r, y / r, z / r), r


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _beam(antenna: AntennaRows, m: int) -> Beam:
    p, b = antenna.vectors, antenna.boresights
    vector, boresight = (p[m, 0], p[m, 1], p[m, 2]), (b[m, 0], b[m, 1], b[m, 2])
    return Beam(vector, boresight, antenna.kind, antenna.exponent, antenna.back_field)


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _walls(room: RoomTable) -> Walls:
    e = room.permittivity
    size_m = (room.size_m[0], room.size_m[1], room.size_m[2])
    return Walls(size_m, (e[0, 0], e[0, 1], e[1, 0], e[1, 1], e[2, 0], e[2, 1]))


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _launch(beam: Beam, d: Vector) -> ComplexVector:
    """Field that an antenna radiates along d, at unit distance and unit gain."""
    p = beam.vector
    along = p[0] * d[0] + p[1] * d[1] + p[2] * d[2]
    x, y, z = p[0] - along * d[0], p[1] - along * d[1], p[2] - along * d[2]
    scale = 1.0
    if beam.kind == 0:
        size = _square(x) + _square(y) + _square(z)
        scale = 1.0 / np.sqrt(size) if size > 1e-18 else 0.0
    elif beam.kind == 2:
        front = (0.5 * (1.0 + max(min(_dot(beam.boresight, d), 1.0), -1.0))) ** beam.exponent
        scale = beam.back_field + (1.0 - beam.back_field) * front
    return scale * x, scale * y, scale * z


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _square(z: complex) -> float:
    return z.real * z.real + z.imag * z.imag


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _walk(
    ray: tuple[Vector, Vector],
    length_m: float,
    e: ComplexVector,
    bounces: tuple[int, int, int],
    walls: Walls,
    obstacles: FloatArray,
) -> tuple[ComplexVector, float, float]:
    """Follow a ray, start and direction, from wall to wall; field at its end, loss [dB] and extra length [m]."""
    at, d = ray
    left = (abs(bounces[0]), abs(bounces[1]), abs(bounces[2]))
    rest, loss_db, extra_m = length_m, 0.0, 0.0
    for _ in range(left[0] + left[1] + left[2]):
        axis, step = _next_wall(at, d, left, walls.size_m)
        more_db, more_m = pass_obstacles(at, d, step, obstacles)
        loss_db, extra_m, rest = loss_db + more_db, extra_m + more_m, rest - step
        at = (at[0] + step * d[0], at[1] + step * d[1], at[2] + step * d[2])
        e, d = _bounce(e, d, axis, walls.permittivity[2 * axis + (d[axis] > 0.0)])
        left = (left[0] - (axis == 0), left[1] - (axis == 1), left[2] - (axis == 2))
    more_db, more_m = pass_obstacles(at, d, rest, obstacles)
    return e, loss_db + more_db, extra_m + more_m


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _next_wall(at: Vector, d: Vector, left: tuple[int, int, int], size_m: Vector) -> tuple[int, float]:
    """Axis of the next wall among those that still have bounces left, and the way to it [m]."""
    axis, step = -1, np.inf
    for i in range(3):
        if left[i] > 0:
            ahead = (size_m[i] - at[i]) / d[i] if d[i] > 0.0 else (-at[i] / d[i] if d[i] < 0.0 else 0.0)
            if axis < 0 or ahead < step:
                axis, step = i, ahead
    return axis, step


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _bounce(e: ComplexVector, d: Vector, axis: int, permittivity: float) -> tuple[ComplexVector, Vector]:
    """Reflect field and direction at a plane across `axis`.

    With the unit vector s across the plane of incidence, the rest of the field lies in that plane; its part along the
    wall changes by -r_TM, its part across the wall by r_TM.
    """
    if axis == 0:
        return _bounce_x(e, d, permittivity)
    if axis == 1:
        e, d = _bounce_x((e[1], e[2], e[0]), (d[1], d[2], d[0]), permittivity)
        return (e[2], e[0], e[1]), (d[2], d[0], d[1])
    e, d = _bounce_x((e[2], e[0], e[1]), (d[2], d[0], d[1]), permittivity)
    return (e[1], e[2], e[0]), (d[1], d[2], d[0])


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _bounce_x(e: ComplexVector, d: Vector, permittivity: float) -> tuple[ComplexVector, Vector]:
    cosine, sine_squared = abs(d[0]), d[1] * d[1] + d[2] * d[2]
    te, tm = -1.0, 1.0
    if permittivity > 0.0:
        root = np.sqrt(permittivity - sine_squared)
        te = (cosine - root) / (cosine + root)
        tm = (permittivity * cosine - root) / (permittivity * cosine + root)
    s_y, s_z = 1.0, 0.0
    if sine_squared > 1e-24:
        sine = np.sqrt(sine_squared)
        s_y, s_z = d[2] / sine, -d[1] / sine
    across = e[1] * s_y + e[2] * s_z
    y, z = across * s_y, across * s_z
    return (tm * e[0], te * y - tm * (e[1] - y), te * z - tm * (e[2] - z)), (-d[0], d[1], d[2])


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _add_ray(
    e: ComplexVector,
    axes: FloatArray,
    length_m: float,
    k: FloatArray,
    field: ComplexArray,
    place: tuple[int, int],
) -> None:
    """Add e·u e^{-jkL} for each port and wavenumber to `field` at row m, tag t."""
    m, t = place
    phasor, turn, step = _phasor(k[0] * length_m), 1.0 + 0.0j, 0.0
    for f in range(len(k)):
        if f > 0:
            if abs(k[f] - k[f - 1] - step) > 1e-12 * k[0]:
                step = k[f] - k[f - 1]
                turn = _phasor(step * length_m)
            phasor *= turn
        for p in range(axes.shape[1]):
            field[m, t, p, f] += (e[0] * axes[t, p, 0] + e[1] * axes[t, p, 1] + e[2] * axes[t, p, 2]) * phasor


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _phasor(angle: float) -> complex:
    """e^{-j angle}, from a sine and a cosine: twice as fast as a complex exponential."""
    return complex(np.cos(angle), -np.sin(angle))


@numba.njit(cache=True, error_model="numpy", fastmath=True)
def _left(loss_db: float) -> float:
    """Share of the amplitude that a loss leaves."""
    return np.exp(-_DB_TO_NEPER * loss_db) if loss_db > 0.0 else 1.0
