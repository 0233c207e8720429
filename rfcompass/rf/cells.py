"""Averaging over cells: one cell is one tag at one antenna position and one frequency.

Readers measure power and phase apart, and both err apart: power is quantised to 0.5 dB, phase scatters. So each is
averaged on its own. With amplitude a_r and unit phasor u_r = h_r / a_r of each of the n reads of a cell,

    h = mean(a_r) · mean(u_r).

One loud outlier cannot turn the phase, and |mean(u_r)| <= 1 makes a cell whose reads disagree count less.
Readers whose phase is ambiguous by half a turn give u_r or -u_r at random, which cancel. There the square is averaged,
for which both are the same, and halved afterwards: with s = mean(u_r²), h = mean(a_r) · |s| · exp(j arg(s) / 2). No
branch is chosen before averaging, and the sign that is left over means nothing.
"""

import math
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import ComplexArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class CellMeans:
    """Averages over all cells of some reads, each of shape (T, M, F) for tags, positions and frequencies.

    Attributes:
        counts: Number of reads n.
        amplitude: mean(a_r), 0 where n = 0.
        phasor: mean(u_r), 0 where n = 0.
        doubled: mean(u_r²), 0 where n = 0.
    """

    counts: IntArray
    amplitude: FloatArray
    phasor: ComplexArray
    doubled: ComplexArray

    def channel(self, *, half_turns: bool) -> ComplexArray:
        """Mean channel h of each cell, shape (T, M, F).

        Args:
            half_turns: True if the phase is known modulo π only.
        """
        if not half_turns:
            return np.asarray(self.amplitude * self.phasor)
        return np.asarray(self.amplitude * np.abs(self.doubled) * np.exp(0.5j * np.angle(self.doubled)))


def mean_over_cells(
    cell: IntArray, amplitude: FloatArray, lag_rad: FloatArray, shape: tuple[int, int, int]
) -> CellMeans:
    """Average reads over cells. The order of the reads does not matter, not even to the last bit.

    Sums run in ascending order of a_r and of the lag.

    Args:
        cell: Flat index of each read's cell in an array of `shape`, shape (R,).
        amplitude: a_r, linear, shape (R,).
        lag_rad: -arg u_r [rad], shape (R,).
        shape: Numbers of tags, positions and frequencies (T, M, F).
    """
    counts = np.bincount(cell, minlength=math.prod(shape)).reshape(shape)
    rising, turning = np.argsort(amplitude), np.argsort(lag_rad)
    mean_amplitude = _mean(cell[rising], amplitude[rising], counts)
    cell, phasor = cell[turning], np.exp(-1j * lag_rad[turning])
    square = phasor**2
    mean_phasor = _mean(cell, phasor.real, counts) + 1j * _mean(cell, phasor.imag, counts)
    mean_square = _mean(cell, square.real, counts) + 1j * _mean(cell, square.imag, counts)
    return CellMeans(counts, mean_amplitude, mean_phasor, mean_square)


def _mean(cell: IntArray, values: FloatArray, counts: IntArray) -> FloatArray:
    sums = np.bincount(cell, weights=values, minlength=counts.size).reshape(counts.shape)
    return np.asarray(sums / np.maximum(counts, 1))
