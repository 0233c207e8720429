"""Reads that are there already, handed out like those of a live reader."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.errors import InputError
from rfcompass.recordings.trace import Trace
from rfcompass.types.reads import TagRead

# As many reads as a fast reader reports in about a second (ours).
BATCH_READS = 512

# Columns of `reads.parquet` that are fields of a read.
_MANDATORY = ("epc", "antenna", "freq_hz", "rssi_dbm", "phase_rad", "pose_id")
_OPTIONAL = ("t_ns", "doppler_hz", "tx_antenna", "i", "q", "t_reader_us", "channel_index")


@dataclass(frozen=True, slots=True, kw_only=True)
class Pace:
    """When a replay hands out its reads.

    Attributes:
        reads_per_s: Rate [1/s]; as fast as they are taken if None.
    """

    reads_per_s: float | None = None

    def __post_init__(self) -> None:
        """Check the rate."""
        if self.reads_per_s is not None and not 0 < self.reads_per_s < np.inf:
            raise InputError(f"{self.reads_per_s} reads per second is no rate", reads_per_s=self.reads_per_s)

    def batch_reads(self, asked: int) -> int:
        """Reads in one batch: no more than come within a tenth of a second."""
        return asked if self.reads_per_s is None else max(1, min(asked, int(self.reads_per_s / 10.0)))

    def wait(self, reads: int, start_s: float) -> None:
        """Sleep until so many reads are due after a start on the monotonic clock [s]."""
        if self.reads_per_s is not None:
            time.sleep(max(0.0, start_s + reads / self.reads_per_s - time.monotonic()))


@dataclass(frozen=True, slots=True)
class SequenceSource:
    """A sequence of reads as a `ReadSource`: what a simulator heard, or a list made by hand.

    Attributes:
        reads: In the order of their arrival.
        batch_reads: Largest number of reads in one batch.
        pace: When they are handed out.
    """

    reads: Sequence[TagRead]
    batch_reads: int = BATCH_READS
    pace: Pace = Pace()

    def __post_init__(self) -> None:
        """Check the size of a batch."""
        if self.batch_reads < 1:
            raise InputError(f"a batch of {self.batch_reads} reads is none", batch_reads=self.batch_reads)

    def __iter__(self) -> Iterator[Sequence[TagRead]]:
        """Yield all reads in batches, from the first one on at each call."""
        size, start_s = self.pace.batch_reads(self.batch_reads), time.monotonic()
        for first in range(0, len(self.reads), size):
            batch = self.reads[first : first + size]
            self.pace.wait(first + len(batch), start_s)
            yield batch


@dataclass(frozen=True, slots=True)
class TraceSource:
    """The reads of a trace as a `ReadSource`, in the order of its file.

    A trace that holds I/Q only gives reads whose power and phase follow from it, with the trace's own `phase_sign`.

    Attributes:
        trace: Where the reads come from.
        batch_reads: Largest number of reads in one batch.
        pace: When they are handed out.
    """

    trace: Trace
    batch_reads: int = BATCH_READS
    pace: Pace = Pace()

    def __iter__(self) -> Iterator[Sequence[TagRead]]:
        """Yield all reads in batches, from the first one on at each call."""
        size, start_s, count = self.pace.batch_reads(self.batch_reads), time.monotonic(), 0
        for first in range(0, self.trace.reads.num_rows, size):
            batch = self._batch(first, size)
            count += len(batch)
            self.pace.wait(count, start_s)
            yield batch

    def _batch(self, first: int, size: int) -> tuple[TagRead, ...]:
        table = self.trace.reads.slice(first, size)
        columns = {name: table[name].to_pylist() for name in (*_MANDATORY, *_OPTIONAL) if name in table.column_names}
        if "rssi_dbm" not in columns or "phase_rad" not in columns:
            columns.update(_power_and_phase(columns, self.trace.meta.phase_sign))
        names = tuple(columns)
        return tuple(TagRead(**dict(zip(names, row, strict=True))) for row in zip(*columns.values(), strict=True))


def _power_and_phase(columns: dict[str, list[float]], phase_sign: int) -> dict[str, list[float]]:
    h = np.array(columns["i"]) + 1j * np.array(columns["q"])
    phase_rad = (-phase_sign * np.angle(h)) % (2.0 * np.pi)
    return {"rssi_dbm": (20.0 * np.log10(np.abs(h))).tolist(), "phase_rad": phase_rad.tolist()}
