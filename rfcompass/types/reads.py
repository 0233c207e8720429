"""What a reader hears: single reads, one tag's reads of a scan, and the scan.

Phase convention of the whole project: a record never holds a reader's raw phase, but the complex channel

    h(f, p) = a(f, p) · exp(-j 2π f d / c),        d = round trip antenna → tag → antenna [m],

as in [Boroushaki2023], Eq. 1. Loaders remove the reader's sign convention (`phase_sign` of a trace).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from rfcompass.arrays import BoolArray, ComplexArray, FloatArray, IntArray, read_only
from rfcompass.errors import ShapeError, TagNeverHeard
from rfcompass.types.record import Record, frozen_mapping


@dataclass(frozen=True, slots=True)
class TagRead(Record):
    """One line of a reader's report, in SI units.

    `phase_rad` is the raw phase of the reader. What a source does not report is None.

    Attributes:
        epc: EPC of the tag, lower-case hex.
        antenna: Receiving port.
        freq_hz: Carrier frequency [Hz].
        rssi_dbm: Received power [dBm].
        phase_rad: Raw phase, in the reader's own sign convention [rad].
        pose_id: Number of the antenna pose.
        t_ns: Host time of arrival, UTC [ns].
        doppler_hz: Doppler shift as reported [Hz].
        tx_antenna: Transmitting port of a bistatic rig.
        i: Real part of the complex channel h, in the project's sign convention; a software radio reports it.
        q: Its imaginary part.
        t_reader_us: The reader's own clock, UTC as the reader believes [µs].
        channel_index: Number of the carrier in the reader's frequency table, from 1.
    """

    epc: str
    antenna: int
    freq_hz: float
    rssi_dbm: float
    phase_rad: float
    pose_id: int = 0
    t_ns: int | None = None
    doppler_hz: float | None = None
    tx_antenna: int | None = None
    i: float | None = None
    q: float | None = None
    t_reader_us: int | None = None
    channel_index: int | None = None


@dataclass(frozen=True, slots=True)
class ReadTrace(Record):
    """All reads of one tag in one scan, averaged over each cell (antenna position m, frequency f).

    Attributes:
        epc: EPC of the tag.
        antenna_positions_m: Receiving antenna at each position, in the scan's frame [m], shape (M, 3).
        frequencies_hz: Carrier frequencies, ascending [Hz], shape (F,).
        channel: Mean complex channel h of each cell, 0 where nothing was heard, shape (M, F).
        read_counts: Number of reads in each cell, shape (M, F).
        antenna_ports: Reader port of each position; phase constants differ between ports, shape (M,).
        tx_positions_m: Transmitting antenna of a bistatic rig [m], shape (M, 3); None when monostatic.
        phase_modulus_rad: 2π, or π for readers that report the phase with a half-turn ambiguity.
    """

    epc: str
    antenna_positions_m: FloatArray
    frequencies_hz: FloatArray
    channel: ComplexArray
    read_counts: IntArray
    antenna_ports: IntArray
    tx_positions_m: FloatArray | None = None
    phase_modulus_rad: float = 2.0 * np.pi

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they belong together."""
        M, F = np.shape(self.antenna_positions_m)[0], np.size(self.frequencies_hz)
        name = f"ReadTrace[{self.epc}]"
        set_ = object.__setattr__
        set_(self, "antenna_positions_m", read_only(self.antenna_positions_m, f"{name}.antenna_positions_m", (M, 3)))
        set_(self, "frequencies_hz", read_only(self.frequencies_hz, f"{name}.frequencies_hz", (F,)))
        set_(self, "channel", read_only(self.channel, f"{name}.channel", (M, F), np.complex128))
        set_(self, "read_counts", read_only(self.read_counts, f"{name}.read_counts", (M, F), np.int64))
        set_(self, "antenna_ports", read_only(self.antenna_ports, f"{name}.antenna_ports", (M,), np.int64))
        if self.tx_positions_m is not None:
            set_(self, "tx_positions_m", read_only(self.tx_positions_m, f"{name}.tx_positions_m", (M, 3)))
        self._check_values(name)

    def _check_values(self, name: str) -> None:
        if (self.frequencies_hz <= 0).any() or (np.diff(self.frequencies_hz) <= 0).any():
            raise ShapeError(f"{name}.frequencies_hz: must be positive and ascending", name=name)
        if (self.read_counts < 0).any() or (self.channel[self.read_counts == 0] != 0).any():
            raise ShapeError(f"{name}: a cell without reads must hold channel 0", name=name)
        if not np.isclose(self.phase_modulus_rad, (np.pi, 2 * np.pi)).any():
            raise ShapeError(f"{name}.phase_modulus_rad: {self.phase_modulus_rad} is neither pi nor 2 pi", name=name)

    @property
    def mask(self) -> BoolArray:
        """True where the tag was heard, shape (M, F)."""
        return np.asarray(self.read_counts > 0)

    @property
    def reads(self) -> int:
        """Number of reads behind this record."""
        return int(self.read_counts.sum())

    def then(self, later: "ReadTrace") -> "ReadTrace":
        """Reads of the same tag at the same place, along one way after another.

        Raises:
            ShapeError: If they are of two tags, or of two kinds of reader.
        """
        pair = (self, later)
        if self.epc != later.epc:
            raise ShapeError(f"ReadTrace[{self.epc}]: then {later.epc}", name="epc")
        if self.phase_modulus_rad != later.phase_modulus_rad:
            raise ShapeError(f"ReadTrace[{self.epc}]: phases of two moduli", name="phase_modulus_rad")
        if (self.tx_positions_m is None) != (later.tx_positions_m is None):
            raise ShapeError(f"ReadTrace[{self.epc}]: monostatic and bistatic", name="tx_positions_m")
        frequencies_hz = np.union1d(self.frequencies_hz, later.frequencies_hz)
        columns = [np.searchsorted(frequencies_hz, of.frequencies_hz) for of in pair]
        M = [len(of.antenna_positions_m) for of in pair]
        channel = np.zeros((sum(M), frequencies_hz.size), dtype=np.complex128)
        read_counts = np.zeros(channel.shape, dtype=np.int64)
        for first, of, column in zip((0, M[0]), pair, columns, strict=True):
            rows = np.arange(first, first + len(of.antenna_positions_m))[:, None]
            channel[rows, column], read_counts[rows, column] = of.channel, of.read_counts
        sent_m = [of.tx_positions_m for of in pair if of.tx_positions_m is not None]
        return replace(
            self,
            antenna_positions_m=np.concatenate([of.antenna_positions_m for of in pair]),
            frequencies_hz=frequencies_hz,
            channel=channel,
            read_counts=read_counts,
            antenna_ports=np.concatenate([of.antenna_ports for of in pair]),
            tx_positions_m=np.concatenate(sent_m) if sent_m else None,
        )

    def round_trip_m(self, points_m: FloatArray) -> FloatArray:
        """Length antenna → point → antenna for each point and antenna position [m], shape (P, M).

        Args:
            points_m: Points in the scan's frame [m], shape (P, 3).
        """
        rx = np.linalg.norm(points_m[:, None, :] - self.antenna_positions_m[None, :, :], axis=2)
        if self.tx_positions_m is None:
            return np.asarray(2.0 * rx)
        return np.asarray(rx + np.linalg.norm(points_m[:, None, :] - self.tx_positions_m[None, :, :], axis=2))


