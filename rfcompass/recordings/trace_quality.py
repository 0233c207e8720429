"""What a trace is worth: counts, coverage and scatter, before any method looks at it."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.recordings.antenna_poses import AntennaPoses
from rfcompass.recordings.cells import Cells, average_cells
from rfcompass.recordings.placement import PlacedReads

# A cell shows half-turn flips if doubling the phase makes it more coherent; rounding must not (ours).
_MORE_COHERENT = 1e-9


@dataclass(frozen=True, slots=True)
class TagQuality:
    """How well one tag of the trace was heard.

    Attributes:
        epc: EPC of the tag.
        reads: Number of its reads; 0 if it was never heard.
        coverage: Share of the cells (antenna position, frequency) with at least one read.
        phase_spread_rad: Median over cells of the circular standard deviation of the phase between reads of one
            cell [rad], modulo the phase modulus of the trace; None if no cell has two reads.
        flip_share: Share of the cells with two reads or more in which reads differ by half a turn; None if there
            is no such cell, or if the reader's phase is ambiguous by half a turn anyway.
    """

    epc: str
    reads: int
    coverage: float
    phase_spread_rad: float | None
    flip_share: float | None


@dataclass(frozen=True, slots=True)
class StrayTag:
    """A tag that was heard, but does not belong to the trace.

    Attributes:
        epc: EPC of the tag.
        reads: Number of its reads.
    """

    epc: str
    reads: int


@dataclass(frozen=True, slots=True)
class TraceQuality:
    """Quality report of a trace.

    Attributes:
        reads: Number of reads, strays included.
        positions: Number of antenna positions at which tags of the trace were heard.
        frequencies: Number of frequencies at which they were heard.
        tags: Each tag of the trace, heard or not.
        strays: Tags that do not belong to the trace; scans leave them out.
        poses_without_reads: (pose_id, antenna) of each pose that no read names.
        stops_without_reads: Stops at which nothing was heard.
        phase_spread_rad: As in `TagQuality`, over the cells of all tags [rad].
        flip_share: As in `TagQuality`, over the cells of all tags.
    """

    reads: int
    positions: int
    frequencies: int
    tags: tuple[TagQuality, ...]
    strays: tuple[StrayTag, ...]
    poses_without_reads: tuple[tuple[int, int], ...]
    stops_without_reads: tuple[int, ...]
    phase_spread_rad: float | None
    flip_share: float | None

    @property
    def stray_reads(self) -> int:
        """Number of reads of strays."""
        return sum(stray.reads for stray in self.strays)

    @property
    def silent_epcs(self) -> tuple[str, ...]:
        """Tags of the trace that were never heard."""
        return tuple(tag.epc for tag in self.tags if tag.reads == 0)


def judge_reads(
    reads: PlacedReads, epcs: tuple[str, ...], poses: AntennaPoses, stop_ids: IntArray, *, half_turns: bool
) -> TraceQuality:
    """Compute the quality report.

    Args:
        reads: All reads of the trace.
        epcs: Tags that belong to the trace.
        poses: All antenna poses of the trace.
        stop_ids: All stops of the trace, empty if it has none, shape (S,).
        half_turns: True if the phase is known modulo π only.
    """
    columns = reads.columns
    cells = average_cells(reads, epcs)
    counts = np.bincount(columns.epc_index, minlength=len(columns.epcs))
    strays = [StrayTag(epc, int(n)) for epc, n in zip(columns.epcs, counts, strict=True) if epc not in epcs]
    unused = np.setdiff1d(np.arange(poses.pose_ids.size), _poses_read(reads))
    silent_stops = np.empty(0) if columns.stop_id is None else np.setdiff1d(stop_ids, columns.stop_id)
    spread_rad, flipped = _spread(cells, half_turns=half_turns), _flipped(cells)
    several = cells.means.counts >= 2
    return TraceQuality(
        reads=columns.epc_index.size,
        positions=cells.rx_rows.size,
        frequencies=cells.frequencies_hz.size,
        tags=tuple(_judge_tag(cells, t, spread_rad, None if half_turns else flipped) for t in range(len(epcs))),
        strays=tuple(strays),
        poses_without_reads=tuple((int(poses.pose_ids[row]), int(poses.antennas[row])) for row in unused),
        stops_without_reads=tuple(int(stop_id) for stop_id in silent_stops),
        phase_spread_rad=_median(spread_rad[several]),
        flip_share=None if half_turns else _share(flipped[several]),
    )


def _poses_read(reads: PlacedReads) -> IntArray:
    positions = np.unique(reads.position)
    return np.concatenate([reads.rx_rows[positions], reads.tx_rows[positions]])


def _judge_tag(cells: Cells, t: int, spread_rad: FloatArray, flipped: BoolArray | None) -> TagQuality:
    counts = cells.means.counts[t]
    several = counts >= 2
    return TagQuality(
        epc=cells.epcs[t],
        reads=int(counts.sum()),
        coverage=float(np.mean(counts > 0)) if counts.size else 0.0,
        phase_spread_rad=_median(spread_rad[t][several]),
        flip_share=None if flipped is None else _share(flipped[t][several]),
    )


def _spread(cells: Cells, *, half_turns: bool) -> FloatArray:
    """Circular standard deviation √(-2 ln R) of the phase in each cell [rad], shape (T, M, F)."""
    R = np.clip(np.abs(cells.means.doubled if half_turns else cells.means.phasor), 1e-300, 1.0)
    return np.asarray(np.sqrt(-2.0 * np.log(R)) / (2.0 if half_turns else 1.0))


def _flipped(cells: Cells) -> BoolArray:
    """Cells that are more coherent after doubling the phase, which no unimodal scatter brings about."""
    return np.asarray(np.abs(cells.means.doubled) > np.abs(cells.means.phasor) + _MORE_COHERENT)


def _median(values: FloatArray) -> float | None:
    return float(np.median(values)) if values.size else None


def _share(values: BoolArray) -> float | None:
    return float(np.mean(values)) if values.size else None
