"""CSV files as columns of text, with typed access that knows the row of each defect."""

import csv
import gzip
import io
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.errors import ImportFormatError, InputError, TraceError

Number = TypeVar("Number", int, float)

# What reading and unpacking a damaged text file can raise.
_UNREADABLE = (OSError, EOFError, UnicodeDecodeError, csv.Error, zlib.error)


@dataclass(frozen=True, slots=True)
class TextTable:
    """A CSV file, each column as text.

    Attributes:
        file: Name used in errors.
        columns: Text of each cell by column, all of the same length.
        error: Class of the errors that the table raises.
    """

    file: str
    columns: Mapping[str, Sequence[str]]
    error: type[TraceError] | type[ImportFormatError] = TraceError

    @property
    def rows(self) -> int:
        """Number of rows without the header."""
        return len(next(iter(self.columns.values()), ()))

    def text(self, name: str) -> Sequence[str]:
        """One column as it stands in the file.

        Raises:
            InputError: If the column is missing; lists those that exist.
        """
        if name not in self.columns:
            found = ", ".join(self.columns) or "none"
            raise self.error(f"{self.file}: column {name} is missing (found: {found})", file=self.file, column=name)
        return self.columns[name]

    def floats(self, name: str) -> FloatArray:
        """One column as finite numbers, shape (R,).

        Raises:
            InputError: If the column is missing, or a cell is no finite number; names its row.
        """
        values = np.array(self._parsed(name, float, "number"), dtype=np.float64)
        if not np.isfinite(values).all():
            raise self._bad_cell(name, int(np.argmin(np.isfinite(values))), "finite number")
        return values

    def integers(self, name: str) -> IntArray:
        """One column as integers, shape (R,).

        Raises:
            InputError: If the column is missing, or a cell is no 64-bit integer; names its row.
        """
        values = self._parsed(name, int, "integer")
        for row, value in enumerate(values):
            if not -(2**63) <= value < 2**63:
                raise self._bad_cell(name, row, "64-bit integer")
        return np.array(values, dtype=np.int64)

    def _parsed(self, name: str, parse: type[Number], what: str) -> list[Number]:
        cells, parsed = self.text(name), []
        for row, cell in enumerate(cells):
            try:
                parsed.append(parse(cell))
            except ValueError:
                raise self._bad_cell(name, row, what) from None
        return parsed

    def _bad_cell(self, name: str, row: int, what: str) -> InputError:
        message = f"{self.file}, column {name}, row {row}: {self.columns[name][row]!r} is no {what}"
        return self.error(message, file=self.file, column=name, row=row)


def read_text_table(path: Path, error: type[TraceError] | type[ImportFormatError] = TraceError) -> TextTable:
    """Read a CSV file (UTF-8, with or without byte order mark, optionally gzipped) into columns of text.

    Empty lines are skipped; rows are counted from 0 without the header.

    Raises:
        InputError: Of class `error`, if the file cannot be read, names a column twice or not at all, or if a
            row has too many or too few cells.
    """
    name = path.name or str(path)
    try:
        content = path.read_bytes()
        text = (gzip.decompress(content) if path.suffix == ".gz" else content).decode("utf-8-sig")
        lines = [line for line in csv.reader(io.StringIO(text), strict=True) if line]
    except _UNREADABLE as cause:
        raise error(f"{name}: cannot be read: {cause}", file=name) from cause
    if not lines:
        raise error(f"{name}: is empty, not even a header", file=name)
    return as_table(name, lines[0], lines[1:], error)


def as_table(
    file: str, header: list[str], lines: list[list[str]], error: type[TraceError] | type[ImportFormatError]
) -> TextTable:
    """Turn lines of cells into columns.

    Raises:
        InputError: Of class `error`, if a column stands twice, or a row has too many or too few cells.
    """
    for name in header:
        if header.count(name) > 1:
            raise error(f"{file}: column {name} stands twice", file=file, column=name)
    for row, line in enumerate(lines):
        if len(line) != len(header):
            message = f"{file}, row {row}: {len(line)} cells, the header has {len(header)}"
            raise error(message, file=file, row=row)
    cells = zip(*lines, strict=True) if lines else ((),) * len(header)
    return TextTable(file, dict(zip(header, cells, strict=True)), error)


def as_csv(columns: Mapping[str, Sequence[object]]) -> bytes:
    """Write columns of equal length as CSV. Floats are written so that reading gives the same bits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return text.getvalue().encode()
