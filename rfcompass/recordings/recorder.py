"""From a source of reads to a trace on the disk, with bounded memory and nothing lost on the way."""

import json
import logging
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol, runtime_checkable

from rfcompass.errors import InputError, NothingRecorded, RfCompassError, TraceError
from rfcompass.interfaces import ReadSource
from rfcompass.recordings.carriage import Carriage, StillAntennas
from rfcompass.recordings.spool import SPOOL_SUFFIX, SpoolWriter, check_no_spool, spooled_meta
from rfcompass.recordings.spool_trace import SpoolSummary, trace_from_spool
from rfcompass.recordings.trace_meta import TraceMeta
from rfcompass.recordings.trace_store import check_trace_target

_log = logging.getLogger(__name__)


@runtime_checkable
class CountingSource(ReadSource, Protocol):
    """A source that counts what happened on the way, as live ones do."""

    def counts(self) -> Mapping[str, object]:
        """Counts so far, ready to be stored as JSON."""
        ...


@dataclass(frozen=True, slots=True)
class Recording:
    """What became of a recording.

    Attributes:
        path: The trace.
        reads: Number of reads in it.
        epcs: Tags that were heard.
        counts: What was counted on the way; `written` and, by reason, `dropped`. Also stored in the trace's `meta.json`
            under `recording`.
    """

    path: Path
    reads: int
    epcs: tuple[str, ...]
    counts: Mapping[str, object]


def record(
    source: ReadSource,
    path: str | Path,
    *,
    meta: Callable[[], TraceMeta] | TraceMeta,
    carriage: Callable[[], Carriage] | None = None,
    overwrite: bool = False,
    progress: Callable[[int], object] | None = None,
) -> Recording:
    """Write all reads of a source into a trace.

    Reads go to a spool beside the trace as they come, and into the trace, all of it or nothing, when the source ends.
    If the source fails after it gave reads, these become the trace, and the error is one of its counts; if somebody
    interrupts, likewise. Should the process die, the spool stays, and `import_spool` makes a trace of it.

    Args:
        source: Where the reads come from.
        path: Trace folder to create.
        meta: How to interpret the reads. If a function, it is called when the first reads are there, since only then
            a live reader has said what it is.
        carriage: Gives where the antennas were; called in the end, when a carrier has written its log. Still antennas
            at the origin if None.
        overwrite: Replace a trace that is already there.
        progress: Called with the number of reads after each batch.

    Raises:
        TraceError: If something is there that must not be replaced, the disk refuses, or the carriage is unusable; in
            the last case the spool stays.
        NothingRecorded: If no read could be kept; carries the counts.
        ReaderError: If a live source failed before it gave a read.
    """
    target = Path(path).resolve()
    check_trace_target(target, overwrite=overwrite)
    spool = target.with_name(target.name + SPOOL_SUFFIX)
    check_no_spool(spool)
    failure = _fill(source, spool, meta, progress)
    counts = dict(source.counts()) if isinstance(source, CountingSource) else {}
    if failure is not None:
        counts["ended"] = failure
    if not spool.exists():
        raise NothingRecorded(_nothing(counts), **counts)
    return _finish(spool, target, _placed_by(carriage, spool), counts)


def _placed_by(carriage: Callable[[], Carriage] | None, spool: Path) -> Carriage:
    try:
        return StillAntennas() if carriage is None else carriage()
    except InputError as error:
        message = f"{error.message}; the reads are kept in {spool}"
        raise TraceError(message, **error.numbers, spool=str(spool)) from error


def _finish(spool: Path, target: Path, carriage: Carriage, counts: Mapping[str, object]) -> Recording:
    """Make a trace of a spool, and remove the spool."""
    told = dict(counts)

    def describe(summary: SpoolSummary) -> TraceMeta:
        told["dropped"] = {**_dropped(told), **({"no_place": summary.unplaced} if summary.unplaced else {})}
        told["written"] = summary.reads
        if not summary.reads:
            raise NothingRecorded(f"{_nothing(told)}; the reads are kept in {spool}", spool=str(spool), **told)
        meta = spooled_meta(spool)
        return replace(meta, unknown_json=json.dumps({**json.loads(meta.unknown_json), "recording": told}))

    summary = trace_from_spool(spool, target, carriage, describe)
    shutil.rmtree(spool)
    _log.info("wrote %d reads to %s", summary.reads, target)
    return Recording(target, summary.reads, summary.epcs, told)


def _fill(
    source: ReadSource,
    spool: Path,
    meta: Callable[[], TraceMeta] | TraceMeta,
    progress: Callable[[int], object] | None,
) -> str | None:
    """Write all reads to the spool, which is made for the first of them; how it ended, if not by itself."""
    writer: SpoolWriter | None = None
    try:
        for batch in source:
            if writer is None:
                writer = SpoolWriter(spool, meta() if callable(meta) else meta)
            writer.write(batch)
            if progress is not None:
                progress(writer.reads)
    except KeyboardInterrupt:
        return "stopped"
    except RfCompassError as error:
        if writer is None:
            raise
        _log.warning("the recording ends early: %s", error.message)
        return f"{error.kind}: {error.message}"
    finally:
        if writer is not None:
            writer.close()
    return None


def _dropped(counts: Mapping[str, object]) -> dict[str, object]:
    dropped = counts.get("dropped", {})
    return dict(dropped) if isinstance(dropped, Mapping) else {}


def _nothing(counts: Mapping[str, object]) -> str:
    dropped = ", ".join(f"{reason} {count}" for reason, count in _dropped(counts).items())
    return f"no read could be kept (received: {counts.get('received', 'unknown')}, dropped: {dropped or 'none'})"
