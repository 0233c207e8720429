"""Where the antenna carrier drives next: two legs at right angles, as near to the part as pays.

From afar all tags are seen from one side, and reflections are as loud as the tag; an L whose legs pass the part within
1.0 to 1.5 m is worth more than any estimator. So: first a scan from anywhere, then an L about what it found. That is
for an empty room; among furniture an L seldom fits, and the legs come from `free_legs`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import TypeAlias

import numpy as np

from planners.free_legs import Corridor, free_tracks_m, gaps, span
from rfcompass.arrays import FloatArray
from rfcompass.errors import OutOfReach

Point: TypeAlias = tuple[float, float, float]
Leg: TypeAlias = tuple[Point, Point]

# Ours. Shorter legs resolve too little, and so do legs beside which the part does not lie: it sees them under a smaller
# angle. Beyond the largest angle nothing more is gained.
LEAST_LEG_M = 1.5
LEAST_ANGLE_RAD, ENOUGH_ANGLE_RAD = np.radians([45.0, 100.0])


@dataclass(frozen=True, slots=True, kw_only=True)
class NearTrack:
    """Plans legs about a part inside a rectangle that the carrier may drive in.

    All values are ours, from a study of simulated rooms: legs of 2 m at 0.8 m were worse than 3 m at 1.2 m.

    Attributes:
        low_m: Least x, y of the antenna [m].
        high_m: Largest x, y [m].
        stand_off_m: Distance of a leg of the L from the part [m].
        length_m: Length of each leg, where rectangle and obstacles allow it [m].
        height_m: Height of the antenna [m].
        clear_m: How far the antenna keeps from obstacles: half the carrier [m].
    """

    low_m: tuple[float, float] = (0.4, 0.4)
    high_m: tuple[float, float] = (5.6, 4.6)
    stand_off_m: float = 1.2
    length_m: float = 3.0
    height_m: float = 0.3
    clear_m: float = 0.25

    def legs_m(self, part_m: FloatArray) -> FloatArray:
        """Plan an L about a place in the rectangle's frame [m], shape (2,), where nothing else stands.

        Returns:
            Start and end of each leg [m], shape (2, 2, 3). Of the four sides that the L can have, the one whose
            worse leg the part sees under the largest angle; the first of several.

        Raises:
            OutOfReach: If there is no room for two legs, of 1.5 m and 45 degrees at least.
        """
        sides = [[self._legs_beside_m(part_m, axis, side) for side in (-1.0, 1.0)] for axis in (0, 1)]
        pairs = [np.array([*x, *y]) for x, y in product(*sides) if x and y]
        if not pairs:
            x_m, y_m = map(float, part_m)
            message = (
                f"no room for two legs of {LEAST_LEG_M} m at {self.stand_off_m:g} m beside ({x_m:.2f}, {y_m:.2f}) m"
            )
            raise OutOfReach(message, part_m=[x_m, y_m], needed_m=LEAST_LEG_M)
        return max(pairs, key=lambda legs_m: min(_seen_rad(part_m, leg) for leg in legs_m))

    def free_m(self, part_m: FloatArray, keep_out_m: FloatArray) -> Iterator[FloatArray]:
        """List tracks of legs in any direction, the most telling first; see `free_tracks_m`.

        Args:
            part_m: About where the part lies, in the rectangle's frame [m], shape (2,).
            keep_out_m: Rectangles that the carrier must not touch, least and largest x, y of each [m], shape (B, 2, 2).
        """
        return free_tracks_m(part_m, self._corridor(keep_out_m))

    def corner_legs_m(self, corner: tuple[int, int], keep_out_m: FloatArray | None = None) -> FloatArray:
        """Plan one leg along each of the two sides that meet in a corner, from the middle of the rectangle's side.

        Args:
            corner: 0 for the low and 1 for the high end of x and of y.
            keep_out_m: As for `free_m`.

        Raises:
            OutOfReach: If a side has no room for a leg of 1.5 m.
        """
        bounds_m, corridor = np.array([self.low_m, self.high_m]), self._corridor(keep_out_m)
        centre_m = bounds_m.mean(axis=0)
        sides = [
            self._legs_along_m(axis, float(centre_m[axis]), float(bounds_m[corner[1 - axis], 1 - axis]), corridor)
            for axis in (0, 1)
        ]
        legs = [max(side, key=_length_m, default=None) for side in sides]
        if any(leg_m is None or _length_m(leg_m) < LEAST_LEG_M for leg_m in legs):
            raise OutOfReach(f"no room for legs of {LEAST_LEG_M} m in corner {corner}", needed_m=LEAST_LEG_M)
        return np.array(legs)

    def legs(self, part_m: FloatArray) -> tuple[Leg, ...]:
        """Return the L as tuples, as a simulated carrier takes them; see `legs_m`."""
        return tuple(((a[0], a[1], a[2]), (b[0], b[1], b[2])) for a, b in self.legs_m(part_m).tolist())

    def _legs_beside_m(self, part_m: FloatArray, axis: int, side: float) -> list[FloatArray]:
        """The leg along an axis on one side of the part, shape (2, 3), if it is worth driving."""
        across_m = float(part_m[1 - axis] + side * self.stand_off_m)
        legs_m = self._legs_along_m(axis, float(part_m[axis]), across_m, self._corridor(None))
        return [leg for leg in legs_m if _seen_rad(part_m, leg) >= LEAST_ANGLE_RAD and _length_m(leg) >= LEAST_LEG_M]

    def _legs_along_m(self, axis: int, middle_m: float, across_m: float, corridor: Corridor) -> list[FloatArray]:
        """A leg in each gap of a line along an axis, as near to `middle_m` as it can be, shape (2, 3) each."""
        found, foot_m = [], np.zeros(2)
        foot_m[1 - axis] = across_m
        for low_m, high_m in gaps(foot_m, np.eye(2)[axis], corridor):
            leg_m = np.zeros((2, 3))
            leg_m[:, axis], leg_m[:, 1 - axis] = span(middle_m, low_m, high_m, self.length_m), across_m
            leg_m[:, 2] = self.height_m
            found.append(leg_m)
        return found

    def _corridor(self, keep_out_m: FloatArray | None) -> Corridor:
        """The rectangle, without what the carrier must not touch."""
        blocks_m = np.zeros((0, 2, 2)) if keep_out_m is None else np.asarray(keep_out_m, dtype=np.float64)
        return Corridor(
            low_m=np.array(self.low_m), high_m=np.array(self.high_m),
            blocks_m=blocks_m + self.clear_m * np.array([[-1.0], [1.0]]),
            height_m=self.height_m, length_m=self.length_m,
        )  # fmt: skip


def _length_m(leg_m: FloatArray) -> float:
    return float(np.linalg.norm(leg_m[1] - leg_m[0]))


def _seen_rad(part_m: FloatArray, leg_m: FloatArray) -> float:
    """Angle under which a leg is seen from the part, up to what is enough, to nine digits [rad]."""
    start, end = leg_m[:, :2] - part_m
    angle = float(abs(np.arctan2(start[0] * end[1] - start[1] * end[0], start @ end)))
    return round(min(angle, float(ENOUGH_ANGLE_RAD)), 9)
