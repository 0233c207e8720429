"""Importer for the CSV layout of the AdaRF campaign (one antenna on a linear slide), doi 10.1145/3351271.

One CSV file for each slide position, named `SWEEP_INDEX.csv` or, in a folder of the sweep's name, `INDEX.csv`; each may
be gzipped. Columns: epc, antennaIndex, frequency [Hz], time, RSSI [dBm], phase [rad], dopplerShift, velocity, x [m], y,
z, angle. Only epc, antennaIndex, frequency, RSSI, phase and x mean something; the other columns hold constants that
contradict the rig, so that they are not taken over. The phase grows with distance: `phase_sign` is +1; it is reported
in [0, 2π] and taken modulo 2π, since a full turn is none.
"""

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa

from rfcompass.arrays import BoolArray
from rfcompass.errors import ImportFormatError, TraceError
from rfcompass.recordings.antenna_poses import AntennaPoses
from rfcompass.recordings.read_table import read_columns
from rfcompass.recordings.text_table import TextTable, read_text_table
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import TraceMeta, TraceTag

_NAME = re.compile(r"(?:(?P<sweep>[^.].*)_)?(?P<index>\d{1,9})\.csv(?:\.gz)?")
_COLUMNS = {
    "epc": "epc", "antenna": "antennaIndex", "freq_hz": "frequency", "rssi_dbm": "RSSI", "phase_rad": "phase",
}  # fmt: skip

# How far the reported slide position may wander within one file; λ / 300, less than any method resolves (ours).
_SLIDE_TOLERANCE_M = 1e-3


@dataclass(frozen=True, slots=True)
class _Position:
    """The reads at one slide position."""

    index: int
    x_m: float
    antenna: int
    reads: pa.Table


def import_adarf(path: str | Path, *, sweep: str | None = None, epcs: Sequence[str] | None = None) -> Trace:
    """Read one sweep of the slide.

    The slide is the x axis of frame `rail`; antenna and tags are taken to share one plane (`dimensions` 2), since the
    layout does not say how high they are. The file's index becomes the pose_id, its reported x the antenna position.

    Args:
        path: Folder with the CSV files.
        sweep: Which sweep, if the folder holds several.
        epcs: Tags that belong to the trace; reads of other tags stay in it as strays. All that were heard if None.

    Raises:
        ImportFormatError: If the folder holds no sweep, several, or not the one asked for; or if a file is malformed
            (`file`, `column`, and `row` counted from 0 without the header).
    """
    folder = Path(path)
    name, files = _choose(folder, _find_sweeps(folder), sweep)
    positions = [_read_position(files[index], index) for index in sorted(files)]
    _check_antenna(positions, files)
    reads = pa.concat_tables([position.reads for position in positions])
    listed = sorted(set(reads["epc"].to_pylist())) if epcs is None else epcs
    meta = TraceMeta(
        frame="rail",
        dimensions=2,
        tags=tuple(TraceTag(epc) for epc in listed),
        source=f"AdaRF CSV layout, sweep {name}",
        reader="Impinj, one antenna on a linear slide",
    )
    return Trace(meta, reads, _poses(positions))


def _find_sweeps(folder: Path) -> dict[str, dict[int, Path]]:
    """Files by sweep and index of the slide position."""
    if not folder.is_dir():
        raise ImportFormatError(f"{folder}: is no folder", file=str(folder))
    sweeps: dict[str, dict[int, Path]] = defaultdict(dict)
    for file in sorted(folder.iterdir()):
        if match := _NAME.fullmatch(file.name):
            files, index = sweeps[match["sweep"] or folder.resolve().name], int(match["index"])
            if index in files:
                message = f"{folder}: {files[index].name} and {file.name} are both position {index}"
                raise ImportFormatError(message, file=file.name, index=index)
            files[index] = file
    return dict(sweeps)


def _choose(
    folder: Path, sweeps: Mapping[str, Mapping[int, Path]], sweep: str | None
) -> tuple[str, Mapping[int, Path]]:
    names = sorted(sweeps)
    if not names:
        message = f"{folder}: holds no file named SWEEP_INDEX.csv or INDEX.csv (.gz)"
        raise ImportFormatError(message, file=str(folder), sweeps=[])
    if sweep is None and len(names) > 1:
        message = f"{folder}: holds {len(names)} sweeps, choose one of {', '.join(names)}"
        raise ImportFormatError(message, file=str(folder), sweeps=names)
    chosen = names[0] if sweep is None else sweep
    if chosen not in sweeps:
        message = f"{folder}: holds no sweep {chosen} (found: {', '.join(names)})"
        raise ImportFormatError(message, file=str(folder), sweep=chosen, sweeps=names)
    return chosen, sweeps[chosen]


def _read_position(file: Path, index: int) -> _Position:
    table = read_text_table(file, ImportFormatError)
    antennas, x_m = table.integers("antennaIndex"), table.floats("x")
    if not table.rows:
        raise ImportFormatError(f"{file.name}: holds no read, so that the slide position is unknown", file=file.name)
    reads = pa.table({
        "epc": pa.array(table.text("epc"), pa.string()),
        "antenna": antennas,
        "freq_hz": table.floats("frequency"),
        "rssi_dbm": table.floats("RSSI"),
        "phase_rad": table.floats("phase") % (2.0 * np.pi),
        "pose_id": pa.array(np.full(table.rows, index), pa.int32()),
    })  # fmt: skip
    _check_reads(file, reads)
    _check_constant(table, "antennaIndex", antennas != antennas[0])
    _check_constant(table, "x", np.abs(x_m - x_m[0]) > _SLIDE_TOLERANCE_M)
    return _Position(index, float(np.median(x_m)), int(antennas[0]), reads)


def _check_reads(file: Path, reads: pa.Table) -> None:
    """Apply the checks of a trace while the row in the foreign file is still known."""
    try:
        read_columns(reads, phase_sign=1)
    except TraceError as error:
        column, row = _COLUMNS[str(error.numbers["column"])], error.numbers["row"]
        message = f"{file.name}, column {column}, row {row}: {error.message.partition(': ')[2]}"
        raise ImportFormatError(message, file=file.name, column=column, row=row) from error


def _check_constant(table: TextTable, column: str, differs: BoolArray) -> None:
    if differs.any():
        row = int(np.argmax(differs))
        first, other = table.text(column)[0], table.text(column)[row]
        message = f"{table.file}, column {column}, row {row}: {other} after {first}, yet a file is one slide position"
        raise ImportFormatError(message, file=table.file, column=column, row=row)


def _check_antenna(positions: Sequence[_Position], files: Mapping[int, Path]) -> None:
    for position in positions:
        if position.antenna != positions[0].antenna:
            file = files[position.index].name
            message = f"{file}: antenna {position.antenna} after {positions[0].antenna}, yet the slide carries one"
            raise ImportFormatError(message, file=file, column="antennaIndex", row=0)


def _poses(positions: Sequence[_Position]) -> AntennaPoses:
    P = len(positions)
    x_m = np.array([position.x_m for position in positions])
    return AntennaPoses(
        pose_ids=np.array([position.index for position in positions]),
        antennas=np.array([position.antenna for position in positions]),
        positions_m=np.stack([x_m, np.zeros(P), np.zeros(P)], axis=1),
        quaternions_xyzw=np.tile([0.0, 0.0, 0.0, 1.0], (P, 1)),
    )
