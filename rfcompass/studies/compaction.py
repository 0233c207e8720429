"""Joins many small shards to few large ones, so that a long study does not end as a hundred thousand files.

A joined shard names in its footer the shards that it replaces. It is put in place before they are removed: every row
is on the disk under a visible name at every moment, and whoever finds both after a kill knows which one counts.
"""

import json
import logging
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from uuid import uuid4

import pyarrow as pa
import pyarrow.parquet as pq

from rfcompass.files import write_atomic

# Ours: sizes at which a table reads well and still fits into any driver's memory.
JOINED_ROWS = 100_000
JOINED_BYTES = 64_000_000
MANY = 64  # small shards that may lie there before it is worth the work

_log = logging.getLogger(__name__)

_REPLACES = b"rfcompass.replaces"


@dataclass(frozen=True, slots=True)
class Shard:
    """A complete Parquet file, by its footer.

    Attributes:
        path: The file.
        rows: Number of rows.
        size_bytes: Size of the file.
        replaces: Names of the shards whose rows it holds too.
    """

    path: Path
    rows: int
    size_bytes: int
    replaces: frozenset[str]


def live_shards(folder: Path) -> list[Shard]:
    """List the complete shards whose rows count, by name: each row stands in one of them."""
    shards = [shard for path in sorted(folder.glob("*.parquet")) if (shard := _shard(path)) is not None]
    replaced = _replaced(shards)
    return [shard for shard in shards if shard.path.name not in replaced]


def remove_replaced(folder: Path) -> None:
    """Remove the shards that a killed run has joined already, but not removed any more."""
    shards = [shard for path in folder.glob("*.parquet") if (shard := _shard(path)) is not None]
    for name in _replaced(shards):
        (folder / name).unlink(missing_ok=True)


def join_small_shards(folder: Path, many: int = MANY) -> None:
    """Join the small shards of a folder if there are many; every row stays, and no file is changed in place."""
    small = [s for s in live_shards(folder) if s.rows < JOINED_ROWS / 2 and s.size_bytes < JOINED_BYTES / 2]
    if len(small) < many:
        return
    for group in _groups(small):
        _join(folder, group)
        pa.default_memory_pool().release_unused()  # or a long run would hold on to what its largest join took


def _groups(shards: Sequence[Shard]) -> Iterator[list[Shard]]:
    group: list[Shard] = []
    for shard in shards:
        joined = [*group, shard]
        if sum(s.rows for s in joined) > JOINED_ROWS or sum(s.size_bytes for s in joined) > JOINED_BYTES:
            yield group
            joined = [shard]
        group = joined
    yield group


def _join(folder: Path, group: Sequence[Shard]) -> None:
    if len(group) < 2:
        return
    try:
        table = pa.concat_tables([_read(shard.path) for shard in group])
    except (pa.ArrowInvalid, OSError) as error:
        _log.warning("left %d small shards as they are: %s", len(group), error)
        return
    names = json.dumps([shard.path.name for shard in group])
    marked = table.combine_chunks().replace_schema_metadata({_REPLACES: names})
    write_atomic(folder / f"rows-{uuid4().hex}.parquet", lambda draft: pq.write_table(marked, draft))
    for shard in group:
        shard.path.unlink()


def _read(path: Path) -> pa.Table:
    with pq.ParquetFile(path) as file:
        return file.read().replace_schema_metadata(None)


def _replaced(shards: Sequence[Shard]) -> set[str]:
    return {name for shard in shards for name in shard.replaces}


def _shard(path: Path) -> Shard | None:
    try:
        footer = pq.read_metadata(path)
        size_bytes = path.stat().st_size
    except (pa.ArrowInvalid, OSError):
        return None
    replaces = (footer.metadata or {}).get(_REPLACES, b"[]")
    return Shard(path, footer.num_rows, size_bytes, frozenset(json.loads(replaces)))
