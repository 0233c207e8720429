"""Compiled matched filter of looks over one channel: each term of the sum is a plain turn, and needs no table.

Look l of a run, with wave number k_l and whole turns per metre w_l = k_l / 2π, is

    A_l(p) = Σ_m c(l, m) exp(2πj w_l d(p, m)).

Whole turns are dropped first; what is left is within half a turn, where two polynomials give sine and cosine to a few
millionths. Nothing in the loop looks anything up, so that the compiler does eight points at once: about six times as
fast as the tables of `rfcompass.rf.sar_kernels`, which sums over several channels need.
"""

from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.rf.sar_kernels import BLOCK, Complex64Array, Float32Array, add_product, load_points

_TURNS = 0.5 * np.cos(np.pi * (np.arange(4000) + 0.5) / 4000)  # Chebyshev's places: the fits err evenly
_ODD = np.linalg.lstsq(_TURNS[:, None] ** np.arange(1, 14, 2), np.sin(2.0 * np.pi * _TURNS))[0].astype(np.float32)
_EVEN = np.linalg.lstsq(_TURNS[:, None] ** np.arange(0, 13, 2), np.cos(2.0 * np.pi * _TURNS))[0].astype(np.float32)
S1, S3, S5, S7, S9, S11, S13 = _ODD  # names, because compiled code takes an array's items from memory each time
C0, C2, C4, C6, C8, C10, C12 = _EVEN
HALF = np.float32(0.5)


class PhaseRun(NamedTuple):
    """One run of the antenna path, ready for the kernel.

    Attributes:
        origin_m: Point near antennas that single precision is taken about [m], shape (3,).
        rx_m: Receiving antenna less the origin [m], shape (M, 3).
        tx_m: Transmitting antenna less the origin [m], shape (M, 3); shape (0, 3) if the way from the receiving one
            tells all: a transmitter that stands still adds the same to every phase of a run.
        factors: c(l, m), 0 where nothing was heard, shape (L, M).
        turns_per_m: w_l for each metre of d, shape (L,); without `tx_m` d is the way from the receiving antenna.
    """

    origin_m: FloatArray
    rx_m: Float32Array
    tx_m: Float32Array
    factors: Complex64Array
    turns_per_m: Float32Array


@numba.njit(cache=True, fastmath=True)
def add_phase_power(points_m: FloatArray, run: PhaseRun, power: Float32Array) -> None:
    """Add Σ_l |A_l(p)|² of one run to `power`; points (P, 3) [m], power (P,)."""
    L, M = run.factors.shape
    xyz, d = np.empty((3, BLOCK), np.float32), np.empty(BLOCK, np.float32)
    sums = np.empty((L, 2, BLOCK), np.float32)
    for start in range(0, len(points_m), BLOCK):
        n = min(BLOCK, len(points_m) - start)
        load_points(points_m[start : start + n], run.origin_m, xyz)
        sums[:] = 0.0
        for m in range(M):
            d[:n] = 0.0
            _add_way(xyz, run.rx_m[m], d[:n])
            if len(run.tx_m):
                _add_way(xyz, run.tx_m[m], d[:n])
            for look in range(L):
                c = run.factors[look, m]
                if c != 0:
                    _add_turned(c, run.turns_per_m[look], d[:n], sums[look])
        for look in range(L):
            add_product(sums[look], sums[look], power[start : start + n])


@numba.njit(cache=True, fastmath=True)
def _add_way(xyz: Float32Array, antenna_m: Float32Array, d: Float32Array) -> None:
    x, y, z = xyz[0], xyz[1], xyz[2]
    for v in range(d.size):
        d[v] += np.sqrt((x[v] - antenna_m[0]) ** 2 + (y[v] - antenna_m[1]) ** 2 + (z[v] - antenna_m[2]) ** 2)


@numba.njit(cache=True, fastmath=True)
def _add_turned(c: np.complex64, turns_per_m: np.float32, d: Float32Array, total: Float32Array) -> None:
    """Add c exp(2πj w d) at each point of a block to the sums, shape (2, BLOCK)."""
    a, b = np.float32(c.real), np.float32(c.imag)
    for v in range(d.size):
        t = turns_per_m * d[v]
        t -= np.floor(t + HALF)
        z = t * t
        sine = t * (S1 + z * (S3 + z * (S5 + z * (S7 + z * (S9 + z * (S11 + z * S13))))))
        cosine = C0 + z * (C2 + z * (C4 + z * (C6 + z * (C8 + z * (C10 + z * C12)))))
        total[0, v] += a * cosine - b * sine
        total[1, v] += a * sine + b * cosine