@dataclass(frozen=True, slots=True)
class Scan(Record):
    """Everything heard at one stop, by EPC.

    Attributes:
        traces: One `ReadTrace` for each tag that was heard.
        frame: Name of the frame of all antenna positions.
        dimensions: 2 if tags and antennas share one plane (z is not observable), else 3.
        heights_m: Height of each tag whose height is known otherwise, by EPC: z in the same frame [m].
    """

    traces: Mapping[str, ReadTrace] = field(default_factory=dict)
    frame: str = "antenna"
    dimensions: int = 3
    heights_m: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Freeze the mappings."""
        for epc, trace in self.traces.items():
            if epc != trace.epc:
                raise ShapeError(f"Scan.traces: key {epc} holds the trace of {trace.epc}", epc=epc)
        if self.dimensions not in (2, 3):
            raise ShapeError(f"Scan.dimensions: {self.dimensions} is neither 2 nor 3", dimensions=self.dimensions)
        for epc, height_m in self.heights_m.items():
            if not np.isfinite(height_m):
                raise ShapeError(f"Scan.heights_m: {height_m} for tag {epc} is not finite", epc=epc)
        object.__setattr__(self, "traces", frozen_mapping(self.traces))
        object.__setattr__(self, "heights_m", frozen_mapping(self.heights_m))

    @property
    def epcs(self) -> tuple[str, ...]:
        """EPCs heard, sorted."""
        return tuple(sorted(self.traces))

    def trace(self, epc: str) -> ReadTrace:
        """Return one tag's reads.

        Raises:
            TagNeverHeard: If the scan holds no read of `epc`; lists the tags that were heard.
        """
        if epc not in self.traces:
            heard = ", ".join(self.epcs) or "none"
            raise TagNeverHeard(f"tag {epc} was never heard (heard: {heard})", epc=epc, heard=list(self.epcs))
        return self.traces[epc]
