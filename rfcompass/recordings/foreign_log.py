"""What importers of other programs' logs share: cut lines, lacking cells, impossible values, and the way into a trace.

A line without its line end is one that was being written when the program or the disk stopped. Its last number may be
cut, and a cut number is a number: such a line is dropped and counted, whatever it looks like. A value that its layout
cannot hold, such as degrees where radians belong, is an error with its row: the file is not what it is taken for.
"""

import csv
import gzip
import json
import re
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
from rfcompass.recordings.defects import first_row
from rfcompass.recordings.text_table import TextTable, as_table
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import TraceMeta

# A phase that a reader reports modulo π in practice; see docs/readers.md.
READER_META = TraceMeta(frame="antenna", phase_modulus="pi")

# Carriers of the UHF band as the ITU draws it; a number outside is in some other unit.
UHF_HZ = (300e6, 3e9)

_HEX = re.compile(r"(?:[0-9a-f]{2})+")
_LAST_PORT = (1 << 16) - 1  # LLRP counts ports from 1 in 16 bits

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
            ImportFormatError: If a row has too many or too few cells, or an open quote; names `row`.
        """
        cells = [self._cells(row, line) for row, line in enumerate(lines)]
        return as_table(self.name, list(header), cells, ImportFormatError)

    def _cells(self, row: int, line: str) -> list[str]:
        """Cells of one line; a quote that is still open at its end would otherwise swallow the next ones."""
        try:
            return next(csv.reader([line], strict=True, skipinitialspace=True))
        except csv.Error as cause:
            raise ImportFormatError(f"{self.name}, row {row}: {cause}", file=self.name, row=row) from cause


def read_log(path: str | Path) -> ForeignLog:
    """Read a text file (UTF-8, with or without byte order mark, optionally gzipped).

    Raises:
        ImportFormatError: If it cannot be read or holds no whole line.
    """
    file = Path(path)
    name = file.name or str(file)
    try:
        content = file.read_bytes()
        text = (gzip.decompress(content) if file.suffix == ".gz" else content).decode("utf-8-sig")
    except _UNREADABLE as cause:
        raise ImportFormatError(f"{name}: cannot be read: {cause}", file=name) from cause
    *whole, rest = text.replace("\r\n", "\n").split("\n")
    lines = tuple(line for line in whole if line.strip())
    if not lines:
        raise ImportFormatError(f"{name}: holds no whole line", file=name)
    return ForeignLog(name, lines, int(bool(rest)))


@dataclass(frozen=True, slots=True, kw_only=True)
class LogColumns:
    """The reads of a log in SI units, NaN where a cell is empty; all of shape (R,).

    Attributes:
        epcs: Lower-case hexadecimal, empty where there is none.
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


def numbers(
    table: TextTable,
    column: str,
    parse: Callable[[str], float] = float,
    *,
    within: tuple[float, float] = (-np.inf, np.inf),
    whole: bool = False,
) -> FloatArray:
    """One column as finite numbers, NaN where a cell is empty, shape (R,).

    Args:
        table: The log.
        column: Name of the column.
        parse: Makes a number of a cell, or raises ValueError.
        within: Smallest and largest value that the column can hold, in its own unit.
        whole: True if it holds integers; a fraction is then a number in some other unit.

    Raises:
        ImportFormatError: If the column is missing, or a cell is no finite number or none that the column can hold;
            names `column` and `row`.
    """
    values, (lowest, highest) = np.full(table.rows, np.nan), within
    for row, cell in enumerate(table.text(column)):
        if cell.strip():
            values[row] = _number(table, column, row, parse)
            if not lowest <= values[row] <= highest:
                raise _bad_cell(table, column, row, f"not within {lowest:g} to {highest:g}")
            if whole and not values[row].is_integer():
                raise _bad_cell(table, column, row, "no integer")
    return values


def optional_numbers(table: TextTable, column: str, parse: Callable[[str], float] = float) -> FloatArray:
    """As `numbers`, all NaN if there is no such column."""
    return numbers(table, column, parse) if column in table.columns else np.full(table.rows, np.nan)


def ports(table: TextTable, column: str) -> IntArray:
    """One column of reader ports, shape (R,).

    Raises:
        ImportFormatError: If the column is missing or a cell is no port from 1; names `column` and `row`.
    """
    values = table.integers(column)
    impossible = (values < 1) | (values > _LAST_PORT)
    if (row := first_row(impossible)) is not None:
        raise _bad_cell(table, column, row, "no port of a reader")
    return values


def epcs(table: TextTable, column: str, bare: Callable[[str], str] = str.strip) -> list[str]:
    """One column of EPCs as lower-case hexadecimal, empty where a cell is.

    Args:
        table: The log.
        column: Name of the column.
        bare: Takes off what a program writes around or inside an EPC.

    Raises:
        ImportFormatError: If the column is missing or a cell holds no bytes in hexadecimal; names `column` and `row`.
    """
    codes = [bare(cell).lower() for cell in table.text(column)]
    for row, code in enumerate(codes):
        if code and not _HEX.fullmatch(code):
            raise _bad_cell(table, column, row, "no EPC in hexadecimal")
    return codes


def _number(table: TextTable, column: str, row: int, parse: Callable[[str], float]) -> float:
    try:
        value = parse(table.text(column)[row])
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise _bad_cell(table, column, row, "no finite number")
    return value


def _bad_cell(table: TextTable, column: str, row: int, what: str) -> ImportFormatError:
    message = f"{table.file}, column {column}, row {row}: {table.text(column)[row]!r} is {what}"
    return ImportFormatError(message, file=table.file, column=column, row=row)


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
    reads = _table(columns, pose_ids, known_time, keep)
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


def _table(columns: LogColumns, pose_ids: IntArray, known_time: BoolArray, keep: BoolArray) -> pa.Table:
    table = {
        "epc": pa.array(columns.epcs, pa.string()),
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
        # A row that is dropped may hold an index of any size.
        table["channel_index"] = pa.array(np.where(keep, columns.channel_index, 0), pa.int32())
    return pa.table(table).filter(pa.array(keep))


def _in_file(log: ForeignLog, keep: BoolArray, error: TraceError) -> ImportFormatError:
    """The same defect with the row of the log."""
    numbers_ = {name: value for name, value in error.numbers.items() if name != "file"}
    if isinstance(row := numbers_.get("row"), int):
        numbers_["row"] = int(np.flatnonzero(keep)[row])
    return ImportFormatError(f"{log.name}: {error.message}", **numbers_, file=log.name)
