"""`profile_l1`: mean absolute difference of multipath profiles, without warping."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.rf.meters.pairing import compare_tags, mean_of_known, pairwise
from rfcompass.rf.profiles import AngularProfile
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan


@dataclass(frozen=True, kw_only=True)
class ProfileL1Meter:
    """Compare two tags by the difference of their multipath profiles, angle by angle.

    m(a, b) = mean over θ of | √B_a(θ) - √B_b(θ) |, averaged over legs and sub-apertures. Needs straight legs.
    A whole aperture smears a near tag over the angles under which its parts see it; sub-apertures, five by default
    (ours), keep them apart.

    Attributes:
        profile: How to compute the multipath profiles.
    """

    kind: ClassVar[str] = "profile_l1"
    profile: AngularProfile = field(default_factory=lambda: AngularProfile(sub_apertures=5, quantity="amplitude"))

    def measure(
        self, scan: Scan, *, targets: Sequence[str] = (), anchors: Sequence[str] | None = None
    ) -> ProximityMatrix:
        """Compare the tags; see `ProximityMeter.measure`.

        Raises:
            UnsuitablePath: If the antenna path is not made of straight legs.
        """
        return compare_tags(self.kind, self.distances, scan, targets, anchors)

    def distances(self, traces: Sequence[ReadTrace]) -> FloatArray:
        """Distance of every pair of traces of one scan, in units of the profile, shape (T, T)."""
        profiles = np.array([self.profile.of(trace) for trace in traces])
        return mean_of_known([_differences(profiles[:, part]) for part in range(profiles.shape[1])])


def _differences(profiles: FloatArray) -> FloatArray:
    return pairwise(len(profiles), lambda i, j: float(np.abs(profiles[i] - profiles[j]).mean()))
