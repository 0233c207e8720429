"""A recording while it grows: a folder whose content survives the death of whoever writes it.

`NAME.recording` beside the trace to be: `meta.json` as in a trace, and `reads.arrows`, a stream of record batches in
Arrow's IPC format, to which each batch of reads is appended and which is forced to the disk every second. However the
writer ends, what is on the disk can be read up to the last whole batch.
"""

import os
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Self

import pyarrow as pa

from rfcompass.errors import TraceError
from rfcompass.recordings.meta_json import meta_json, parse_meta
from rfcompass.recordings.trace_meta import META_FILE, TraceMeta
from rfcompass.types.reads import TagRead

SPOOL_SUFFIX = ".recording"
_STREAM_FILE = "reads.arrows"
_SYNC_S = 1.0

SCHEMA = pa.schema({
    "epc": pa.string(), "antenna": pa.int32(), "freq_hz": pa.float64(), "rssi_dbm": pa.float64(),
    "phase_rad": pa.float64(), "pose_id": pa.int64(), "t_ns": pa.int64(), "doppler_hz": pa.float64(),
    "tx_antenna": pa.int32(), "i": pa.float64(), "q": pa.float64(), "t_reader_us": pa.int64(),
    "channel_index": pa.int32(),
})  # fmt: skip
"""Columns of a spool: all fields of a read."""


def check_no_spool(folder: Path) -> None:
    """Check that no recording goes on there, and that none that did not end waits to be recovered.

    Raises:
        TraceError: If one does; carries `path`.
    """
    if folder.exists():
        message = (
            f"{folder}: holds a recording that goes on or did not end; if it does not go on, "
            f"`rfcompass import spool {folder}` makes a trace of it, and the folder may then be deleted"
        )
        raise TraceError(message, path=str(folder))


class SpoolWriter:
    """Writes a spool.

    Args:
        folder: Folder to create.
        meta: How to interpret the reads.

    Raises:
        TraceError: If the folder is there already, or the disk refuses.
    """

    def __init__(self, folder: Path, meta: TraceMeta) -> None:
        self.folder = folder
        self.reads = 0
        check_no_spool(folder)
        try:
            folder.mkdir(parents=True)
        except OSError as cause:
            raise TraceError(f"{folder}: cannot be written: {cause}", path=str(folder)) from cause
        (folder / META_FILE).write_text(meta_json(meta), encoding="utf-8")
        self._file = (folder / _STREAM_FILE).open("wb")
        self._stream = pa.ipc.new_stream(self._file, SCHEMA)
        self._synced_s = time.monotonic()

    def write(self, reads: Sequence[TagRead]) -> None:
        """Append a batch; it is out of our hands when this returns.

        Raises:
            TraceError: If the disk refuses.
        """
        if not reads:
            return
        columns = [pa.array([getattr(read, field.name) for read in reads], field.type) for field in SCHEMA]
        try:
            self._stream.write_batch(pa.RecordBatch.from_arrays(columns, schema=SCHEMA))
            self._file.flush()
            if time.monotonic() - self._synced_s > _SYNC_S:
                os.fsync(self._file.fileno())
                self._synced_s = time.monotonic()
        except OSError as cause:
            raise TraceError(f"{self.folder}: cannot be written: {cause}", path=str(self.folder)) from cause
        self.reads += len(reads)

    def close(self) -> None:
        """End the stream; harmless if it has ended."""
        if not self._file.closed:
            self._stream.close()
            self._file.close()

    def __enter__(self) -> Self:
        """Nothing to prepare."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self.close()


def spooled_meta(folder: Path) -> TraceMeta:
    """Read how to interpret the reads of a spool.

    Raises:
        TraceError: If the folder is no spool.
    """
    try:
        return parse_meta((folder / META_FILE).read_text(encoding="utf-8"))
    except OSError as cause:
        raise TraceError(f"{folder}: is no recording: {cause}", path=str(folder), file=META_FILE) from cause


def spooled_reads(folder: Path) -> Iterator[pa.RecordBatch]:
    """Read a spool batch by batch, up to the last whole one.

    Raises:
        TraceError: If there is no spool.
    """
    try:
        with pa.OSFile(str(folder / _STREAM_FILE)) as file:
            yield from _whole_batches(file)
    except OSError as cause:
        raise TraceError(f"{folder}: cannot be read: {cause}", path=str(folder), file=_STREAM_FILE) from cause


def _whole_batches(file: pa.NativeFile) -> Iterator[pa.RecordBatch]:
    try:
        stream = pa.ipc.open_stream(file)
    except pa.ArrowInvalid:  # the writer died before it wrote anything
        return
    while True:
        try:
            batch = stream.read_next_batch()
        except (StopIteration, pa.ArrowInvalid, OSError):  # the end, or a batch that was cut
            return
        if batch.schema.equals(SCHEMA):
            yield batch
