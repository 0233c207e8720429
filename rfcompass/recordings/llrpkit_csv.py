"""Importer for the CSV captures of llrpkit (`llrpkit inventory --output FILE`).

Columns: at (host time, seconds since 1970), epc, antenna, rssi_dbm, phase_deg, doppler_hz, channel, and more that say
nothing about the radio. The capture rounds the phase to 0.1° and the time to 1 ms.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from rfcompass.recordings.carriage import Carriage
from rfcompass.recordings.channel_log import ChannelLayout, import_channel_log
from rfcompass.recordings.foreign_log import READER_META
from rfcompass.recordings.text_table import TextTable
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import TraceMeta

_LAYOUT = ChannelLayout(
    time="at",
    rssi="rssi_dbm",
    phase="phase_deg",
    channel="channel",
    doppler="doppler_hz",
    highest_phase=360.0,
    phase_step_rad=np.pi / 180.0,
)


def import_llrpkit(
    path: str | Path,
    *,
    frequencies_hz: Sequence[float] = (),
    meta: TraceMeta = READER_META,
    carriage: Carriage | None = None,
) -> Trace:
    """Read one file.

    Args:
        path: The CSV file, optionally gzipped.
        frequencies_hz: Carrier of channel index 1, 2, … in the reader's own table [Hz]; the order is the reader's.
        meta: Conventions of the reader; source and reader are filled in.
        carriage: Where the antennas were; at the origin if None.

    Raises:
        ImportFormatError: If the file is malformed (`file`, `column`, and `row` counted from 0 without the header), no
            frequencies are given, or no row is of use.
    """

    def describe(name: str, _: TextTable) -> TraceMeta:
        return replace(meta, source=f"llrpkit capture, {name}", reader="LLRP reader, logged with llrpkit")

    return import_channel_log(path, _LAYOUT, frequencies_hz, describe, carriage)
