"""What a reader reported at one stop, as the scan that its trace would give, to the last bit."""

from collections.abc import Collection

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.rf.cells import mean_over_cells
from rfcompass.simulation.inventory import Inventory
from rfcompass.simulation.reader_rig import FixedTransmitters, WristTransmitter
from rfcompass.types.reads import ReadTrace, Scan


def inventory_scan(inventory: Inventory, epcs: Collection[str], frame: str = "room") -> Scan:
    """Average the reads of one stop over cells: antenna position (with its transmitter) and carrier.

    Args:
        inventory: What the reader reported.
        epcs: Tags that matter; all others are strays.
        frame: Name of the frame in which the carrier knows its track.
    """
    wanted = [t for t, epc in enumerate(inventory.epcs) if epc in epcs]
    used = np.flatnonzero(np.isin(inventory.tags, wanted))
    if not used.size:
        return Scan(frame=frame)
    X = len(inventory.rig.tx_ports)
    pairs, position = np.unique(inventory.poses[used] * X + inventory.transmitters[used], return_inverse=True)
    channels, channel = np.unique(inventory.channels[used], return_inverse=True)
    shape = (len(inventory.epcs), pairs.size, channels.size)
    cell = (inventory.tags[used] * pairs.size + position) * channels.size + channel
    amplitude, lag_rad = _reported(inventory, used)
    means = mean_over_cells(cell, amplitude, lag_rad, shape)
    h = means.channel(half_turns=inventory.half_turns)
    poses, transmitters = np.divmod(pairs, X)
    traces = {
        inventory.epcs[t]: ReadTrace(
            epc=inventory.epcs[t],
            antenna_positions_m=inventory.antenna_positions_m[poses],
            frequencies_hz=inventory.rig.frequencies_hz[channels],
            channel=h[t],
            read_counts=means.counts[t],
            antenna_ports=inventory.nominal_track.ports[poses],
            tx_positions_m=_sent_from_m(inventory, poses, transmitters),
            phase_modulus_rad=np.pi if inventory.half_turns else 2.0 * np.pi,
        )
        for t in wanted
        if means.counts[t].any()
    }
    return Scan(traces=traces, frame=frame)


def _reported(inventory: Inventory, used: IntArray) -> tuple[FloatArray, FloatArray]:
    """Amplitude and phase lag of each read, from what the reader reports of it, shape (R,) each."""
    noise, heard = inventory.rig.noise, inventory.heard[used]
    if noise.reports_iq:
        return np.hypot(heard.real, heard.imag), -np.arctan2(heard.imag, heard.real)
    return 10.0 ** (noise.reported_rssi_dbm(heard) / 20.0), np.asarray(noise.reported_phase_rad(heard))


def _sent_from_m(inventory: Inventory, poses: IntArray, transmitters: IntArray) -> FloatArray | None:
    """Where the transmitter was believed to be at each position [m], shape (M, 3); None when monostatic."""
    tx = inventory.rig.tx
    if isinstance(tx, FixedTransmitters):
        return np.asarray(tx.positions_m[transmitters])
    return tx.places(inventory.nominal_track)[poses] if isinstance(tx, WristTransmitter) else None
