"""When a read arrived, also if nobody looked: the reader's clock tells apart reads that waited in the system's buffer.

Each host time t must lie between the moment at which nothing was waiting, t_e, and now, t_n. With the reader's clock c
and the latest known difference o between the clocks,

    t = min(max(c + o, t_e), t_n),        o := t - c.

While the consumer is quick, t_e = t_n: t is the time of arrival and o is measured anew with every read. After it was
busy, o spreads the reads over the time that it was away. A clock of the reader that is wrong does not matter, since
only differences count; one that drifts or jumps puts t at a bound, which is never worse than now.
"""

from dataclasses import dataclass

# A carrier at 0.25 m/s moves by one pose spacing, 5 mm, meanwhile (ours).
PROMPT_S = 0.02


@dataclass(slots=True)
class ArrivalClock:
    """Gives reads their host time, in the order of their arrival.

    Attributes:
        offset_ns: Host clock minus reader clock at the last read [ns]; None before the first.
        last_ns: Host time of the last read, UTC [ns].
    """

    offset_ns: int | None = None
    last_ns: int = 0

    def arrival_ns(self, reader_us: int | None, now_ns: int, unread_s: float) -> int:
        """Host time at which a read arrived, UTC [ns]; now, if the reader states no time.

        Args:
            reader_us: The reader's own clock [µs].
            now_ns: Host time at which the read is taken, UTC [ns].
            unread_s: For how long it may have been waiting [s].
        """
        if reader_us is None:
            return now_ns
        away_ns = int(unread_s * 1e9) if unread_s > PROMPT_S else 0
        earliest_ns = min(max(now_ns - away_ns, self.last_ns), now_ns)
        reader_ns = 1000 * reader_us
        expected_ns = now_ns if self.offset_ns is None else reader_ns + self.offset_ns
        self.last_ns = min(max(expected_ns, earliest_ns), now_ns)
        self.offset_ns = self.last_ns - reader_ns
        return self.last_ns
