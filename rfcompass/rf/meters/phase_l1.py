"""`phase_l1`: mean absolute difference of unwrapped phases along the antenna path."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.rf.meters.pairing import compare_tags, pairwise
from rfcompass.rf.phases import SMOOTHING_M, unwrapped_phase
from rfcompass.rf.runs import runs
from rfcompass.rf.waves import wavenumber
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan


@dataclass(frozen=True, kw_only=True)
class PhaseL1Meter:
    """Compare two tags by the difference of their round trips along the antenna path.

    m(a, b) = mean over f, l of | δ(l, f) - median_l δ(l, f) |,     δ = (φ_a - φ_b) / k_f,

    with the unwrapped phase lags φ of the cells in which both tags were heard. The median is taken for each channel
    and run, so the unknown phase constants drop out. Works on any antenna path.

    Attributes:
        smoothing_m: Length of the path over which the guide of the unwrapping is averaged [m].
    """

    kind: ClassVar[str] = "phase_l1"
    smoothing_m: float = SMOOTHING_M

    def measure(
        self, scan: Scan, *, targets: Sequence[str] = (), anchors: Sequence[str] | None = None
    ) -> ProximityMatrix:
        """Compare the tags; see `ProximityMeter.measure`. m in metres of round trip."""
        return compare_tags(self.kind, self.distances, scan, targets, anchors)

    def distances(self, traces: Sequence[ReadTrace]) -> FloatArray:
        """Distance of every pair of traces of one scan [m], shape (T, T)."""
        k = wavenumber(traces[0].frequencies_hz)
        paths = [np.where(trace.mask, unwrapped_phase(trace, self.smoothing_m), np.nan) / k for trace in traces]
        parts = runs(traces[0])
        return pairwise(len(traces), lambda i, j: _mean_deviation(paths[i] - paths[j], parts))


def _mean_deviation(gap_m: FloatArray, parts: Sequence[IntArray]) -> float:
    """Mean absolute deviation from the median of each column of each part; NaN without two common cells."""
    deviations = []
    for rows in parts:
        for column in gap_m[rows].T:
            common = column[np.isfinite(column)]
            if common.size >= 2:
                deviations.append(np.abs(common - np.median(common)))
    return float(np.concatenate(deviations).mean()) if deviations else float("nan")
