"""`pinit_dtw`: dynamic time warping of multipath profiles, as PinIt and RF-Compass describe it."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.rf.dtw import Cost, dtw_matrix
from rfcompass.rf.meters.pairing import compare_tags, mean_of_known
from rfcompass.rf.profiles import AngularProfile
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan


@dataclass(frozen=True, kw_only=True)
class PinItDtwMeter:
    """Compare two tags by the DTW distance of their multipath profiles [PinIt2013], [Wang2013] section 4.1.

    Needs an antenna path of straight legs. Distances of several legs and sub-apertures are averaged. The defaults are
    the plain reading of the text: one profile of the whole aperture, free warp.

    Deviations:
        None by default, and that is the problem. Where the tag is in sight of the antenna, the *place* of the peak is
        what tells two tags apart, and free warping forgives just that: on measured sweeps this order of distances is
        right about as often as a coin. A `band_rad` of 10 to 20 degrees or `sub_apertures` repair most of it. The
        papers print neither band nor cost nor scale.

    Attributes:
        profile: How to compute the multipath profiles.
        band_rad: Half-width of the Sakoe-Chiba band [rad]; None warps freely.
        cost: Cost of two samples that are laid on each other.
        step_penalty: Cost of a step off the diagonal, in units of the profile.
        per_step: Divide by the number of cells on the best path.
    """

    kind: ClassVar[str] = "pinit_dtw"
    profile: AngularProfile = field(default_factory=AngularProfile)
    band_rad: float | None = None
    cost: Cost = "absolute"
    step_penalty: float = 0.0
    per_step: bool = False

    def measure(
        self, scan: Scan, *, targets: Sequence[str] = (), anchors: Sequence[str] | None = None
    ) -> ProximityMatrix:
        """Compare the tags; see `ProximityMeter.measure`.

        Raises:
            UnsuitablePath: If the antenna path is not made of straight legs.
        """
        return compare_tags(self.kind, self.distances, scan, targets, anchors)

    def distances(self, traces: Sequence[ReadTrace]) -> FloatArray:
        """Distance of every pair of traces of one scan, shape (T, T)."""
        profiles = np.array([self.profile.of(trace) for trace in traces])
        return mean_of_known([self._warp(profiles[:, part]) for part in range(profiles.shape[1])])

    def _warp(self, profiles: FloatArray) -> FloatArray:
        band = None if self.band_rad is None else round(self.band_rad / np.pi * (self.profile.angles - 1))
        return dtw_matrix(profiles, band=band, cost=self.cost, step_penalty=self.step_penalty, per_step=self.per_step)
