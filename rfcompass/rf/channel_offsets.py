"""What a reader adds to the phase of each carrier, learnt from one tag whose place is known.

A raw phase is phase_sign · k d + o(f) + a constant of the tag. With the tag at a known p the round trips d(p, a_k) are
known, and what is left of the phase, averaged over the positions a_k of the path, is the offset:

    o(f) = -phase_sign · arg Σ_k h(f, a_k) / |h(f, a_k)| · exp(+j k_f d(p, a_k)).

The tag's own constant is part of every o(f), and that of the antenna port: they are the same for all carriers and do no
harm. Of several ports the one with the most reads is taken. Phases that are known modulo π give offsets modulo π.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError, NotFocused, TooFewReads
from rfcompass.rf.runs import runs
from rfcompass.rf.waves import wavenumber
from rfcompass.types.reads import ReadTrace
from rfcompass.types.record import Record

# Ours. With M positions, phases that have nothing to do with the place agree to about 1/√M; on measured sweeps of one
# metre tags at their taped places agree to 0.6 to 0.95.
LEAST_AGREEMENT = 0.4
LEAST_POSITIONS = 8


@dataclass(frozen=True, slots=True)
class ChannelOffsets(Record):
    """Offsets of a reader's carriers, as a trace's `channel_offsets_rad` holds them.

    Attributes:
        frequencies_hz: Carriers on which the tag was heard, ascending [Hz], shape (F,).
        offsets_rad: What the reader adds to the raw phase, in [0, 2π), or [0, π) for half-turn phases [rad], shape
            (F,).
        agreement: How well the positions of the path agree, between 0 and 1, shape (F,).
    """

    frequencies_hz: FloatArray
    offsets_rad: FloatArray
    agreement: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for name in ("frequencies_hz", "offsets_rad", "agreement"):
            value = read_only(getattr(self, name), f"ChannelOffsets.{name}", np.shape(self.frequencies_hz))
            object.__setattr__(self, name, value)

    def as_pairs(self) -> tuple[tuple[float, float], ...]:
        """Pairs (frequency [Hz], offset [rad]), as a trace's meta takes them."""
        return tuple(zip(self.frequencies_hz.tolist(), self.offsets_rad.tolist(), strict=True))


def channel_offsets(trace: ReadTrace, point_m: FloatArray, phase_sign: int = 1) -> ChannelOffsets:
    """Learn the offsets from the reads of one tag at a known place.

    Offsets that the trace has taken out already are not seen again: calibrate a trace that has none.

    Args:
        trace: Reads of the tag.
        point_m: Where it is, in the frame of the antenna path [m], shape (3,).
        phase_sign: +1 if the reader's raw phase grows with distance, else -1.

    Raises:
        InputError: If `phase_sign` is neither.
        TooFewReads: If no carrier was heard at eight positions.
        NotFocused: If the phases do not fit a tag at that place; carries the mean `agreement`.
    """
    if phase_sign not in (1, -1):
        raise InputError(f"phase_sign is {phase_sign!r}, neither 1 nor -1", phase_sign=phase_sign)
    point = read_only(point_m, "point_m", (3,))
    turns = round(2.0 * np.pi / trace.phase_modulus_rad)
    rows = max(runs(trace), key=lambda run: int(trace.mask[run].sum()))
    h, heard = trace.channel[rows], trace.mask[rows].sum(axis=0)
    used = np.flatnonzero(heard >= LEAST_POSITIONS)
    if not used.size:
        message = f"tag {trace.epc}: no carrier was heard at {LEAST_POSITIONS} positions"
        raise TooFewReads(message, epc=trace.epc, reads=int(heard.max(initial=0)), needed=LEAST_POSITIONS)
    size = np.abs(h)
    unit = np.divide(h, size, out=np.zeros_like(h), where=size > 0) ** turns
    lags = turns * np.outer(trace.round_trip_m(point[None])[0, rows], wavenumber(trace.frequencies_hz))
    mean = (unit * np.exp(1j * lags)).sum(axis=0)[used] / heard[used]
    if (agreement := float(np.abs(mean).mean())) < LEAST_AGREEMENT:
        message = f"tag {trace.epc}: its phases do not fit a tag at {point.tolist()} m (agreement {agreement:.2f})"
        raise NotFocused(message, epc=trace.epc, agreement=agreement, needed=LEAST_AGREEMENT)
    turn = np.mod(-phase_sign * np.angle(mean), 2.0 * np.pi)
    offsets = np.where(turn < 2.0 * np.pi, turn, 0.0) / turns  # mod of a tiny negative number is 2π
    return ChannelOffsets(trace.frequencies_hz[used], offsets, np.abs(mean))
