"""Compiled: the power of one leg's matched filter at a point, with gradient and Hessian.

The sums of `rfcompass.rf.image_slopes`, antenna position by antenna position, in double precision.
"""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import ComplexArray, FloatArray, IntArray


class LegArrays(NamedTuple):
    """One leg of an antenna path.

    Attributes:
        rx_m: Receiving antenna [m], shape (M, 3), run after run.
        tx_m: Transmitting antenna [m], shape (M, 3); shape (0, 3) if it is the receiving one.
        h: Channel as it is matched, shape (M, F).
        k: Phase per metre of round trip for each channel [rad/m], shape (F,).
        ends: Where each run ends, shape (R,).
        coherent: One look over all channels.
    """

    rx_m: FloatArray
    tx_m: FloatArray
    h: ComplexArray
    k: FloatArray
    ends: IntArray
    coherent: bool


class Sums(NamedTuple):
    """Looks of one run: A, shape (L,), ∇A, shape (L, 3), and ∇²A as xx, xy, xz, yy, yz, zz, shape (L, 6)."""

    value: ComplexArray
    first: ComplexArray
    second: ComplexArray


@numba.njit(cache=True)
def leg_power(point_m: FloatArray, leg: LegArrays) -> tuple[float, FloatArray, FloatArray]:
    """Power at a point [m], shape (3,), with gradient [1/m], shape (3,), and Hessian [1/m²], shape (3, 3)."""
    looks, start = 1 if leg.coherent else leg.k.size, 0
    sums = Sums(
        np.zeros(looks, np.complex128), np.zeros((looks, 3), np.complex128), np.zeros((looks, 6), np.complex128)
    )
    value, gradient, hessian = 0.0, np.zeros(3), np.zeros((3, 3))
    for end in leg.ends:
        sums.value[:], sums.first[:], sums.second[:] = 0.0, 0.0, 0.0
        for m in range(start, end):
            _add_position(point_m, leg, m, sums)
        start = end
        for look in range(looks):
            value += abs(sums.value[look]) ** 2
            _add_slopes(sums.value[look], sums.first[look], sums.second[look], gradient, hessian)
    return value, gradient, hessian


@numba.njit(cache=True)
def _add_position(point_m: FloatArray, leg: LegArrays, m: int, sums: Sums) -> None:
    """Add the terms w of one position: w, w jk ∇d and w (jk ∇²d - k² ∇d ∇dᵀ)."""
    g, H = np.zeros(3), np.zeros(6)
    d = _add_way(point_m, leg.rx_m[m], g, H) + _add_way(point_m, leg.tx_m[m] if len(leg.tx_m) else leg.rx_m[m], g, H)
    for f in range(leg.k.size):
        if leg.h[m, f] == 0:
            continue
        look, jk = 0 if leg.coherent else f, 1j * leg.k[f]
        w = leg.h[m, f] * np.exp(jk * d)
        sums.value[look] += w
        for i in range(3):
            sums.first[look, i] += w * jk * g[i]
            for j in range(i, 3):
                sums.second[look, _packed(i, j)] += w * (jk * H[_packed(i, j)] + jk * jk * g[i] * g[j])


@numba.njit(cache=True)
def _add_slopes(
    A: complex, first: ComplexArray, second: ComplexArray, gradient: FloatArray, hessian: FloatArray
) -> None:
    """Add ∇|A|² = 2 Re(A* ∇A) and ∇²|A|² = 2 Re(∇A* ∇Aᵀ + A* ∇²A)."""
    for i in range(3):
        gradient[i] += 2.0 * (A.conjugate() * first[i]).real
        for j in range(3):
            bend = A.conjugate() * second[_packed(i, j)]
            hessian[i, j] += 2.0 * (first[i].conjugate() * first[j] + bend).real


@numba.njit(cache=True, inline="always")
def _packed(i: int, j: int) -> int:
    """Where an entry of a symmetric matrix is among xx, xy, xz, yy, yz, zz."""
    low, high = min(i, j), max(i, j)
    return low * (5 - low) // 2 + high


@numba.njit(cache=True)
def _add_way(point_m: FloatArray, antenna_m: FloatArray, g: FloatArray, H: FloatArray) -> float:
    """Add gradient and Hessian of a distance; return the distance [m]."""
    x, y, z = point_m[0] - antenna_m[0], point_m[1] - antenna_m[1], point_m[2] - antenna_m[2]
    r = max(np.sqrt(x * x + y * y + z * z), 1e-9)
    u = (x / r, y / r, z / r)
    for i in range(3):
        g[i] += u[i]
        for j in range(i, 3):
            H[_packed(i, j)] += ((1.0 if i == j else 0.0) - u[i] * u[j]) / r
    return float(r)
