"""Spheres that stand for the links in an optimisation: smooth distances, good enough to steer by.

A solid's bounding box is filled by equal spheres along its longest edge. The *outer* radius covers the box, so that
distances are safe; the *inner* one fits into it, so that nothing is refused that fcl would pass. A blend of the two
goes into the optimisation; what it finds is certified by fcl.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.robots.solids import Solid
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class Spheres(Record):
    """Spheres of one solid.

    Attributes:
        carrier: Link that moves them.
        centres_m: In the frame of that link [m], shape (S, 3).
        inner_m: Radius that fits into the solid's bounding box [m].
        outer_m: Radius that covers it [m].
    """

    carrier: str
    centres_m: FloatArray
    inner_m: float
    outer_m: float

    def __post_init__(self) -> None:
        """Freeze the centres."""
        object.__setattr__(self, "centres_m", read_only(self.centres_m, "Spheres.centres_m", (None, 3)))


def cover(solid: Solid) -> Spheres:
    """Fill a solid's bounding box with spheres along its longest edge.

    With n spheres along the longest half edge h1, h1 ≥ h2 ≥ h3:

        inner = min(h3, h1 / n),  outer² = (h1 / n)² + h2² + h3².
    """
    half_m = solid.half_size_m
    long = int(half_m.argmax())
    h3, h2, h1 = np.sort(half_m)
    count = max(1, round(h1 / h2))
    offsets = np.zeros((count, 3))
    offsets[:, long] = h1 * (2 * np.arange(count) + 1 - count) / count
    T = solid.T_carrier_box
    outer_m = float(np.sqrt((h1 / count) ** 2 + h2**2 + h3**2))
    inner_m = float(min(h3, h1 / count))
    return Spheres(solid.carrier, offsets @ T[:3, :3].T + T[:3, 3], inner_m, outer_m)
