"""`aoa`: difference of the bearings from which two tags are heard."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.rf.meters.pairing import compare_tags, mean_of_known
from rfcompass.rf.profiles import AngularProfile
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan


@dataclass(frozen=True, kw_only=True)
class AoaMeter:
    """Compare two tags by the angle between the highest peaks of their multipath profiles.

    m(a, b) = | θ_a - θ_b |, averaged over legs and sub-apertures. Needs an antenna path of straight legs.
    A baseline: the angle says nothing of range, and the highest peak need not be the direct path.

    Attributes:
        profile: How to compute the multipath profiles.
    """

    kind: ClassVar[str] = "aoa"
    profile: AngularProfile = field(default_factory=lambda: AngularProfile(window="hann"))

    def measure(
        self, scan: Scan, *, targets: Sequence[str] = (), anchors: Sequence[str] | None = None
    ) -> ProximityMatrix:
        """Compare the tags; see `ProximityMeter.measure`. m in radians.

        Raises:
            UnsuitablePath: If the antenna path is not made of straight legs.
        """
        return compare_tags(self.kind, self.distances, scan, targets, anchors)

    def distances(self, traces: Sequence[ReadTrace]) -> FloatArray:
        """Angle between every pair of traces of one scan [rad], shape (T, T)."""
        step_rad = np.pi / (self.profile.angles - 1)
        bearings = np.array([[step_rad * peak_place(B) for B in self.profile.of(trace)] for trace in traces])
        return mean_of_known([np.abs(np.subtract.outer(column, column)) for column in bearings.T])


def peak_place(profile: FloatArray) -> float:
    """Place of the highest sample, refined by a parabola through its neighbours [samples]; NaN for a NaN profile."""
    if np.isnan(profile).any():
        return float("nan")
    top = int(np.argmax(profile))
    if top in (0, profile.size - 1):
        return float(top)
    before, peak, after = profile[top - 1 : top + 2]
    return top + float((before - after) / (2 * (before - 2 * peak + after)))
