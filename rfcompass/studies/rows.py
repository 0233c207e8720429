"""Rows of a study on disk: Parquet shards of one schema, which DuckDB or pandas read as one table."""

import logging
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from uuid import uuid4

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from rfcompass.arrays import BoolArray
from rfcompass.errors import StudyError
from rfcompass.evaluation.records import CellValue, TrialRecord
from rfcompass.files import write_atomic
from rfcompass.studies.compaction import MANY, join_small_shards, live_shards
from rfcompass.studies.study import Study

# What two runs of one trial need not share.
VOLATILE_COLUMNS = ("runtime_s", "versions")

SHARD_ROWS = 10_000
SHARD_SECONDS = 10.0  # finished trials wait at most this long for the disk while others arrive

_METRIC_TYPES = {
    "float": pa.float64(),
    "bool": pa.bool_(),
    "text": pa.string(),
    "samples": pa.list_(pa.float64()),
}

_log = logging.getLogger(__name__)


def row_schema(study: Study) -> pa.Schema:
    """Return the columns of a study's table; they depend on nothing but its declaration."""
    return pa.schema(
        [
            pa.field("study", pa.string(), nullable=False),
            pa.field("cell", pa.int64(), nullable=False),
            *(pa.field(name, _factor_type(values)) for name, values in study.factors.items()),
            pa.field("seed", pa.int64(), nullable=False),
            *(pa.field(metric.name, _METRIC_TYPES[metric.column]) for metric in study.metrics),
            pa.field("failure_kind", pa.string()),
            pa.field("failure_message", pa.string()),
            pa.field("failure_numbers", pa.string()),
            pa.field("runtime_s", pa.float64(), nullable=False),
            pa.field("versions", pa.string(), nullable=False),
        ]
    )


class RowWriter:
    """Collects records and writes them as shards, each as a whole.

    Args:
        study: Study of the records.
        folder: Folder for the shards; must exist.
        shard_rows: Rows after which a shard is written.
        shard_seconds: Time after which it is written even if smaller [s].
    """

    def __init__(
        self, study: Study, folder: Path, shard_rows: int = SHARD_ROWS, shard_seconds: float = SHARD_SECONDS
    ) -> None:
        self._schema = row_schema(study)
        self._cell_index = {tuple(cell.values()): index for index, cell in enumerate(study.cells)}
        self._folder = folder
        self._shard_rows = shard_rows
        self._shard_seconds = shard_seconds
        self._rows: list[dict[str, object]] = []
        self._written_at = time.monotonic()
        self._shards = 0

    def add(self, record: TrialRecord) -> None:
        """Take one record; write a shard if it is time."""
        self._rows.append({"cell": self._cell_index[tuple(record.cell.values())], **_row(record)})
        if len(self._rows) >= self._shard_rows or time.monotonic() - self._written_at >= self._shard_seconds:
            self.flush()

    def flush(self) -> None:
        """Write what has been collected; now and then join what has become many shards."""
        rows, self._rows = self._rows, []  # first, so that an interrupted flush never writes a row twice
        if rows:
            table = pa.Table.from_pylist(rows, schema=self._schema)
            write_atomic(self._folder / f"rows-{uuid4().hex}.parquet", lambda draft: pq.write_table(table, draft))
            self._shards += 1
            if self._shards % MANY == 0:
                join_small_shards(self._folder)
        self._written_at = time.monotonic()


def read_shards(folder: Path, columns: Sequence[str] | None = None) -> Iterator[pa.Table]:
    """Read the shards of a folder one after the other, each row once; what is no complete Parquet file is left out."""
    for shard in live_shards(folder):
        table = _read_shard(shard.path, columns)
        if table is None:
            _log.warning("%s is damaged; its rows count as not there", shard.path)
        else:
            yield table


def set_aside_partial_shards(folder: Path) -> None:
    """Hide what is no complete Parquet file behind a leading point, so that all others read as one table."""
    for path in sorted(folder.glob("*.parquet")):
        if _read_shard(path, ("cell", "seed")) is None:
            _log.warning("%s is no complete Parquet file; set aside, its trials run again", path)
            path.replace(path.with_name(f".{path.name}.broken"))


def finished_trials(study: Study, seeds: Sequence[int], folder: Path) -> BoolArray:
    """Tell which trials have a row, shape (seeds, cells)."""
    finished = np.zeros((len(seeds), len(study.cells)), dtype=np.bool_)
    order = np.argsort(np.asarray(seeds), kind="stable")
    ascending = np.asarray(seeds)[order]
    for table in read_shards(folder, ("cell", "seed")):
        cell, seed = (table.column(name).to_numpy() for name in ("cell", "seed"))
        place = np.minimum(np.searchsorted(ascending, seed), len(seeds) - 1)
        asked = ascending[place] == seed
        finished[order[place[asked]], cell[asked]] = True
    return finished


def sorted_rows(tables: Iterable[pa.Table]) -> pa.Table:
    """Join shards to one table in the order (cell, seed), whatever order they were computed in.

    Raises:
        StudyError: If a trial has two rows, as after two runs into one folder at the same time.
    """
    table = pa.concat_tables(tables).sort_by([("cell", "ascending"), ("seed", "ascending")])
    cell, seed = (table.column(name).to_numpy() for name in ("cell", "seed"))
    twice = np.flatnonzero((np.diff(cell) == 0) & (np.diff(seed) == 0))
    if twice.size:
        where = {"cell": int(cell[twice[0]]), "seed": int(seed[twice[0]])}
        raise StudyError(f"{twice.size} trials stand twice, the first with {where}", repeated=int(twice.size), **where)
    return table


def stable_columns(table: pa.Table) -> pa.Table:
    """Drop the columns in which two runs of the same trials may differ: run time and versions."""
    return table.drop_columns([name for name in VOLATILE_COLUMNS if name in table.column_names])


def failures_by_kind(table: pa.Table) -> dict[str, int]:
    """Count the failed trials of each kind, by name."""
    counts = pc.value_counts(pc.drop_null(table.column("failure_kind"))).to_pylist()
    return {entry["values"]: entry["counts"] for entry in sorted(counts, key=lambda entry: entry["values"])}


def _row(record: TrialRecord) -> dict[str, object]:
    failure = record.failure
    return {
        "study": record.study,
        **record.cell,
        "seed": record.seed,
        **record.metrics,
        "failure_kind": failure and failure.kind,
        "failure_message": failure and failure.message,
        "failure_numbers": failure and failure.numbers,
        "runtime_s": record.runtime_s,
        "versions": record.versions,
    }


def _factor_type(values: Sequence[CellValue]) -> pa.DataType:
    types = {type(value) for value in values} - {type(None)}
    known: Mapping[type, pa.DataType] = {str: pa.string(), bool: pa.bool_(), int: pa.int64()}
    return known[types.pop()] if len(types) == 1 and not types & {float} else pa.float64()


def _read_shard(path: Path, columns: Sequence[str] | None) -> pa.Table | None:
    try:
        with pq.ParquetFile(path) as file:
            return file.read(columns=list(columns) if columns else None).replace_schema_metadata(None)
    except (pa.ArrowInvalid, OSError):
        return None
