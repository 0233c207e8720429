"""Runs: the parts of an antenna path over which the unknown phase constant stays the same.

A reader adds a constant to the phase, another for each antenna port, channel and tag. Phases may be compared along
positions that share it: those of one receiving port and, if a bistatic rig has several transmitters that stand still,
of one transmitter.
"""

from functools import lru_cache

import numpy as np

from rfcompass.arrays import IntArray
from rfcompass.types.reads import ReadTrace

KEPT_PATHS = 128  # ours: legs of a few paths, which all tags of a scan share
LEAST_DIFFERENCES = 8  # ours: three unknowns of a place, and enough beside them to see that they fit


def runs(trace: ReadTrace) -> list[IntArray]:
    """Split the antenna positions into runs.

    Returns:
        Row indices of each run, in the order of the path; together they are all M positions.
    """
    found: list[IntArray] = []
    for port in np.unique(trace.antenna_ports):
        rows = np.flatnonzero(trace.antenna_ports == port)
        if trace.tx_positions_m is None:
            found.append(rows)
        else:
            own, sender = trace.antenna_positions_m[rows].tobytes(), trace.tx_positions_m[rows].tobytes()
            found += [rows[part] for part in _by_transmitter(own, sender)]
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


@lru_cache(maxsize=KEPT_PATHS)
def _by_transmitter(rx_positions: bytes, tx_positions: bytes) -> tuple[IntArray, ...]:
    """Transmitters that stand still serve many places of the receiver; one that moves along goes with one place only.

    A wrist that goes round twice, or ends where it began, meets each pair of places again; that is no fixed sender.
    Positions come as bytes, so that what all tags of a scan share is sorted once.
    """
    rx_m, tx_m = (np.frombuffer(positions).reshape(-1, 3) for positions in (rx_positions, tx_positions))
    places, index = np.unique(tx_m, axis=0, return_inverse=True)
    pairs = np.unique(np.hstack([rx_m, tx_m]), axis=0)
    if 2 * len(places) > len(pairs):
        return (np.arange(len(rx_m)),)
    return tuple(np.flatnonzero(index.ravel() == place) for place in range(len(places)))
