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

from rfcompass.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from rfcompass.recordings.placement import PlacedReads


@dataclass(frozen=True, slots=True)
class Cells:
    """Averages over all cells (tag t, position m, frequency f) of some reads.

    Attributes:
        epcs: The tags (T).
        rx_rows: Pose row of the receiving antenna at each position, ascending, shape (M,).
        tx_rows: Pose row of the transmitting antenna at each position, shape (M,).
        frequencies_hz: Ascending [Hz], shape (F,).
        counts: Number of reads n, shape (T, M, F).
        amplitude: mean(a_r), 0 where n = 0, shape (T, M, F).
        phasor: mean(u_r), 0 where n = 0, shape (T, M, F).
        doubled: mean(u_r²), 0 where n = 0, shape (T, M, F).
    """

    epcs: tuple[str, ...]
    rx_rows: IntArray
    tx_rows: IntArray
    frequencies_hz: FloatArray
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


def average_cells(reads: PlacedReads, epcs: tuple[str, ...], keep: BoolArray | None = None) -> Cells:
    """Average reads over cells. The order of the reads does not matter, not even to the last bit.

    Positions are the antenna poses at which at least one of these tags was heard.

    Args:
        reads: All reads of the trace (R).
        epcs: Tags to average (T); reads of other tags are left out.
        keep: Which reads to use, shape (R,); all if None.
    """
    columns = reads.columns
    tag = _indices(columns.epcs, epcs)[columns.epc_index]
    used = np.flatnonzero(tag >= 0 if keep is None else (tag >= 0) & keep)
    positions, position = _compact(reads.position[used], reads.rx_rows.size)
    frequencies, frequency = _compact(columns.freq_index[used], columns.frequencies_hz.size)
    shape = (len(epcs), positions.size, frequencies.size)
    cell = (tag[used] * positions.size + position) * frequencies.size + frequency
    counts = np.bincount(cell, minlength=math.prod(shape)).reshape(shape)
    amplitude, phasor, doubled = _means(cell, columns.amplitude[used], columns.lag_rad[used], counts)
    return Cells(
        epcs=epcs,
        rx_rows=reads.rx_rows[positions],
        tx_rows=reads.tx_rows[positions],
        frequencies_hz=columns.frequencies_hz[frequencies],
        counts=counts,
        amplitude=amplitude,
        phasor=phasor,
        doubled=doubled,
    )


def _indices(names: tuple[str, ...], wanted: tuple[str, ...]) -> IntArray:
    """Index of each name in `wanted`, -1 where it is not among them."""
    place = {name: index for index, name in enumerate(wanted)}
    return np.array([place.get(name, -1) for name in names], dtype=np.int64)


def _compact(index: IntArray, size: int) -> tuple[IntArray, IntArray]:
    """The indices that occur, ascending, and the place of each read among them."""
    occurs = np.bincount(index, minlength=size) > 0
    return np.flatnonzero(occurs), (np.cumsum(occurs) - 1)[index]


def _means(
    cell: IntArray, amplitude: FloatArray, lag_rad: FloatArray, counts: IntArray
) -> tuple[FloatArray, ComplexArray, ComplexArray]:
    """Means of a_r, u_r and u_r²; summed in ascending order of a_r and of the lag, so that row order is no matter."""
    rising, turning = np.argsort(amplitude), np.argsort(lag_rad)
    mean_amplitude = _mean(cell[rising], amplitude[rising], counts)
    cell, phasor = cell[turning], np.exp(-1j * lag_rad[turning])
    square = phasor**2
    mean_phasor = _mean(cell, phasor.real, counts) + 1j * _mean(cell, phasor.imag, counts)
    mean_square = _mean(cell, square.real, counts) + 1j * _mean(cell, square.imag, counts)
    return mean_amplitude, mean_phasor, mean_square


def _mean(cell: IntArray, values: FloatArray, counts: IntArray) -> FloatArray:
    sums = np.bincount(cell, weights=values, minlength=counts.size).reshape(counts.shape)
    return np.asarray(sums / np.maximum(counts, 1))
