"""Traces on disk: a folder that is either complete or not there."""

import logging
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import pyarrow as pa
import pyarrow.parquet as pq

from rfcompass.errors import TraceError
from rfcompass.files import atomic_folder
from rfcompass.recordings.antenna_poses import POSES_FILE, parse_poses, poses_csv
from rfcompass.recordings.defects import defect
from rfcompass.recordings.meta_json import is_trace_meta, meta_json, parse_meta
from rfcompass.recordings.read_table import READS_FILE
from rfcompass.recordings.result_folder import check_above
from rfcompass.recordings.stops import STOPS_FILE, parse_stops, stops_csv
from rfcompass.recordings.stored_proximity import PROXIMITY_FILE, parse_proximity, proximity_table
from rfcompass.recordings.text_table import read_text_table
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import META_FILE

TRACE_FILES = (META_FILE, READS_FILE, POSES_FILE, STOPS_FILE, PROXIMITY_FILE)

_log = logging.getLogger(__name__)
_Parsed = TypeVar("_Parsed")


def open_trace(path: str | Path) -> Trace:
    """Read and check a trace folder.

    Raises:
        TraceError: If the path is no trace folder or a file in it breaks the format. Carries `path` and `file` and,
            where known, `column` and `row` (counted from 0 without the header).
    """
    folder = Path(path)
    try:
        return _open(folder)
    except TraceError as error:
        raise TraceError(f"{folder}: {error.message}", **error.numbers, path=str(folder)) from error
    except OSError as cause:
        raise TraceError(f"{folder}: cannot be read: {cause}", path=str(folder)) from cause


def _open(folder: Path) -> Trace:
    if not (folder / META_FILE).is_file():
        raise TraceError(f"is no trace: there is no folder with a {META_FILE}", file=META_FILE)
    return Trace(
        meta=parse_meta(_read_text(folder / META_FILE)),
        reads=_read_parquet(folder / READS_FILE),
        antenna_poses=parse_poses(read_text_table(folder / POSES_FILE)),
        stops=_if_there(folder / STOPS_FILE, lambda file: parse_stops(read_text_table(file))),
        proximity=_if_there(folder / PROXIMITY_FILE, lambda file: parse_proximity(_read_parquet(file))) or {},
    )


def _if_there(file: Path, parse: Callable[[Path], _Parsed]) -> _Parsed | None:
    return parse(file) if file.exists() else None


def _read_text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as cause:
        raise defect(file.name, f"cannot be read: {cause}") from cause


def _read_parquet(file: Path) -> pa.Table:
    try:
        with pq.ParquetFile(file, page_checksum_verification=True) as parquet:
            table = parquet.read()
        table.validate(full=True)
    except (pa.ArrowException, OSError, ValueError, MemoryError) as cause:
        raise defect(file.name, f"cannot be read: {cause}") from cause
    return table


def write_trace(trace: Trace, path: str | Path, *, overwrite: bool = False) -> None:
    """Write a trace folder, all of it or nothing; equal traces give equal bytes.

    Args:
        trace: What to write.
        path: Folder to create; its parents are created as needed.
        overwrite: Replace a trace that is already there. Anything else that is there is never replaced.

    Raises:
        TraceError: If something is there that must not be replaced, or the disk refuses; carries `path`.
    """
    target = Path(path).resolve()
    contents = _encode(trace)
    try:
        check_trace_target(target, overwrite=overwrite)
        with atomic_folder(target) as folder:
            for name, content in contents.items():
                (folder / name).write_bytes(content)
    except OSError as cause:
        raise TraceError(f"{target}: cannot be written: {cause}", path=str(target)) from cause
    _log.info("wrote %d reads to %s", trace.reads.num_rows, target)


def _encode(trace: Trace) -> dict[str, bytes]:
    contents = {
        META_FILE: meta_json(trace.meta).encode(),
        READS_FILE: _parquet(trace.reads),
        POSES_FILE: poses_csv(trace.antenna_poses),
    }
    if trace.stops is not None:
        contents[STOPS_FILE] = stops_csv(trace.stops)
    if trace.proximity:
        contents[PROXIMITY_FILE] = _parquet(proximity_table(trace.proximity))
    return contents


def _parquet(table: pa.Table) -> bytes:
    sink = pa.BufferOutputStream()
    # Nested names are kept as they are, so that a column of lists reads back equal and rewrites to equal bytes.
    pq.write_table(table, sink, compression="zstd", write_page_checksum=True, use_compliant_nested_type=False)
    return sink.getvalue().to_pybytes()


def check_trace_target(target: Path, *, overwrite: bool) -> None:
    """Check that a trace may be written there.

    Raises:
        TraceError: If something is there that must not be replaced, or nothing can be written there; carries `path`.
    """
    check_above(target)
    if not target.exists() or (target.is_dir() and not any(target.iterdir())):
        return
    if not _is_trace(target):
        raise TraceError(f"{target}: is there and holds something else than a trace", path=str(target))
    if not overwrite:
        raise TraceError(f"{target}: holds a trace already; overwriting was not asked for", path=str(target))


def _is_trace(folder: Path) -> bool:
    """True if the folder holds a trace, however damaged, and no other file."""
    if not (folder / META_FILE).is_file() or any(entry.name not in TRACE_FILES for entry in folder.iterdir()):
        return False
    try:
        return is_trace_meta(_read_text(folder / META_FILE))
    except TraceError:
        return False
