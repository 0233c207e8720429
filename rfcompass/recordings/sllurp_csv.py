"""Importer for CSV logs written with sllurp.

Columns: timestamp (seconds since 1970, or ISO 8601), antenna, rssi [dBm], epc, phase_angle (4096ths of a turn),
channel_index, doppler_frequency (16ths of a hertz); some writers put the EPC as `b'3008…'`. `sllurp log` itself writes
neither phase nor channel: such a file cannot become a trace, and the error names the missing column.
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
    time="timestamp",
    rssi="rssi",
    phase="phase_angle",
    channel="channel_index",
    doppler="doppler_frequency",
    highest_phase=4095.0,
    phase_step_rad=2.0 * np.pi / 4096.0,
    whole_phases=True,
    doppler_step_hz=1.0 / 16.0,
)


def import_sllurp(
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

    def describe(name: str, table: TextTable) -> TraceMeta:
        return replace(meta, source=f"sllurp log, {name}", reader=_reader(table))

    return import_channel_log(path, _LAYOUT, frequencies_hz, describe, carriage)


def _reader(table: TextTable) -> str:
    return next(iter(table.columns.get("reader", ())), "") or "LLRP reader, logged with sllurp"
