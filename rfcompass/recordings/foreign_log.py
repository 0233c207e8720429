"""What importers of other programs' logs share: cut lines, lacking cells, and the way into a trace.

A line without its line end is one that was being written when the program or the disk stopped. Its last number may be
cut, and a cut number is a number: such a line is dropped and counted, whatever it looks like.
"""

import csv
import gzip
import io
import json
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np
import pyarrow as pa

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.errors import ImportFormatError, TraceError
from rfcompass.recordings.carriage import Carriage, StillAntennas
from rfcompass.recordings.text_table import TextTable, as_table
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import TraceMeta

# A phase that a reader reports modulo π in practice; see docs/readers.md.
READER_META = TraceMeta(frame="antenna", phase_modulus="pi")

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_UNREADABLE = (OSError, EOFError, UnicodeDecodeError, zlib.error)


@dataclass(frozen=True, slots=True)
class ForeignLog:
    """A log as text.

    Attributes:
        name: Name of the file, for errors.
        lines: Its lines without those that are empty or cut.
        cut_lines: 1 if the last line was cut, else 0.
    """

    name: str
    lines: tuple[str, ...]
    cut_lines: int

    def table(self, header: Sequence[str], lines: Sequence[str]) -> TextTable:
        """Split lines into cells.

        Raises:
            ImportFormatError: If a row has too many or too few cells; names `row`.
        """
        try:
            cells = list(csv.reader(io.StringIO("\n".join(lines)), strict=True, skipinitialspace=True))
        except csv.Error as cause:
            raise ImportFormatError(f"{self.name}: cannot be read: {cause}", file=self.name) from cause
        return as_table(self.name, list(header), cells, ImportFormatError)


def read_log(path: str | Path) -> ForeignLog:
    """Read a text file (UTF-8, with or without byte order mark, optionally gzipped).

    Raises:
        ImportFormatError: If it cannot be read or holds no whole line.
    """
    file = Path(path)
    try:
        content = file.read_bytes()
        text = (gzip.decompress(content) if file.suffix == ".gz" else content).decode("utf-8-sig")
    except _UNREADABLE as cause:
        raise ImportFormatError(f"{file.name}: cannot be read: {cause}", file=file.name) from cause
    *whole, rest = text.replace("\r\n", "\n").split("\n")
    lines = tuple(line for line in whole if line.strip())
    if not lines:
        raise ImportFormatError(f"{file.name}: holds no whole line", file=file.name)
    return ForeignLog(file.name, lines, int(bool(rest)))


@dataclass(frozen=True, slots=True, kw_only=True)
class LogColumns:
    """The reads of a log in SI units, NaN where a cell is empty; all of shape (R,).

    Attributes:
        epcs: As written.
        antennas: Port.
        freq_hz: Carrier [Hz].
        rssi_dbm: Received power [dBm].
        phase_rad: Raw phase [rad].
        t_ns: Time of the log, UTC [ns]; None where the log has none.
        doppler_hz: Doppler shift [Hz].
        dropped: Rows that are of no use, by reason, on top of those that lack a value.
    """

    epcs: Sequence[str]
    antennas: IntArray
    freq_hz: FloatArray
    rssi_dbm: FloatArray
    phase_rad: FloatArray
    t_ns: Sequence[int | None]
    doppler_hz: FloatArray
    channel_index: IntArray | None = None
    dropped: Mapping[str, BoolArray] = field(default_factory=dict)


def numbers(table: TextTable, column: str, parse: Callable[[str], float] = float) -> FloatArray:
    """One column as finite numbers, NaN where a cell is empty, shape (R,).

    Raises:
        ImportFormatError: If the column is missing or a cell is no finite number; names `column` and `row`.
    """
    values = np.full(table.rows, np.nan)
    for row, cell in enumerate(table.text(column)):
        if cell.strip():
            values[row] = _number(table, column, row, parse)
    return values


def optional_numbers(table: TextTable, column: str, parse: Callable[[str], float] = float) -> FloatArray:
    """As `numbers`, all NaN if there is no such column."""
    return numbers(table, column, parse) if column in table.columns else np.full(table.rows, np.nan)


def channels(table: TextTable, column: str, frequencies_hz: Sequence[float]) -> tuple[IntArray, FloatArray, BoolArray]:
    """Channel indices from 1, the carriers that the reader's table gives them, and which lie outside it; shape (R,).

    Args:
        table: The log.
        column: Name of its channel column.
        frequencies_hz: Carrier of channel index 1, 2, … [Hz].

    Raises:
        ImportFormatError: If there is no table, or a cell is no integer.
    """
    if not len(frequencies_hz):
        message = f"{table.file}: names channels, not frequencies; state the reader's own frequency table"
        raise ImportFormatError(message, file=table.file, column=column)
    index = table.integers(column)
    outside = (index < 1) | (index > len(frequencies_hz))
    return index, np.asarray(frequencies_hz, dtype=np.float64)[np.where(outside, 1, index) - 1], outside


def _number(table: TextTable, column: str, row: int, parse: Callable[[str], float]) -> float:
    cell = table.text(column)[row]
    try:
        value = parse(cell)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        message = f"{table.file}, column {column}, row {row}: {cell!r} is no finite number"
        raise ImportFormatError(message, file=table.file, column=column, row=row)
    return value


