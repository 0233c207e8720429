"""Where the antenna carrier drives next: two legs at right angles, as near to the part as pays.

From afar all tags are seen from one side, and reflections are as loud as the tag; an L whose legs pass the part within
1.0 to 1.5 m is worth more than any estimator. So: first a scan from anywhere, then an L about what it found.
"""

from dataclasses import dataclass
from itertools import product
from typing import TypeAlias

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import OutOfReach

Point: TypeAlias = tuple[float, float, float]
Leg: TypeAlias = tuple[Point, Point]

LEAST_LEG_M = 1.5  # ours: shorter legs resolve too little


@dataclass(frozen=True, slots=True, kw_only=True)
class NearTrack:
    """Plans an L about a part, its legs along the axes of a rectangle that the carrier may drive in.

    All values are ours, from a study of simulated rooms: legs of 2 m at 0.8 m were worse than 3 m at 1.2 m.

    Attributes:
        low_m: Least x, y of the antenna [m].
        high_m: Largest x, y [m].
        stand_off_m: Distance of each leg from the part [m].
        length_m: Length of each leg, where the rectangle allows it [m].
        height_m: Height of the antenna [m].
    """

    low_m: tuple[float, float] = (0.4, 0.4)
    high_m: tuple[float, float] = (5.6, 4.6)
    stand_off_m: float = 1.2
    length_m: float = 3.0
    height_m: float = 0.3

    def legs_m(self, part_m: FloatArray) -> FloatArray:
        """Plan about a place in the rectangle's frame [m], shape (2,).

        Returns:
            Start and end of each leg [m], shape (2, 2, 3). Of the four sides that the L can have, the one whose
            shorter leg is longest; the first of several.

        Raises:
            OutOfReach: If the rectangle has no room for two legs of 1.5 m at that distance.
        """
        best, longest_m = None, 0.0
        for sides in product((-1.0, 1.0), repeat=2):
            legs_m = np.array([self._leg_m(part_m, axis, side) for axis, side in enumerate(sides)])
            shorter_m = min(float(np.linalg.norm(end - start)) for start, end in legs_m)
            if self._allowed(legs_m) and shorter_m > longest_m + 1e-9:
                best, longest_m = legs_m, shorter_m
        if best is None or longest_m < LEAST_LEG_M:
            x_m, y_m = part_m
            message = f"no room for two legs of {LEAST_LEG_M} m at {self.stand_off_m} m from ({x_m:.2f}, {y_m:.2f}) m"
            raise OutOfReach(message, part_m=[float(x_m), float(y_m)], longest_m=longest_m)
        return best

    def legs(self, part_m: FloatArray) -> tuple[Leg, ...]:
        """Return the legs as tuples, as a simulated carrier takes them; see `legs_m`."""
        return tuple(((a[0], a[1], a[2]), (b[0], b[1], b[2])) for a, b in self.legs_m(part_m).tolist())

    def _leg_m(self, part_m: FloatArray, axis: int, side: float) -> FloatArray:
        """Leg along an axis of the rectangle, on one side of the part, shape (2, 3)."""
        other = 1 - axis
        middle_m = float(np.clip(part_m[axis], *self._reach_m(axis)))
        leg_m = np.zeros((2, 3))
        leg_m[:, axis] = np.clip(
            middle_m + self.length_m * np.array([-0.5, 0.5]), self.low_m[axis], self.high_m[axis]
        )  # fmt: skip
        leg_m[:, other] = part_m[other] + side * self.stand_off_m
        leg_m[:, 2] = self.height_m
        return leg_m

    def _reach_m(self, axis: int) -> tuple[float, float]:
        """Where the middle of a whole leg can be along an axis [m]; the middle of the rectangle if none fits."""
        low_m, high_m = self.low_m[axis] + self.length_m / 2, self.high_m[axis] - self.length_m / 2
        centre_m = (low_m + high_m) / 2
        return min(low_m, centre_m), max(high_m, centre_m)

    def _allowed(self, legs_m: FloatArray) -> bool:
        plane_m = legs_m[:, :, :2]
        inside = (plane_m >= np.array(self.low_m) - 1e-9) & (plane_m <= np.array(self.high_m) + 1e-9)
        return bool(inside.all())
