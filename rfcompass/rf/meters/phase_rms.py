"""`phase_rms`: how much the difference of two tags' path profiles varies along the antenna path."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.rf.meters.pairing import compare_tags, pairwise
from rfcompass.rf.phases import SMOOTHING_M, PathProfile, path_profile
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan


@dataclass(frozen=True, kw_only=True)
class PhaseRmsMeter:
    """Compare two tags by the standard deviation of the difference of their round trips along the antenna path.

    m²(a, b) = mean_l ( δ(l) - mean δ )²,     δ(l) = d_a(l) - d_b(l),

    with path profiles d that sum the phase steps of all channels, averaged over a short window and weighted by
    amplitude (see `rfcompass.rf.phases`). The mean is taken for each run, so the unknown phase constants drop out.

    Two things differ from `phase_l1`, both against reflections. A fade, where the phase slips by a turn, hardly
    counts, since it is weak. And squares add up: reflections that have nothing to do with the displacement raise m²
    of all pairs alike, which leaves their order as it is. Works on any antenna path.

    Attributes:
        smoothing_m: Length of the path over which phase steps are averaged [m].
    """

    kind: ClassVar[str] = "phase_rms"
    smoothing_m: float = SMOOTHING_M

    def measure(
        self, scan: Scan, *, targets: Sequence[str] = (), anchors: Sequence[str] | None = None
    ) -> ProximityMatrix:
        """Compare the tags; see `ProximityMeter.measure`. m in metres of round trip."""
        return compare_tags(self.kind, self.distances, scan, targets, anchors)

    def distances(self, traces: Sequence[ReadTrace]) -> FloatArray:
        """Distance of every pair of traces of one scan [m], shape (T, T)."""
        profiles = [path_profile(trace, self.smoothing_m) for trace in traces]
        return pairwise(len(profiles), lambda i, j: _deviation(profiles[i], profiles[j]))


def _deviation(a: PathProfile, b: PathProfile) -> float:
    """Root mean square of δ less its mean over each run; NaN without two common positions in any run."""
    gap_m = np.where(a.heard & b.heard, a.path_m - b.path_m, np.nan)
    common = [gap_m[rows][np.isfinite(gap_m[rows])] for rows in a.runs]
    rests = [gap - gap.mean() for gap in common if gap.size >= 2]
    return float(np.sqrt(np.mean(np.concatenate(rests) ** 2))) if rests else float("nan")
