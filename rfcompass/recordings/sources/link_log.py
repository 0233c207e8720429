"""What happened on the way from a live reader to us, counted while it happens."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from rfcompass.types.reads import TagRead

# How many outages are kept one by one; beyond that only their number and length are (ours).
_KEPT_GAPS = 100


@dataclass(frozen=True, slots=True)
class Gap:
    """A time without a link.

    Attributes:
        start_ns: Host time of the last report before it, UTC [ns].
        end_ns: Host time at which the reader read again, or we gave up, UTC [ns].
        reason: Why the link went down.
    """

    start_ns: int
    end_ns: int
    reason: str


@dataclass(slots=True)
class LinkLog:
    """Counts of one live source.

    Attributes:
        received: Reads that arrived, whatever became of them.
        dropped: Reads that could not be used, by reason.
        connections: Times the inventory was started.
        malformed_frames: Frames that were no LLRP; each costs a connection.
        reader_overflows: Times the reader reported that its own buffer overflowed: it lost reads.
        merged_reads: Further reads that the reader merged into one report.
        reader_clock_backwards: Times the reader's clock ran backwards between two reads.
        host_clock_backwards: Times our own did.
        gaps: The first outages, one by one.
        gap_count: Number of all outages.
        gap_s: Their total length [s].
    """

    received: int = 0
    dropped: Counter[str] = field(default_factory=Counter)
    connections: int = 0
    malformed_frames: int = 0
    reader_overflows: int = 0
    merged_reads: int = 0
    reader_clock_backwards: int = 0
    host_clock_backwards: int = 0
    gaps: list[Gap] = field(default_factory=list)
    gap_count: int = 0
    gap_s: float = 0.0
    _last: TagRead | None = None

    def note_read(self, read: TagRead) -> None:
        """Compare both clocks of a read with those of the one before; it is kept in any case."""
        last, self._last = self._last, read
        if last is None:
            return
        self.host_clock_backwards += _runs_backwards(last.t_ns, read.t_ns)
        self.reader_clock_backwards += _runs_backwards(last.t_reader_us, read.t_reader_us)

    def note_gap(self, gap: Gap) -> None:
        """Count an outage that is over."""
        self.gap_count += 1
        self.gap_s += (gap.end_ns - gap.start_ns) / 1e9
        if len(self.gaps) < _KEPT_GAPS:
            self.gaps.append(gap)

    def as_json(self) -> Mapping[str, object]:
        """All counts, ready to be stored beside the reads."""
        return {
            "received": self.received,
            "dropped": dict(sorted(self.dropped.items())),
            "connections": self.connections,
            "reconnects": max(self.connections - 1, 0),
            "gap_count": self.gap_count,
            "gap_s": round(self.gap_s, 3),
            "gaps": [{"start_ns": gap.start_ns, "end_ns": gap.end_ns, "reason": gap.reason} for gap in self.gaps],
            "malformed_frames": self.malformed_frames,
            "reader_overflows": self.reader_overflows,
            "merged_reads": self.merged_reads,
            "reader_clock_backwards": self.reader_clock_backwards,
            "host_clock_backwards": self.host_clock_backwards,
        }


def _runs_backwards(before: int | None, after: int | None) -> bool:
    return before is not None and after is not None and after < before
