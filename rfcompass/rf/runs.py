"""Runs: the parts of an antenna path over which the unknown phase constant stays the same.

A reader adds a constant to the phase, another for each antenna port, channel and tag. Phases may be compared along
positions that share it: those of one receiving port and, if a bistatic rig has several transmitters that stand still,
of one transmitter.
"""

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.types.reads import ReadTrace

LEAST_DIFFERENCES = 8  # ours: three unknowns of a place, and enough beside them to see that they fit


def runs(trace: ReadTrace) -> list[IntArray]:
    """Split the antenna positions into runs.

    Returns:
        Row indices of each run, in the order of the path; together they are all M positions.
    """
    found: list[IntArray] = []
    for port in np.unique(trace.antenna_ports):
        rows = np.flatnonzero(trace.antenna_ports == port)
        found += [rows] if trace.tx_positions_m is None else _by_transmitter(trace, rows, trace.tx_positions_m[rows])
    return found


def phase_differences(trace: ReadTrace) -> int:
    """Number of phase differences that are free of the unknown constants.

    A channel that was heard at n positions of a run gives n - 1.
    """
    heard = [trace.mask[rows].sum(axis=0) for rows in runs(trace)]
    return int(sum(np.maximum(count - 1, 0).sum() for count in heard))


def legs(trace: ReadTrace) -> float:
    """Upper bound of how much the round trip grows per metre of antenna motion: 2 monostatic, 1 with a fixed sender."""
    if trace.tx_positions_m is None:
        return 2.0
    moving = any(np.ptp(trace.tx_positions_m[rows], axis=0).any() for rows in runs(trace))
    return 2.0 if moving else 1.0


def _by_transmitter(trace: ReadTrace, rows: IntArray, tx_positions_m: FloatArray) -> list[IntArray]:
    """Transmitters that stand still serve many places of the receiver; one that moves along goes with one place only.

    A wrist that goes round twice, or ends where it began, meets each pair of places again; that is no fixed sender.
    """
    places, index = np.unique(tx_positions_m, axis=0, return_inverse=True)
    pairs = np.unique(np.hstack([trace.antenna_positions_m[rows], tx_positions_m]), axis=0)
    if 2 * len(places) > len(pairs):
        return [rows]
    return [rows[index.ravel() == place] for place in range(len(places))]
