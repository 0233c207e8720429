"""Averaging the reads of a trace over cells (tag, antenna position, frequency); see `rfcompass.rf.cells`."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.recordings.placement import PlacedReads
from rfcompass.rf.cells import CellMeans, mean_over_cells


@dataclass(frozen=True, slots=True)
class Cells:
    """Averages over all cells (tag t, position m, frequency f) of some reads.

    Attributes:
        epcs: The tags (T).
        rx_rows: Pose row of the receiving antenna at each position, ascending, shape (M,).
        tx_rows: Pose row of the transmitting antenna at each position, shape (M,).
        frequencies_hz: Ascending [Hz], shape (F,).
        means: What was averaged.
    """

    epcs: tuple[str, ...]
    rx_rows: IntArray
    tx_rows: IntArray
    frequencies_hz: FloatArray
    means: CellMeans


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
    cell = (tag[used] * positions.size + position) * frequencies.size + frequency
    return Cells(
        epcs=epcs,
        rx_rows=reads.rx_rows[positions],
        tx_rows=reads.tx_rows[positions],
        frequencies_hz=columns.frequencies_hz[frequencies],
        means=mean_over_cells(
            cell, columns.amplitude[used], columns.lag_rad[used], (len(epcs), positions.size, frequencies.size)
        ),
    )


def _indices(names: tuple[str, ...], wanted: tuple[str, ...]) -> IntArray:
    """Index of each name in `wanted`, -1 where it is not among them."""
    place = {name: index for index, name in enumerate(wanted)}
    return np.array([place.get(name, -1) for name in names], dtype=np.int64)


def _compact(index: IntArray, size: int) -> tuple[IntArray, IntArray]:
    """The indices that occur, ascending, and the place of each read among them."""
    occurs = np.bincount(index, minlength=size) > 0
    return np.flatnonzero(occurs), (np.cumsum(occurs) - 1)[index]
