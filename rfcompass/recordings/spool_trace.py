"""Turning a spool into a trace, batch by batch, so that memory does not grow with the length of a recording."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from rfcompass.arrays import IntArray
from rfcompass.errors import NothingRecorded, TraceError
from rfcompass.files import atomic_folder
from rfcompass.recordings.antenna_poses import POSES_FILE, poses_csv
from rfcompass.recordings.carriage import Carriage, StillAntennas
from rfcompass.recordings.meta_json import meta_json
from rfcompass.recordings.read_table import READS_FILE
from rfcompass.recordings.spool import SCHEMA, spooled_meta, spooled_reads
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import META_FILE, TraceMeta

# Reads in one row group of the file (ours): some megabytes.
_GROUP_READS = 50_000

_MANDATORY = ("epc", "antenna", "freq_hz", "rssi_dbm", "phase_rad", "pose_id")


@dataclass(frozen=True, slots=True)
class SpoolSummary:
    """What a spool holds.

    Attributes:
        reads: Number of reads whose place is known.
        unplaced: Number of the others.
        epcs: Tags of the placed reads, sorted.
        pairs: (pose_id, antenna) of the placed reads, sorted.
        columns: Columns in which a placed read has a value, in the order of the schema.
    """

    reads: int
    unplaced: int
    epcs: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...]
    columns: tuple[str, ...]


def trace_from_spool(
    spool: Path, target: Path, carriage: Carriage, describe: Callable[[SpoolSummary], TraceMeta]
) -> SpoolSummary:
    """Write a trace folder, all of it or nothing; the spool is read twice and stays.

    Args:
        spool: Folder of the spool.
        target: Trace folder; what is there is replaced.
        carriage: Where the antennas were. Reads without a place are left out.
        describe: Gives the trace's meta once the content is known.

    Raises:
        TraceError: If the spool cannot be read or the trace not be written.
    """
    summary = _summary(spool, carriage)
    meta = meta_json(describe(summary)).encode()
    poses = poses_csv(carriage.poses(summary.pairs))
    try:
        with atomic_folder(target) as folder:
            (folder / META_FILE).write_bytes(meta)
            (folder / POSES_FILE).write_bytes(poses)
            _write_reads(folder / READS_FILE, spool, carriage, summary.columns)
    except OSError as cause:
        raise TraceError(f"{target}: cannot be written: {cause}", path=str(target)) from cause
    return summary


def import_spool(path: str | Path, *, carriage: Carriage | None = None) -> Trace:
    """Make a trace of a recording that did not end; the spool stays.

    Args:
        path: Folder `NAME.recording`.
        carriage: Where the antennas were; at the origin if None.

    Raises:
        TraceError: If it is no spool.
        NothingRecorded: If no read in it can be kept.
    """
    spool, where = Path(path), StillAntennas() if carriage is None else carriage
    meta, summary = spooled_meta(spool), _summary(spool, where)
    if not summary.reads:
        message = f"{spool}: no read can be kept (without a place: {summary.unplaced})"
        raise NothingRecorded(message, spool=str(spool), dropped={"no_place": summary.unplaced})
    batches = [batch.select(list(summary.columns)) for batch, _ in _placed(spool, where)]
    dropped = {"no_place": summary.unplaced} if summary.unplaced else {}
    told = {"written": summary.reads, "dropped": dropped, "ended": "recovered"}
    described = replace(meta, unknown_json=json.dumps({**json.loads(meta.unknown_json), "recording": told}))
    return Trace(described, pa.Table.from_batches(batches), where.poses(summary.pairs))


def _placed(spool: Path, carriage: Carriage) -> Iterator[tuple[pa.RecordBatch, int]]:
    """Batches of reads with their poses, and how many of each were left out for want of a place."""
    for batch in spooled_reads(spool):
        t_ns = batch.column("t_ns")
        known_time = pc.is_valid(t_ns).to_numpy(zero_copy_only=False)
        antennas = batch.column("antenna").to_numpy(zero_copy_only=False).astype(np.int64)
        pose_ids = carriage.pose_ids(antennas, pc.fill_null(t_ns, 0).to_numpy(zero_copy_only=False), known_time)
        index = SCHEMA.get_field_index("pose_id")
        placed = batch.set_column(index, SCHEMA.field(index), pa.array(pose_ids, pa.int64()))
        keep = pose_ids >= 0
        yield placed.filter(pa.array(keep)), int((~keep).sum())


def _summary(spool: Path, carriage: Carriage) -> SpoolSummary:
    reads, unplaced = 0, 0
    epcs, pairs, columns = set[str](), set[tuple[int, int]](), set(_MANDATORY)
    for batch, left_out in _placed(spool, carriage):
        reads, unplaced = reads + batch.num_rows, unplaced + left_out
        epcs.update(pc.unique(batch.column("epc")).to_pylist())
        pairs.update(_pairs(batch))
        columns.update(name for name in SCHEMA.names if batch.column(name).null_count < batch.num_rows)
    in_order = tuple(name for name in SCHEMA.names if name in columns)
    return SpoolSummary(reads, unplaced, tuple(sorted(epcs)), tuple(sorted(pairs)), in_order)


def _pairs(batch: pa.RecordBatch) -> list[tuple[int, int]]:
    ids: list[IntArray] = [batch.column(name).to_numpy(zero_copy_only=False) for name in ("pose_id", "antenna")]
    return [(int(pose_id), int(antenna)) for pose_id, antenna in np.unique(np.stack(ids), axis=1).T]


def _write_reads(file: Path, spool: Path, carriage: Carriage, columns: tuple[str, ...]) -> None:
    schema = pa.schema([SCHEMA.field(name) for name in columns])
    with pq.ParquetWriter(file, schema, compression="zstd", write_page_checksum=True) as writer:
        waiting: list[pa.RecordBatch] = []
        for batch, _ in _placed(spool, carriage):
            waiting.append(batch.select(list(columns)))
            if sum(part.num_rows for part in waiting) >= _GROUP_READS:
                writer.write_table(pa.Table.from_batches(waiting, schema))
                waiting = []
        writer.write_table(pa.Table.from_batches(waiting, schema))
