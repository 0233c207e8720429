"""Compiled one-way field: images of the tag behind walls, and scatterers.

Each image is a path with known bounces. The ray is walked through the real room, from wall to wall, so that every leg
meets the obstacles that are really there and every bounce turns the field vector by Fresnel's coefficients:

    E' = r_TE E_s s + r_TM E_p p',   s across the plane of incidence, p and p' in it, across the ray.

A phasor for each carrier follows from the one before by a multiplication, as long as carriers are equally far apart.
"""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import ComplexArray, FloatArray, IntArray
from rfcompass.simulation.occlusion import ObstacleTable, pass_obstacles

# Distances below this are taken as this, for the field's size only: the far field ends there (λ / 2π at 920 MHz). Ours.
NEAREST_M = 0.05

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


@numba.njit(cache=True, error_model="numpy")
def add_images(
    antenna: AntennaRows, tags: TagRows, room: RoomTable, obstacles: ObstacleTable, k: FloatArray, field: ComplexArray
) -> None:
    """Add Σ_images e·u e^{-jkL} / r for every antenna row, tag, port and wavenumber to `field`, (M, T, P, F)."""
    ray, e, totals = np.empty((2, 3)), np.empty(3, np.complex128), np.empty(2)
    for m in range(len(antenna.positions_m)):
        for t in range(len(tags.points_m)):
            for i in range(len(room.images)):
                r = _aim(antenna.positions_m[m], tags.points_m[t], room.images[i], room.size_m, ray)
                _launch(antenna, m, ray[1], e)
                totals[:] = 0.0
                _walk(ray, r, room.images[i], room, obstacles, e, totals)
                scale = _left(totals[0]) / max(r, NEAREST_M)
                _add_ray(e, tags.axes[t], scale, r + totals[1], k, field[m, t])


@numba.njit(cache=True, error_model="numpy")
def add_scatterers(
    antenna: AntennaRows,
    tags: TagRows,
    scatterers: ScattererTable,
    obstacles: ObstacleTable,
    k: FloatArray,
    field: ComplexArray,
) -> None:
    """Add Σ_s sqrt(σ/4π) e^{jψ} uᵀ B e e^{-jk(L1+L2)} / (d1 d2) to `field`, (M, T, P, F); legs are walked once."""
    M, T, P, F = field.shape
    out, out_phasor = _legs_out(antenna, scatterers, obstacles, k)
    back, back_phasor = _legs_back(tags, scatterers, obstacles, k)
    for m in range(M):
        for t in range(T):
            for s in range(len(scatterers.points_m)):
                for p in range(P):
                    c = 0.0j
                    for axis in range(3):
                        c += out[m, s, axis] * back[t, s, p, axis]
                    for f in range(F):
                        field[m, t, p, f] += c * out_phasor[m, s, f] * back_phasor[t, s, f]


