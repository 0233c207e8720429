"""`phase_dtw`: dynamic time warping of path profiles, in the manner of STPP."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.rf.dtw import Cost, dtw_matrix
from rfcompass.rf.meters.pairing import compare_tags, mean_of_known
from rfcompass.rf.phases import SMOOTHING_M, path_profile
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan


@dataclass(frozen=True, kw_only=True)
class PhaseDtwMeter:
    """Compare two tags by the DTW distance of their round trips along the antenna path.

    The round trip of a tag beside the path falls and rises again; warping lines up the two valleys as far as the band
    allows. Each profile is taken less its median, so the unknown phase constant drops out. Positions where a tag
    was not heard are bridged. Several runs are compared one by one and their distances averaged.

    Attributes:
        band_share: Half-width of the Sakoe-Chiba band as a share of the profile; None warps freely.
        cost: Cost of two samples that are laid on each other.
        step_penalty: Cost of a step off the diagonal [m], or [m²] for squared cost.
        per_step: Divide by the number of cells on the best path.
        smoothing_m: Length of the path over which phase steps are averaged [m].
    """

    kind: ClassVar[str] = "phase_dtw"
    band_share: float | None = None
    cost: Cost = "absolute"
    step_penalty: float = 0.0
    per_step: bool = False
    smoothing_m: float = SMOOTHING_M

    def measure(
        self, scan: Scan, *, targets: Sequence[str] = (), anchors: Sequence[str] | None = None
    ) -> ProximityMatrix:
        """Compare the tags; see `ProximityMeter.measure`. m in metres of round trip, summed along the warped path."""
        return compare_tags(self.kind, self.distances, scan, targets, anchors)

    def distances(self, traces: Sequence[ReadTrace]) -> FloatArray:
        """Distance of every pair of traces of one scan, shape (T, T)."""
        profiles = [path_profile(trace, self.smoothing_m) for trace in traces]
        return mean_of_known([self._run(np.array([p.path_m[rows] for p in profiles])) for rows in profiles[0].runs])

    def _run(self, paths_m: FloatArray) -> FloatArray:
        centred_m = paths_m - np.median(paths_m, axis=1, keepdims=True)
        band = None if self.band_share is None else round(self.band_share * paths_m.shape[1])
        return dtw_matrix(centred_m, band=band, cost=self.cost, step_penalty=self.step_penalty, per_step=self.per_step)
