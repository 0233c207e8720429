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
from rfcompass.recordings.text_table import TextTable
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import TraceMeta

_PHASE_STEP_RAD = 2.0 * np.pi / 4096.0
_DOPPLER_STEP_HZ = 1.0 / 16.0


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
    log = read_log(path)
    table = log.table([name.strip() for name in log.lines[0].split(",")], log.lines[1:])
    phase_rad = numbers(table, "phase_angle") * _PHASE_STEP_RAD
    index, freq_hz, outside = channels(table, "channel_index", frequencies_hz)
    columns = LogColumns(
        epcs=[_bare(epc) for epc in table.text("epc")],
        antennas=table.integers("antenna"),
        freq_hz=freq_hz,
        rssi_dbm=numbers(table, "rssi"),
        phase_rad=phase_rad,
        t_ns=times_ns(table, "timestamp"),
        doppler_hz=optional_numbers(table, "doppler_frequency") * _DOPPLER_STEP_HZ,
        channel_index=index,
        dropped={"channel_outside_table": outside},
    )
    described = replace(meta, source=f"sllurp log, {log.name}", reader=_reader(table))
    return log_trace(log, columns, described, carriage)


def _bare(epc: str) -> str:
    """EPC without the marks of a Python bytes literal."""
    text = epc.strip()
    for quote in "'\"":
        if text.startswith(f"b{quote}") and text.endswith(quote):
            return text[2:-1]
    return text


def _reader(table: TextTable) -> str:
    return next(iter(table.columns.get("reader", ())), "") or "LLRP reader, logged with sllurp"
