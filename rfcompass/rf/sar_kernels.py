"""Compiled matched filter: sums of phasors that are looked up by the length of the round trip.

A run of the antenna path has M positions and L looks: sums that are squared on their own. Look l at point p is

    A_l(p) = Σ_m c(l, m) g(d(p, m)),

with g a phasor tabulated over the round trip d, one row of the table for each channel, or for each position if the
channels are already summed. Linear interpolation in the table takes all trigonometry out of the loop, and all channels
if they are summed. Points are taken in blocks that fit the fastest cache, in single precision about an origin nearby;
unsigned indices let the compiler vectorise the look-up.
"""

from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from rfcompass.arrays import FloatArray, IntArray

Float32Array = npt.NDArray[np.float32]
Complex64Array = npt.NDArray[np.complex64]
IndexArray = npt.NDArray[np.uint32]

BLOCK = 256


class PhasorTable(NamedTuple):
    """One run of the antenna path, ready for the kernels.

    Attributes:
        origin_m: Point near antennas and search volume that single precision is taken about [m], shape (3,).
        rx_m: Receiving antenna less the origin [m], shape (M, 3).
        tx_m: Transmitting antenna less the origin [m], shape (M, 3); shape (0, 3) if it is the receiving one.
        factors: c(l, m), 0 where nothing was heard, shape (L, M).
        rows: Row of the table that each (l, m) uses, shape (L, M).
        phasors: Real and imaginary part of g, shape (2, S, D).
        span: Round trip of the first column [m], and columns per metre, shape (2,).
    """

    origin_m: FloatArray
    rx_m: Float32Array
    tx_m: Float32Array
    factors: Complex64Array
    rows: IntArray
    phasors: Float32Array
    span: Float32Array


@numba.njit(cache=True, fastmath=True)
def add_power(points_m: FloatArray, table: PhasorTable, power: Float32Array) -> None:
    """Add Σ_l |A_l(p)|² of one run to `power`; points (P, 3) [m], power (P,)."""
    L, M = table.factors.shape
    xyz, sums = np.empty((3, BLOCK), np.float32), np.empty((L, 2, BLOCK), np.float32)
    index, rest = np.empty(BLOCK, np.uint32), np.empty(BLOCK, np.float32)
    for start in range(0, len(points_m), BLOCK):
        n = min(BLOCK, len(points_m) - start)
        load_points(points_m[start : start + n], table.origin_m, xyz)
        sums[:] = 0.0
        for m in range(M):
            _columns(xyz, table, m, index[:n], rest[:n])
            for look in range(L):
                c, row = table.factors[look, m], table.rows[look, m]
                if c != 0:
                    real, imag = table.phasors[0, row], table.phasors[1, row]
                    _add_phasors(c, real, imag, index[:n], rest[:n], sums[look])
        for look in range(L):
            add_product(sums[look], sums[look], power[start : start + n])


@numba.njit(cache=True, fastmath=True)
def add_differential_power(points_m: FloatArray, table: PhasorTable, power: Float32Array) -> None:
    """Add Σ_l Re Σ_m w(l, m') w*(l, m) to `power`: products of the terms w of A_l at neighbouring heard m, m'."""
    L, M = table.factors.shape
    xyz, last = np.empty((3, BLOCK), np.float32), np.empty((L, 2, BLOCK), np.float32)
    term, index, rest = np.empty((2, BLOCK), np.float32), np.empty(BLOCK, np.uint32), np.empty(BLOCK, np.float32)
    for start in range(0, len(points_m), BLOCK):
        n = min(BLOCK, len(points_m) - start)
        load_points(points_m[start : start + n], table.origin_m, xyz)
        last[:] = 0.0
        for m in range(M):
            _columns(xyz, table, m, index[:n], rest[:n])
            for look in range(L):
                c, row = table.factors[look, m], table.rows[look, m]
                if c != 0:
                    term[:] = 0.0
                    _add_phasors(c, table.phasors[0, row], table.phasors[1, row], index[:n], rest[:n], term)
                    add_product(term, last[look], power[start : start + n])
                    last[look] = term


@numba.njit(cache=True)
def load_points(points_m: FloatArray, origin_m: FloatArray, xyz: Float32Array) -> None:
    """Put a block of points (P, 3) [m] into the columns of `xyz`, about an origin."""
    for v in range(len(points_m)):
        for axis in range(3):
            xyz[axis, v] = points_m[v, axis] - origin_m[axis]


@numba.njit(cache=True, fastmath=True)
def _columns(xyz: Float32Array, table: PhasorTable, m: int, index: IndexArray, rest: Float32Array) -> None:
    """Round trip of each point, as a column of the table and the fraction of a step beyond it."""
    x, y, z = xyz[0], xyz[1], xyz[2]
    rx, first, scale = table.rx_m[m], table.span[0], table.span[1]
    monostatic = len(table.tx_m) == 0
    tx = rx if monostatic else table.tx_m[m]
    for v in range(index.size):
        d = np.sqrt((x[v] - rx[0]) ** 2 + (y[v] - rx[1]) ** 2 + (z[v] - rx[2]) ** 2)
        d += d if monostatic else np.sqrt((x[v] - tx[0]) ** 2 + (y[v] - tx[1]) ** 2 + (z[v] - tx[2]) ** 2)
        place = (d - first) * scale
        column = np.int32(place)
        index[v] = np.uint32(column)
        rest[v] = place - np.float32(column)


@numba.njit(cache=True, fastmath=True)
def _add_phasors(
    c: np.complex64,
    real: Float32Array,
    imag: Float32Array,
    index: IndexArray,
    rest: Float32Array,
    total: Float32Array,
) -> None:
    """Add c g(d) at each point of a block to the sums, shape (2, BLOCK)."""
    a, b = np.float32(c.real), np.float32(c.imag)
    for v in range(index.size):
        i, t = index[v], rest[v]
        j = i + np.uint32(1)
        re = real[i] + t * (real[j] - real[i])
        im = imag[i] + t * (imag[j] - imag[i])
        total[0, v] += a * re - b * im
        total[1, v] += a * im + b * re


@numba.njit(cache=True, fastmath=True)
def add_product(one: Float32Array, other: Float32Array, power: Float32Array) -> None:
    """Add Re(one · other*) at each point; both as (real, imaginary), shape (2, BLOCK)."""
    for v in range(power.size):
        power[v] += one[0, v] * other[0, v] + one[1, v] * other[1, v]