@numba.njit(cache=True, error_model="numpy")
def _legs_out(
    antenna: AntennaRows, scatterers: ScattererTable, obstacles: ObstacleTable, k: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Field that each scatterer sends on, (M, S, 3), and the phasors of the legs to it, (M, S, F)."""
    M, S = len(antenna.positions_m), len(scatterers.points_m)
    out, phasors = np.empty((M, S, 3), np.complex128), np.empty((M, S, len(k)), np.complex128)
    ray, e, totals = np.empty((2, 3)), np.empty(3, np.complex128), np.empty(2)
    for m in range(M):
        for s in range(S):
            r = _straight(antenna.positions_m[m], scatterers.points_m[s], ray)
            _launch(antenna, m, ray[1], e)
            totals[:] = 0.0
            pass_obstacles(ray, r, obstacles, totals)
            scale = scatterers.amplitudes[s] * _left(totals[0]) / _size(r, scatterers, s)
            for axis in range(3):
                out[m, s, axis] = scale * e[axis]
            _fill_phasors(r + totals[1], k, phasors[m, s])
    return out, phasors


@numba.njit(cache=True, error_model="numpy")
def _legs_back(
    tags: TagRows, scatterers: ScattererTable, obstacles: ObstacleTable, k: FloatArray
) -> tuple[FloatArray, ComplexArray]:
    """What each tag port takes of a scatterer's field, B u⊥ / d2, (T, S, P, 3), and the phasors, (T, S, F)."""
    T, P, S = len(tags.points_m), tags.axes.shape[1], len(scatterers.points_m)
    back, phasors = np.empty((T, S, P, 3)), np.empty((T, S, len(k)), np.complex128)
    ray, totals, across = np.empty((2, 3)), np.empty(2), np.empty(3)
    for t in range(T):
        for s in range(S):
            r = _straight(tags.points_m[t], scatterers.points_m[s], ray)
            totals[:] = 0.0
            pass_obstacles(ray, r, obstacles, totals)
            scale = _left(totals[0]) / _size(r, scatterers, s)
            for p in range(P):
                along = 0.0
                for axis in range(3):
                    along += tags.axes[t, p, axis] * ray[1, axis]
                for axis in range(3):
                    across[axis] = tags.axes[t, p, axis] - along * ray[1, axis]
                for axis in range(3):
                    turned = 0.0
                    for j in range(3):
                        turned += scatterers.matrices[s, axis, j] * across[j]
                    back[t, s, p, axis] = scale * turned
            _fill_phasors(r + totals[1], k, phasors[t, s])
    return back, phasors


@numba.njit(cache=True, error_model="numpy")
def _size(r: float, scatterers: ScattererTable, s: int) -> float:
    """Distance that a scatterer's field falls with [m]: nothing that is near it gets more than what reached it."""
    return max(r, NEAREST_M, abs(scatterers.amplitudes[s]))


@numba.njit(cache=True, error_model="numpy")
def _straight(start_m: FloatArray, end_m: FloatArray, ray: FloatArray) -> float:
    """Set `ray` to start and unit direction; return the distance [m]."""
    r = 0.0
    for axis in range(3):
        ray[0, axis] = start_m[axis]
        ray[1, axis] = end_m[axis] - start_m[axis]
        r += ray[1, axis] * ray[1, axis]
    r = np.sqrt(r)
    for axis in range(3):
        ray[1, axis] /= r
    return r


@numba.njit(cache=True, error_model="numpy")
def _aim(start_m: FloatArray, goal_m: FloatArray, image: IntArray, size_m: FloatArray, ray: FloatArray) -> float:
    """Set `ray` towards an image of the goal; return the length of the unfolded path [m]."""
    r = 0.0
    for axis in range(3):
        n = image[axis]
        place = n * size_m[axis] + goal_m[axis] if n % 2 == 0 else (n + 1) * size_m[axis] - goal_m[axis]
        ray[0, axis] = start_m[axis]
        ray[1, axis] = place - start_m[axis]
        r += ray[1, axis] * ray[1, axis]
    r = np.sqrt(r)
    for axis in range(3):
        ray[1, axis] /= r
    return r


@numba.njit(cache=True, error_model="numpy")
def _launch(antenna: AntennaRows, m: int, d: FloatArray, e: ComplexArray) -> None:
    """Set `e` to the field that antenna row m radiates along d, at unit distance and unit gain."""
    along, cosine = 0.0j, 0.0
    for axis in range(3):
        along += antenna.vectors[m, axis] * d[axis]
        cosine += antenna.boresights[m, axis] * d[axis]
    size = 0.0
    for axis in range(3):
        e[axis] = antenna.vectors[m, axis] - along * d[axis]
        size += e[axis].real ** 2 + e[axis].imag ** 2
    if antenna.kind == 0:
        scale = 1.0 / np.sqrt(size) if size > 1e-18 else 0.0
    elif antenna.kind == 2:
        scale = antenna.back_field + (1.0 - antenna.back_field) * (0.5 * (1.0 + min(cosine, 1.0))) ** antenna.exponent
    else:
        return
    for axis in range(3):
        e[axis] *= scale


@numba.njit(cache=True, error_model="numpy")
def _walk(
    ray: FloatArray,
    length_m: float,
    image: IntArray,
    room: RoomTable,
    obstacles: ObstacleTable,
    e: ComplexArray,
    totals: FloatArray,
) -> None:
    """Follow the ray from wall to wall; `ray` and `e` end as they reach the goal, `totals` gathers what is passed."""
    left_x, left_y, left_z = abs(image[0]), abs(image[1]), abs(image[2])
    rest = length_m
    for _ in range(left_x + left_y + left_z):
        axis, step = -1, rest
        for i in range(3):
            left = left_x if i == 0 else (left_y if i == 1 else left_z)
            if left > 0:
                ahead = _to_wall(ray, i, room.size_m[i])
                if axis < 0 or ahead < step:
                    axis, step = i, ahead
        side = 1 if ray[1, axis] > 0.0 else 0
        pass_obstacles(ray, step, obstacles, totals)
        for i in range(3):
            ray[0, i] += step * ray[1, i]
        _bounce(e, ray[1], axis, room.permittivity[axis, side])
        left_x, left_y, left_z = left_x - (axis == 0), left_y - (axis == 1), left_z - (axis == 2)
        rest -= step
    pass_obstacles(ray, rest, obstacles, totals)


@numba.njit(cache=True, error_model="numpy")
def _to_wall(ray: FloatArray, axis: int, size_m: float) -> float:
    """Way to the next plane across an axis [m]."""
    d = ray[1, axis]
    if d > 0.0:
        return (size_m - ray[0, axis]) / d
    return -ray[0, axis] / d if d < 0.0 else 0.0


@numba.njit(cache=True, error_model="numpy")
def _bounce(e: ComplexArray, d: FloatArray, axis: int, permittivity: float) -> None:
    """Reflect field and direction at a plane across `axis`.

    With the unit vector s across the plane of incidence, the rest of the field lies in that plane; its part along the
    wall changes sign with -r_TM, its part across the wall with r_TM.
    """
    a, b = (axis + 1) % 3, (axis + 2) % 3
    cosine = abs(d[axis])
    sine_squared = d[a] * d[a] + d[b] * d[b]
    te, tm = -1.0, 1.0
    if permittivity > 0.0:
        root = np.sqrt(permittivity - sine_squared)
        te = (cosine - root) / (cosine + root)
        tm = (permittivity * cosine - root) / (permittivity * cosine + root)
    s_a, s_b = 1.0, 0.0
    if sine_squared > 1e-24:
        sine = np.sqrt(sine_squared)
        s_a, s_b = d[b] / sine, -d[a] / sine
    across = e[a] * s_a + e[b] * s_b
    e[a] = te * across * s_a - tm * (e[a] - across * s_a)
    e[b] = te * across * s_b - tm * (e[b] - across * s_b)
    e[axis] *= tm
    d[axis] = -d[axis]


@numba.njit(cache=True, error_model="numpy")
def _add_ray(
    e: ComplexArray, axes: FloatArray, scale: float, length_m: float, k: FloatArray, field: ComplexArray
) -> None:
    """Add e·u scale e^{-jkL} for each port and wavenumber, (P, F)."""
    phasor, turn, step = _phasor(k[0] * length_m), 1.0 + 0.0j, 0.0
    for f in range(len(k)):
        if f > 0:
            if abs(k[f] - k[f - 1] - step) > 1e-12 * k[0]:
                step = k[f] - k[f - 1]
                turn = _phasor(step * length_m)
            phasor *= turn
        for p in range(len(axes)):
            c = e[0] * axes[p, 0] + e[1] * axes[p, 1] + e[2] * axes[p, 2]
            field[p, f] += scale * c * phasor


@numba.njit(cache=True, error_model="numpy")
def _phasor(angle: float) -> complex:
    """e^{-j angle}, from a sine and a cosine: twice as fast as a complex exponential."""
    return complex(np.cos(angle), -np.sin(angle))


@numba.njit(cache=True, error_model="numpy")
def _left(loss_db: float) -> float:
    """Share of the amplitude that a loss leaves."""
    return np.exp(-_DB_TO_NEPER * loss_db) if loss_db > 0.0 else 1.0


@numba.njit(cache=True, error_model="numpy")
def _fill_phasors(length_m: float, k: FloatArray, phasors: ComplexArray) -> None:
    for f in range(len(k)):
        phasors[f] = _phasor(k[f] * length_m)
