"""Importer for the CSV captures of llrpkit (`llrpkit inventory --output FILE`).

Columns: at (host time, seconds since 1970), epc, antenna, rssi_dbm, phase_deg, doppler_hz, channel, and more that say
nothing about the radio. The capture rounds the phase to 0.1° and the time to 1 ms.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from rfcompass.recordings.carriage import Carriage
from rfcompass.recordings.foreign_log import (
    READER_META,
    LogColumns,
    channels,
    log_trace,
    numbers,
    optional_numbers,
    read_log,
    times_ns,
)
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import TraceMeta


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
    log = read_log(path)
    table = log.table([name.strip() for name in log.lines[0].split(",")], log.lines[1:])
    phase_rad = np.radians(numbers(table, "phase_deg"))
    index, freq_hz, outside = channels(table, "channel", frequencies_hz)
    columns = LogColumns(
        epcs=[epc.strip() for epc in table.text("epc")],
        antennas=table.integers("antenna"),
        freq_hz=freq_hz,
        rssi_dbm=numbers(table, "rssi_dbm"),
        phase_rad=phase_rad,
        t_ns=times_ns(table, "at"),
        doppler_hz=optional_numbers(table, "doppler_hz"),
        channel_index=index,
        dropped={"channel_outside_table": outside},
    )
    described = replace(meta, source=f"llrpkit capture, {log.name}", reader="LLRP reader, logged with llrpkit")
    return log_trace(log, columns, described, carriage)
