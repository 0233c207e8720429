"""`rssi`: mean absolute difference of signal strengths along the antenna path."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.rf.meters.pairing import compare_tags, pairwise
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan


@dataclass(frozen=True, kw_only=True)
class RssiMeter:
    """Compare two tags by their signal strengths, cell by cell.

    m(a, b) = mean over l, f of | 10^(-P_a / 20) - 10^(-P_b / 20) |,     P in dBm,

    over the cells (position l, channel f) in which both were heard. 10^(-P/20) grows with the length of the path:
    with its square for a monostatic reader in free space. A mean over the path taken before the difference would
    tell next to nothing: tags to the left and to the right of the middle are equally loud. A baseline: on measured
    sweeps it is far behind the phase meters, and so is the same with amplitudes or decibels.
    """

    kind: ClassVar[str] = "rssi"

    def measure(
        self, scan: Scan, *, targets: Sequence[str] = (), anchors: Sequence[str] | None = None
    ) -> ProximityMatrix:
        """Compare the tags; see `ProximityMeter.measure`. m in units of 10^(-dBm/20)."""
        return compare_tags(self.kind, self.distances, scan, targets, anchors)

    def distances(self, traces: Sequence[ReadTrace]) -> FloatArray:
        """Distance of every pair of traces of one scan, shape (T, T)."""
        losses = [_loss(trace) for trace in traces]
        return pairwise(len(losses), lambda i, j: _mean_gap(losses[i], losses[j]))


def _loss(trace: ReadTrace) -> FloatArray:
    """1 / |h| = 10^(-P/20), NaN where nothing was heard, shape (M, F)."""
    amplitude = np.abs(trace.channel)
    return np.asarray(1.0 / np.where(amplitude > 0, amplitude, np.nan))


def _mean_gap(a: FloatArray, b: FloatArray) -> float:
    gap = np.abs(a - b)
    common = gap[np.isfinite(gap)]
    return float(common.mean()) if common.size else float("nan")
