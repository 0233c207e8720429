"""When to stop measuring: when the part is known well enough, not after a count of stops."""

from dataclasses import dataclass

import numpy as np

from rfcompass.errors import InputError
from rfcompass.geometry.angles import angle_difference
from rfcompass.types.estimate import PartEstimate


@dataclass(frozen=True, slots=True, kw_only=True)
class StopRule:
    """Measured enough: with a certain probability the part lies within a distance and an angle of the estimate.

    The values are ours; a hand that opens 7.5 cm over a leg 5 cm wide leaves 1.25 cm on each side.

    Attributes:
        within_m: Distance of the centre [m].
        within_rad: Angle [rad]; None where any angle will do.
        symmetry: Turns by which the part looks the same to the hand: 2 where half a turn is no difference.
        probability: How sure.
    """

    within_m: float = 0.01
    within_rad: float | None = float(np.deg2rad(5.0))
    symmetry: int = 1
    probability: float = 0.9

    def __post_init__(self) -> None:
        """Refuse rules that nothing or everything meets."""
        if self.within_m <= 0.0 or (self.within_rad is not None and self.within_rad <= 0.0):
            raise InputError(f"within {self.within_m} m and {self.within_rad} rad: both must be above 0")
        if self.symmetry < 1:
            raise InputError(f"a part looks the same after {self.symmetry} turns? At least 1", symmetry=self.symmetry)
        if not 0.0 < self.probability < 1.0:
            raise InputError(f"probability = {self.probability} lies outside (0, 1)", probability=self.probability)

    def share(self, estimate: PartEstimate) -> float:
        """Share of the estimate's samples that lie within distance and angle; 0 if its θ is unknown but matters.

        Raises:
            InputError: If the estimate carries no samples.
        """
        samples = estimate.samples
        if not len(samples):
            raise InputError(f"an estimate by {estimate.method} carries no samples", method=estimate.method)
        near = np.linalg.norm(samples[:, :2] - estimate.centre_m, axis=1) <= self.within_m
        if self.within_rad is None:
            return float(near.mean())
        if estimate.theta_rad is None:
            return 0.0
        off_rad = np.abs(angle_difference(samples[:, 2], estimate.theta_rad, 2.0 * np.pi / self.symmetry))
        return float((near & (off_rad <= self.within_rad)).mean())

    def met_by(self, estimate: PartEstimate) -> bool:
        """Tell whether the part is known well enough."""
        return self.share(estimate) >= self.probability