def times_ns(table: TextTable, column: str) -> list[int | None]:
    """One column of times, seconds since 1970 or ISO 8601, in ns; without a zone they are taken as UTC.

    Raises:
        ImportFormatError: If a cell is no time; names `column` and `row`.
    """
    parsed: list[int | None] = []
    for row, cell in enumerate(table.text(column)):
        try:
            parsed.append(_time_ns(cell.strip()) if cell.strip() else None)
        except (ValueError, OverflowError, InvalidOperation) as cause:
            message = f"{table.file}, column {column}, row {row}: {cell!r} is no time"
            raise ImportFormatError(message, file=table.file, column=column, row=row) from cause
    return parsed


def _time_ns(cell: str) -> int:
    try:
        return _in_range(int(Decimal(cell) * 10**9))
    except InvalidOperation:
        pass
    moment = datetime.fromisoformat(cell)
    moment = moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)
    whole = moment.replace(microsecond=0) - _EPOCH
    return _in_range((whole.days * 86_400 + whole.seconds) * 10**9 + _fraction_ns(cell))


def _fraction_ns(cell: str) -> int:
    """Decimals of the seconds; `datetime` keeps six digits only, ItemTest writes seven."""
    _, point, rest = cell.replace(",", ".").partition(".")
    digits = "".join(rest[: len(rest) - len(rest.lstrip("0123456789"))]) if point else ""
    return int(digits[:9].ljust(9, "0")) if digits else 0


def _in_range(value: int) -> int:
    if not -(2**63) <= value < 2**63:
        raise ValueError(f"{value} ns is no 64-bit integer")
    return value


def log_trace(log: ForeignLog, columns: LogColumns, meta: TraceMeta, carriage: Carriage | None) -> Trace:
    """Make a trace of a log; rows of no use are dropped and counted in `meta.json`, under `import`.

    Args:
        log: Where the columns come from.
        columns: Its reads.
        meta: How to interpret them.
        carriage: Where the antennas were; at the origin, one pose for each, if None.

    Raises:
        ImportFormatError: If a value is not possible, or no row is of use; the latter carries `dropped`.
    """
    where = StillAntennas() if carriage is None else carriage
    known_time = np.array([t_ns is not None for t_ns in columns.t_ns], dtype=np.bool_)
    t_ns = np.array([t_ns or 0 for t_ns in columns.t_ns], dtype=np.int64)
    pose_ids = where.pose_ids(columns.antennas, t_ns, known_time)
    reasons = {
        "no_epc": np.array([not epc for epc in columns.epcs], dtype=np.bool_),
        "no_phase": np.isnan(columns.phase_rad),
        "no_rssi": np.isnan(columns.rssi_dbm),
        **columns.dropped,
        "no_frequency": np.isnan(columns.freq_hz),
        "no_place": pose_ids < 0,
    }
    keep, dropped = _sieve(reasons, len(columns.epcs))
    if log.cut_lines:
        dropped["cut_line"] = log.cut_lines
    if not keep.any():
        why = ", ".join(f"{reason} {count}" for reason, count in dropped.items()) or "it holds none"
        raise ImportFormatError(f"{log.name}: no read is of use: {why}", file=log.name, dropped=dropped)
    reads = _table(columns, pose_ids, known_time).filter(pa.array(keep))
    told = {"rows": len(columns.epcs) + log.cut_lines, "written": int(keep.sum()), "dropped": dropped}
    described = replace(meta, unknown_json=json.dumps({**json.loads(meta.unknown_json), "import": told}))
    pairs = zip(pose_ids[keep].tolist(), columns.antennas[keep].tolist(), strict=True)
    try:
        return Trace(described, reads, where.poses(pairs))
    except TraceError as error:
        raise _in_file(log, keep, error) from error


def _sieve(reasons: Mapping[str, BoolArray], rows: int) -> tuple[BoolArray, dict[str, int]]:
    """Rows to keep, and how many were dropped; a row with several lacks counts under the first."""
    keep, dropped = np.ones(rows, dtype=np.bool_), dict[str, int]()
    for reason, bad in reasons.items():
        if count := int((keep & bad).sum()):
            dropped[reason] = count
        keep &= ~bad
    return keep, dropped


def _table(columns: LogColumns, pose_ids: IntArray, known_time: BoolArray) -> pa.Table:
    table = {
        "epc": pa.array([epc.lower() for epc in columns.epcs], pa.string()),
        "antenna": pa.array(columns.antennas, pa.int32()),
        "freq_hz": columns.freq_hz,
        "rssi_dbm": columns.rssi_dbm,
        "phase_rad": columns.phase_rad % (2.0 * np.pi),
        "pose_id": pose_ids,
    }
    if known_time.any():
        table["t_ns"] = pa.array(columns.t_ns, pa.int64())
    if not np.isnan(columns.doppler_hz).all():
        table["doppler_hz"] = pa.array(columns.doppler_hz, from_pandas=True)
    if columns.channel_index is not None:
        table["channel_index"] = pa.array(columns.channel_index, pa.int32())
    return pa.table(table)


def _in_file(log: ForeignLog, keep: BoolArray, error: TraceError) -> ImportFormatError:
    """The same defect with the row of the log."""
    numbers_ = {name: value for name, value in error.numbers.items() if name != "file"}
    if isinstance(row := numbers_.get("row"), int):
        numbers_["row"] = int(np.flatnonzero(keep)[row])
    return ImportFormatError(f"{log.name}: {error.message}", **numbers_, file=log.name)
