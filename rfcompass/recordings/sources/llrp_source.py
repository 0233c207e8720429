"""Live reads from a reader that speaks LLRP."""

import logging
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field

from llrpkit.constants import LLRP_PORT
from llrpkit.protocol import LLRPMessage, messages

from rfcompass.errors import InputError, LinkLost, MalformedFrame, ReaderError
from rfcompass.recordings.sources.arrival import ArrivalClock
from rfcompass.recordings.sources.link_log import Gap, LinkLog
from rfcompass.recordings.sources.llrp_link import LlrpLink
from rfcompass.recordings.sources.llrp_reads import read_of, reader_clock_us
from rfcompass.recordings.sources.llrp_session import (
    SILENCE_S,
    InventorySettings,
    ReaderInfo,
    prepare_inventory,
    start_inventory,
    stop_inventory,
    try_to_stop,
)
from rfcompass.types.reads import TagRead

# How long a wish to stop may go unnoticed while the reader is silent (ours).
_TICK_S = 0.2

BEFORE_START = "before_start"

_DEFAULT_SETTINGS = InventorySettings()

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Backoff:
    """How to come back to a reader that was lost.

    The n-th attempt in a row waits first_s · 2^n, at most longest_s. A read ends the row.

    Attributes:
        first_s: Wait before the first attempt [s].
        longest_s: Longest wait [s].
        patience_s: Length of an outage after which the source ends [s].
        timeout_s: How long a reader may take for each answer [s].
    """

    first_s: float = 0.5
    longest_s: float = 15.0
    patience_s: float = 60.0
    timeout_s: float = 5.0

    def __post_init__(self) -> None:
        """Check the times."""
        for name in ("first_s", "longest_s", "patience_s", "timeout_s"):
            if not getattr(self, name) > 0:
                raise InputError(f"Backoff.{name}: {getattr(self, name)} is no time", name=name)

    def wait_s(self, attempt: int) -> float:
        """Wait before attempt 0, 1, … [s]."""
        return float(min(self.longest_s, self.first_s * 2.0 ** min(attempt, 60)))


