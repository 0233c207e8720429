"""Importer for the CSV files of Impinj ItemTest.

Comment lines start with `//`: the date, the reader's settings, and the header itself: Timestamp, EPC, TID, Antenna,
RSSI [dBm], Frequency [MHz], Hostname, PhaseAngle [rad], DopplerFrequency [Hz], and sometimes CRHandle. Timestamps are
ISO 8601 with a zone. Where the computer's locale has a decimal comma, numbers are written with one, in quotes.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from rfcompass.errors import ImportFormatError
from rfcompass.recordings.carriage import Carriage
from rfcompass.recordings.foreign_log import (
    READER_META,
    UHF_HZ,
    ForeignLog,
    LogColumns,
    epcs,
    log_trace,
    numbers,
    optional_numbers,
    ports,
    read_log,
    times_ns,
)
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import TraceMeta

_COMMENT = "//"
_UHF_MHZ = (UHF_HZ[0] / 1e6, UHF_HZ[1] / 1e6)
# A turn, rounded up to as few as three digits behind the point.
_HIGHEST_RAD = 2.0 * np.pi + 1e-3


def import_itemtest(path: str | Path, *, meta: TraceMeta = READER_META, carriage: Carriage | None = None) -> Trace:
    """Read one file.

    Args:
        path: The CSV file, optionally gzipped.
        meta: Conventions of the reader; source and reader are filled in.
        carriage: Where the antennas were; at the origin if None.

    Raises:
        ImportFormatError: If the file is malformed (`file`, `column`, and `row` counted from 0 among the lines that
            are no comments), or if no row is of use.
    """
    log = read_log(path)
    header, rows = _header(log)
    table = log.table(header, rows)
    columns = LogColumns(
        epcs=epcs(table, "EPC", lambda cell: cell.replace(" ", "")),
        antennas=ports(table, "Antenna"),
        freq_hz=np.round(numbers(table, "Frequency", _decimal, within=_UHF_MHZ) * 1e6),
        rssi_dbm=numbers(table, "RSSI", _decimal),
        phase_rad=numbers(table, "PhaseAngle", _decimal, within=(0.0, _HIGHEST_RAD)),
        t_ns=times_ns(table, "Timestamp"),
        doppler_hz=optional_numbers(table, "DopplerFrequency", _decimal),
    )
    described = replace(meta, source=f"Impinj ItemTest, {log.name}", reader=_reader(log))
    return log_trace(log, columns, described, carriage)


def _header(log: ForeignLog) -> tuple[list[str], list[str]]:
    """Names of the columns, and the lines that are no comments."""
    rows = [line for line in log.lines if not line.startswith(_COMMENT)]
    for line in log.lines:
        names = [name.strip() for name in line.removeprefix(_COMMENT).split(",")]
        if names[0] == "Timestamp" and "EPC" in names:
            return names, [row for row in rows if row != line]
    message = f"{log.name}: no line starts with '// Timestamp, EPC': this is no ItemTest file"
    raise ImportFormatError(message, file=log.name)


def _decimal(cell: str) -> float:
    """A number with decimal point or comma."""
    return float(cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell)


def _reader(log: ForeignLog) -> str:
    """The reader's name and mode, from the comment that states them."""
    for line in log.lines:
        if line.startswith(_COMMENT) and "ReaderName=" in line:
            return line.removeprefix(_COMMENT).strip()
    return "Impinj"
