"""What importers of logs that name channels share: one header line, and carriers from the reader's own table."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.errors import ImportFormatError
from rfcompass.recordings.carriage import Carriage
from rfcompass.recordings.foreign_log import (
    UHF_HZ,
    LogColumns,
    epcs,
    log_trace,
    numbers,
    optional_numbers,
    ports,
    read_log,
    times_ns,
)
from rfcompass.recordings.text_table import TextTable
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import TraceMeta


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelLayout:
    """Columns of a layout and their units.

    Attributes:
        time: Column of the host time.
        rssi: Column of the power [dBm].
        phase: Column of the phase.
        channel: Column of the channel index, from 1.
        doppler: Column of the Doppler shift; may be missing.
        highest_phase: Largest value of the phase column; the smallest is 0.
        phase_step_rad: Its unit [rad].
        whole_phases: True if it holds integers.
        doppler_step_hz: Unit of the Doppler column [Hz].
    """

    time: str
    rssi: str
    phase: str
    channel: str
    doppler: str
    highest_phase: float
    phase_step_rad: float
    whole_phases: bool = False
    doppler_step_hz: float = 1.0


def import_channel_log(
    path: str | Path,
    layout: ChannelLayout,
    frequencies_hz: Sequence[float],
    describe: Callable[[str, TextTable], TraceMeta],
    carriage: Carriage | None,
) -> Trace:
    """Read one file.

    Args:
        path: The CSV file, optionally gzipped.
        layout: What its columns are.
        frequencies_hz: Carrier of channel index 1, 2, … in the reader's own table [Hz].
        describe: Gives the trace's meta, from the name of the file and its content.
        carriage: Where the antennas were; at the origin if None.

    Raises:
        ImportFormatError: If the file is malformed (`file`, `column`, and `row` counted from 0 without the header), no
            frequencies are given, or no row is of use.
    """
    log = read_log(path)
    table = log.table([name.strip() for name in log.lines[0].split(",")], log.lines[1:])
    phases = numbers(table, layout.phase, within=(0.0, layout.highest_phase), whole=layout.whole_phases)
    index, freq_hz, outside = channels(table, layout.channel, frequencies_hz)
    columns = LogColumns(
        epcs=epcs(table, "epc", _bare),
        antennas=ports(table, "antenna"),
        freq_hz=freq_hz,
        rssi_dbm=numbers(table, layout.rssi),
        phase_rad=phases * layout.phase_step_rad,
        t_ns=times_ns(table, layout.time),
        doppler_hz=optional_numbers(table, layout.doppler) * layout.doppler_step_hz,
        channel_index=index,
        dropped={"channel_outside_table": outside},
    )
    return log_trace(log, columns, describe(log.name, table), carriage)


def _bare(epc: str) -> str:
    """EPC without the marks of a Python bytes literal."""
    text = epc.strip()
    for quote in "'\"":
        if text.startswith(f"b{quote}") and text.endswith(quote):
            return text[2:-1]
    return text


def channels(table: TextTable, column: str, frequencies_hz: Sequence[float]) -> tuple[IntArray, FloatArray, BoolArray]:
    """Channel indices from 1, the carriers that the reader's table gives them, and which lie outside it; shape (R,).

    Args:
        table: The log.
        column: Name of its channel column.
        frequencies_hz: Carrier of channel index 1, 2, … [Hz].

    Raises:
        ImportFormatError: If there is no table, it holds what is no UHF carrier, or a cell is no integer.
    """
    if not len(frequencies_hz):
        message = f"{table.file}: names channels, not frequencies; state the reader's own frequency table"
        raise ImportFormatError(message, file=table.file, column=column)
    for freq_hz in frequencies_hz:
        if not UHF_HZ[0] <= freq_hz <= UHF_HZ[1]:
            message = f"{table.file}: the reader's frequency table holds {freq_hz:g} Hz, which is no UHF carrier"
            raise ImportFormatError(message, file=table.file, freq_hz=freq_hz)
    index = table.integers(column)
    outside = (index < 1) | (index > len(frequencies_hz))
    return index, np.asarray(frequencies_hz, dtype=np.float64)[np.where(outside, 1, index) - 1], outside