@dataclass(slots=True)
class LlrpSource:
    """A reader on the network as a `ReadSource`; it connects when it is iterated, and again after each loss.

    Frequencies come from the reader's own table. Each read carries both clocks, and pose 0: where the antenna was is
    not the reader's business. One iteration at a time; what happened on the way is in `log`. A consumer may take its
    time: reads wait for it, and get the host time of their arrival nevertheless (`ArrivalClock`).

    Attributes:
        host: Name or address of the reader.
        port: TCP port.
        antennas: Ports to read from; all of them if empty.
        duration_s: Ends this long after the first start [s]; never if None.
        max_reads: Ends once so many reads were kept, with those that are already on their way; never if None.
        settings: How the reader is asked to read.
        backoff: How to come back to it.
        clock_ns: Host time, UTC [ns].
        log: Counts, cleared by each iteration.
        info: What the reader says about itself; None before it was reached.
        ended: Why the last iteration ended: `duration`, `reads`, `stopped`, `reader_lost`, or None.
    """

    host: str
    port: int = LLRP_PORT
    antennas: Sequence[int] = ()
    duration_s: float | None = None
    max_reads: int | None = None
    settings: InventorySettings = _DEFAULT_SETTINGS
    backoff: Backoff = Backoff()
    clock_ns: Callable[[], int] = time.time_ns
    log: LinkLog = field(default_factory=LinkLog, init=False)
    info: ReaderInfo | None = field(default=None, init=False)
    ended: str | None = field(default=None, init=False)
    _arrivals: ArrivalClock = field(default_factory=ArrivalClock, init=False, repr=False)
    _heard_ns: int = field(default=0, init=False, repr=False)
    _kept: int = field(default=0, init=False, repr=False)
    _deadline_s: float | None = field(default=None, init=False, repr=False)
    _stop: threading.Event = field(default_factory=threading.Event, init=False, repr=False)

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name, value in (("duration_s", self.duration_s), ("max_reads", self.max_reads)):
            if value is not None and not value > 0:
                raise InputError(f"LlrpSource.{name}: {value} is not positive", name=name, value=value)
        if not 0 < self.port < 1 << 16:
            raise InputError(f"LlrpSource.port: {self.port} is no TCP port", port=self.port)

    def stop(self) -> None:
        """Ask the iteration, from any thread, to end politely and soon; it will not begin again."""
        self._stop.set()

    def counts(self) -> Mapping[str, object]:
        """What happened on the way, ready to be stored beside the reads."""
        return {**self.log.as_json(), "ended": self.ended}

    def __iter__(self) -> Iterator[Sequence[TagRead]]:
        """Yield reads as they arrive.

        Raises:
            LinkLost: If the reader cannot be reached at the start; later losses are its daily business.
            ReaderRefused: If the reader refuses at the start what we ask for.
        """
        self.log, self.ended, self._kept, self._deadline_s = LinkLog(), None, 0, None
        self._arrivals = ArrivalClock()
        outage = _Outage(self.backoff)
        while not self._finished():
            try:
                with closing(self._connect(outage)) as link:
                    yield from self._listen(link, outage)
            except ReaderError as error:
                self.log.malformed_frames += isinstance(error, MalformedFrame)
                if self.log.connections == 0:
                    raise
                if not self._wait(outage, error):
                    self.ended = "reader_lost"
        if (gap := outage.over(self.clock_ns())) is not None:
            self.log.note_gap(gap)

    def _connect(self, outage: "_Outage") -> LlrpLink:
        link = LlrpLink(self.host, self.port, self.backoff.timeout_s)
        try:
            self.info = prepare_inventory(link, self.settings, tuple(self.antennas))
            self._drop_foreign(link.receive(0.0))
            start_inventory(link)
        except BaseException:
            link.close()
            raise
        self.log.connections += 1
        self._heard_ns = self.clock_ns()
        if (gap := outage.over(self._heard_ns)) is not None:
            self.log.note_gap(gap)
            _log.info("%s reads again after %.1f s", self.host, (gap.end_ns - gap.start_ns) / 1e9)
        if self._deadline_s is None and self.duration_s is not None:
            self._deadline_s = time.monotonic() + self.duration_s
        return link

    def _drop_foreign(self, arrived: Sequence[LLRPMessage]) -> None:
        """Drop reports of an inventory that was not ours."""
        for message in arrived:
            if isinstance(message, messages.RO_ACCESS_REPORT):
                self.log.received += len(message.tag_report_datas)
                self.log.dropped[BEFORE_START] += len(message.tag_report_datas)

    def _listen(self, link: LlrpLink, outage: "_Outage") -> Iterator[Sequence[TagRead]]:
        """Yield reads until it is time to end, then stop the reader and yield what was still on its way."""
        try:
            while not self._finished():
                unread_s = link.unread_s
                arrived = link.receive(self._tick_s())
                # Only now: while the consumer was busy it was not the reader that was silent.
                if not arrived and link.silent_s > SILENCE_S:
                    raise LinkLost(f"{self.host} has been silent for {link.silent_s:.1f} s", host=self.host)
                if batch := self._reads(arrived, unread_s):
                    outage.attempts = 0
                    yield batch
        except GeneratorExit:  # the consumer has gone
            try_to_stop(link)
            raise
        yield from self._farewell(link)

    def _farewell(self, link: LlrpLink) -> Iterator[Sequence[TagRead]]:
        """Stop the reader; a reader that is lost now has no more to say than what has arrived."""
        unread_s = link.unread_s
        try:
            stop_inventory(link)
        except ReaderError as error:
            _log.info("the reader was not stopped: %s", error.message)
        try:
            while messages_left := link.receive(0.0):
                if batch := self._reads(messages_left, unread_s):
                    yield batch
                unread_s = link.unread_s
        except LinkLost:
            return

    def _reads(self, arrived: Sequence[LLRPMessage], unread_s: float) -> Sequence[TagRead]:
        now_ns, reads = self.clock_ns(), list[TagRead]()
        self._heard_ns = now_ns if arrived else self._heard_ns
        for message in arrived:
            if isinstance(message, messages.RO_ACCESS_REPORT):
                reads += self._kept_reads(message, now_ns, unread_s)
            elif isinstance(message, messages.READER_EVENT_NOTIFICATION):
                event = message.reader_event_notification_data
                self.log.reader_overflows += event.report_buffer_overflow_error_event is not None
        self._kept += len(reads)
        return reads

    def _kept_reads(self, message: messages.RO_ACCESS_REPORT, now_ns: int, unread_s: float) -> list[TagRead]:
        reads, frequencies_hz = [], self.info.frequencies_hz if self.info is not None else ()
        for report in message.tag_report_datas:
            self.log.received += 1
            if report.tag_seen_count is not None:
                self.log.merged_reads += max(report.tag_seen_count.tag_count - 1, 0)
            t_ns = self._arrivals.arrival_ns(reader_clock_us(report), now_ns, unread_s)
            read = read_of(report, frequencies_hz, t_ns)
            if isinstance(read, str):
                self.log.dropped[read] += 1
            else:
                self.log.note_read(read)
                reads.append(read)
        return reads

    def _finished(self) -> bool:
        if self._stop.is_set():
            self.ended = "stopped"
        elif self._deadline_s is not None and time.monotonic() >= self._deadline_s:
            self.ended = "duration"
        elif self.max_reads is not None and self._kept >= self.max_reads:
            self.ended = "reads"
        return self.ended is not None

    def _tick_s(self) -> float:
        if self._deadline_s is None:
            return _TICK_S
        return min(_TICK_S, max(self._deadline_s - time.monotonic(), 0.0))

    def _wait(self, outage: "_Outage", lost: ReaderError) -> bool:
        """Wait for the next attempt; False if there will be none."""
        outage.begin(self._heard_ns, lost.message)
        wait_s = outage.next_wait_s()
        if wait_s is None:
            return False
        _log.warning("%s; trying again in %.1f s", lost.message, wait_s)
        if self._deadline_s is not None:
            wait_s = min(wait_s, max(self._deadline_s - time.monotonic(), 0.0))
        self._stop.wait(wait_s)
        return True


@dataclass(slots=True)
class _Outage:
    """The present outage, and how many attempts in a row brought no read."""

    backoff: Backoff
    attempts: int = 0
    start_ns: int | None = None
    start_s: float = 0.0
    reason: str = ""

    def begin(self, now_ns: int, reason: str) -> None:
        """Note a loss; an outage that goes on keeps its start."""
        if self.start_ns is None:
            self.start_ns, self.start_s, self.reason = now_ns, time.monotonic(), reason

    def over(self, now_ns: int) -> Gap | None:
        """Note that the reader reads again; the gap, if there was one."""
        if self.start_ns is None:
            return None
        gap, self.start_ns = Gap(self.start_ns, now_ns, self.reason), None
        return gap

    def next_wait_s(self) -> float | None:
        """Wait before the next attempt [s], None once patience has ended."""
        left_s = self.start_s + self.backoff.patience_s - time.monotonic()
        wait_s = self.backoff.wait_s(self.attempts)
        self.attempts += 1
        return min(wait_s, left_s) if left_s > 0 else None
