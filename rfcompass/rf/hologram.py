"""Hologram of one tag: the power of the matched filter at any point of a search volume [Boroushaki2023], Eq. 1.

    P(p) = Σ_looks | Σ_i Σ_k h(f_i, a_k) exp(+j 2π f_i d(p, a_k) / c) |²,      d = round trip antenna → p → antenna.

A look is a sum that keeps its phase. The paper has one look, over all frequencies i and positions k. A commercial
reader adds an unknown constant for each tag, channel and port; then each channel of each run is a look of its own, and
only their powers add up. The differential hologram replaces the square by products of neighbouring positions,

    P(p) = Σ_looks Re Σ_k w_(k+1) w_k*,      w_k = h(f, a_k) exp(+j 2π f d(p, a_k) / c),

which forgives reflections that turn the phase slowly along the path.

Deviations:
    [Boroushaki2023] prints the complex sum and calls it a probability; we square it, so that 0.84 of the peak is the
    paper's -0.75 dB. Where a reader knows the phase only modulo π, h is replaced by h² / |h| and f by 2 f.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import ComplexArray, FloatArray, IntArray
from rfcompass.errors import ShapeError
from rfcompass.rf.phase_kernels import PhaseRun, add_phase_power
from rfcompass.rf.runs import runs
from rfcompass.rf.sar_kernels import PhasorTable, add_differential_power, add_power
from rfcompass.rf.waves import wavenumber
from rfcompass.types.reads import ReadTrace
from rfcompass.types.volumes import SearchVolume

COLUMNS_PER_WAVELENGTH = 128  # interpolation is then good to 3e-4 of an amplitude


@dataclass(frozen=True, kw_only=True)
class Matching:
    """How the cells of a trace are combined.

    Attributes:
        coherent: Add the channels of a run as complex numbers, as the paper does. Needs a reader without phase
            constants, or one whose `channel_offsets_rad` are known.
        amplitude: Keep |h|; otherwise every cell counts 1.
        differential: Use products of neighbouring positions.
    """

    coherent: bool = False
    amplitude: bool = False
    differential: bool = False


@dataclass(frozen=True)
class Hologram:
    """Matched filter of one trace over one volume; make it with `build_hologram`.

    Attributes:
        volume: Where it can be evaluated.
        wavelength_m: Shortest wavelength of the phases; halved if they are known modulo π.
        runs: What the kernels take of each run: turns where a look is one channel, else tables.
        differential: Which of the two powers it is.
    """

    volume: SearchVolume
    wavelength_m: float
    runs: tuple[PhasorTable | PhaseRun, ...]
    differential: bool

    def power(self, points_m: FloatArray) -> FloatArray:
        """P(p) at each point [m], shape (P, 3), inside the volume; shape (P,).

        Raises:
            ShapeError: If a point lies outside the volume.
        """
        if not self.volume.contains(points_m).all():
            raise ShapeError("hologram: a point lies outside the search volume", name="points_m")
        return self.power_inside(points_m)

    def power_inside(self, points_m: FloatArray) -> FloatArray:
        """`power` of points that are known to be inside: elsewhere the tables end, and the answer is anything."""
        power = np.zeros(len(points_m), dtype=np.float32)
        for run in self.runs:
            if isinstance(run, PhaseRun):
                add_phase_power(points_m, run, power)
            elif self.differential:
                add_differential_power(points_m, run, power)
            else:
                add_power(points_m, run, power)
        return np.asarray(power, dtype=np.float64)


def build_hologram(trace: ReadTrace, volume: SearchVolume, matching: Matching) -> Hologram:
    """Make the matched filter of a trace ready for a volume.

    Args:
        trace: Reads of one tag.
        volume: Where the tag may be, in the frame of the antenna path.
        matching: How the cells are combined.
    """
    turns = round(2.0 * np.pi / trace.phase_modulus_rad)
    k = turns * wavenumber(trace.frequencies_hz)
    h = matched_phasors(trace, turns, amplitude=matching.amplitude)
    ready: Sequence[PhasorTable | PhaseRun]
    if matching.coherent or matching.differential:
        ready = [_table(trace, volume, rows, h[rows], k, coherent=matching.coherent) for rows in runs(trace)]
    else:
        ready = [_phases(trace, rows, h[rows], k) for rows in runs(trace)]
    return Hologram(volume, float(2.0 * np.pi / k.max()), tuple(ready), matching.differential)


def matched_phasors(trace: ReadTrace, turns: int, *, amplitude: bool) -> ComplexArray:
    """The channel as it is matched, shape (M, F); 0 where nothing was heard.

    Args:
        trace: Reads of one tag.
        turns: 2 raises the phase to the square and keeps the size, for phases that are known modulo π; otherwise 1.
        amplitude: Keep |h|, with 1 for the loudest cell; otherwise every cell counts 1.
    """
    size = np.abs(trace.channel)
    unit = np.divide(trace.channel, size, out=np.zeros_like(trace.channel), where=size > 0) ** turns
    return np.asarray(unit * size / size.max() if amplitude and size.any() else unit)


def _phases(trace: ReadTrace, rows: IntArray, h: ComplexArray, k: FloatArray) -> PhaseRun:
    rx_m = trace.antenna_positions_m[rows]
    tx_m = None if trace.tx_positions_m is None else trace.tx_positions_m[rows]
    origin_m = rx_m.mean(axis=0)
    still = tx_m is not None and not np.ptp(tx_m, axis=0).any()
    ways = 2.0 if tx_m is None else 1.0
    return PhaseRun(
        origin_m=origin_m,
        rx_m=(rx_m - origin_m).astype(np.float32),
        tx_m=np.zeros((0, 3), np.float32) if tx_m is None or still else (tx_m - origin_m).astype(np.float32),
        factors=np.ascontiguousarray(h.T).astype(np.complex64),
        turns_per_m=(ways * k / (2.0 * np.pi)).astype(np.float32),
    )


def _table(
    trace: ReadTrace, volume: SearchVolume, rows: IntArray, h: ComplexArray, k: FloatArray, *, coherent: bool
) -> PhasorTable:
    rx_m = trace.antenna_positions_m[rows]
    tx_m = None if trace.tx_positions_m is None else trace.tx_positions_m[rows]
    shortest_m, longest_m = _round_trip_span(volume, rx_m, rx_m if tx_m is None else tx_m)
    step_m = 2.0 * np.pi / float(k.max()) / COLUMNS_PER_WAVELENGTH
    d = shortest_m + step_m * np.arange(-1, np.ceil((longest_m - shortest_m) / step_m) + 3)
    g = np.exp(1j * np.outer(k, d))
    if coherent:
        g, factors = h @ g, np.asarray((h != 0).any(axis=1, keepdims=True).T, dtype=np.complex64)
        table_rows = np.arange(len(rows))[None, :]
    else:
        factors, table_rows = np.ascontiguousarray(h.T), np.repeat(np.arange(k.size)[:, None], len(rows), axis=1)
    origin_m = rx_m.mean(axis=0)
    return PhasorTable(
        origin_m=origin_m,
        rx_m=(rx_m - origin_m).astype(np.float32),
        tx_m=np.zeros((0, 3), np.float32) if tx_m is None else (tx_m - origin_m).astype(np.float32),
        factors=factors.astype(np.complex64),
        rows=table_rows,
        phasors=np.stack([g.real, g.imag]).astype(np.float32),
        span=np.array([d[0], 1.0 / step_m], dtype=np.float32),
    )


def _round_trip_span(volume: SearchVolume, rx_m: FloatArray, tx_m: FloatArray) -> tuple[float, float]:
    """Shortest and longest round trip [m] between the antennas and a volume."""
    ends = np.stack([volume.lower_m, volume.upper_m])
    near, far = np.zeros(len(rx_m)), np.zeros(len(rx_m))
    for antenna_m in (rx_m, tx_m):
        near += np.linalg.norm(np.clip(antenna_m, *ends) - antenna_m, axis=1)
        far += np.linalg.norm(np.abs(ends[:, None, :] - antenna_m).max(axis=0), axis=1)
    return float(near.min()), float(far.max())
