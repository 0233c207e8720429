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
        stand_offs_m: Distances of a leg from the part that are tried, the best one first [m].
        length_m: Length of each leg, where rectangle and obstacles allow it [m].
        height_m: Height of the antenna [m].
        clear_m: How far the antenna keeps from obstacles: half the carrier [m].
    """

    low_m: tuple[float, float] = (0.4, 0.4)
    high_m: tuple[float, float] = (5.6, 4.6)
    stand_offs_m: tuple[float, ...] = (1.2,)
    length_m: float = 3.0
    height_m: float = 0.3
    clear_m: float = 0.25

    def legs_m(self, part_m: FloatArray, keep_out_m: FloatArray | None = None) -> FloatArray:
        """Plan about a place in the rectangle's frame [m], shape (2,); see `options_m`.

        Returns:
            Start and end of each leg [m], shape (2, 2, 3). Of the four sides that the L can have, the one whose
            shorter leg is longest; the first of several.

        Raises:
            OutOfReach: If there is no room for two legs of 1.5 m at any of the distances.
        """
        options_m = self.options_m(part_m, keep_out_m)
        if not options_m:
            (x_m, y_m), offs = part_m, ", ".join(f"{off:g}" for off in self.stand_offs_m)
            message = f"no room for two legs of {LEAST_LEG_M} m at {offs} m from ({x_m:.2f}, {y_m:.2f}) m"
            raise OutOfReach(message, part_m=[float(x_m), float(y_m)], needed_m=LEAST_LEG_M)
        return options_m[0]

    def options_m(self, part_m: FloatArray, keep_out_m: FloatArray | None = None) -> list[FloatArray]:
        """List every L about a place in the rectangle's frame, that with the longest shorter leg first.

        Args:
            part_m: About where the part lies [m], shape (2,).
            keep_out_m: Rectangles that the carrier must not touch, least and largest x, y of each [m], shape (B, 2, 2).

        Returns:
            Start and end of each leg [m], shape (2, 2, 3) each; at most one for each of the four sides that an L has.
        """
        blocks_m = np.zeros((0, 2, 2)) if keep_out_m is None else np.asarray(keep_out_m, dtype=np.float64)
        sides = [[self._leg_m(part_m, axis, side, blocks_m) for side in (-1.0, 1.0)] for axis in (0, 1)]
        found = [np.array(pair) for pair in product(*sides) if min(map(_length_m, pair)) >= LEAST_LEG_M]
        return sorted(found, key=lambda legs_m: -round(min(map(_length_m, legs_m)), 9))

    def corner_legs_m(self, corner: tuple[int, int], keep_out_m: FloatArray | None = None) -> FloatArray:
        """Plan one leg along each of the two sides that meet in a corner, from the middle of the rectangle's side.

        Args:
            corner: 0 for the low and 1 for the high end of x and of y.
            keep_out_m: As for `legs_m`.

        Raises:
            OutOfReach: If a side has no room for a leg of 1.5 m.
        """
        blocks_m = np.zeros((0, 2, 2)) if keep_out_m is None else np.asarray(keep_out_m, dtype=np.float64)
        bounds_m = np.array([self.low_m, self.high_m])
        centre_m = bounds_m.mean(axis=0)
        legs = [
            self._longest_m(axis, float(centre_m[axis]), float(bounds_m[corner[1 - axis], 1 - axis]), blocks_m)
            for axis in (0, 1)
        ]
        shorter_m = min(_length_m(leg) for leg in legs)
        if shorter_m < LEAST_LEG_M:
            raise OutOfReach(f"no room for legs of {LEAST_LEG_M} m in corner {corner}", longest_m=shorter_m)
        return np.array(legs)

    def legs(self, part_m: FloatArray) -> tuple[Leg, ...]:
        """Return the legs as tuples, as a simulated carrier takes them; see `legs_m`."""
        return tuple(((a[0], a[1], a[2]), (b[0], b[1], b[2])) for a, b in self.legs_m(part_m).tolist())

    def _leg_m(self, part_m: FloatArray, axis: int, side: float, blocks_m: FloatArray) -> FloatArray | None:
        """Longest leg along an axis on one side of the part, at the first distance that allows it, shape (2, 3)."""
        best, other = None, 1 - axis
        for stand_off_m in self.stand_offs_m:
            across_m = float(part_m[other] + side * stand_off_m)
            if not self.low_m[other] - 1e-9 <= across_m <= self.high_m[other] + 1e-9:
                continue
            leg_m = self._longest_m(axis, float(part_m[axis]), across_m, blocks_m)
            if _length_m(leg_m) > _length_m(best) + 1e-9:
                best = leg_m
        return best

    def _longest_m(self, axis: int, middle_m: float, across_m: float, blocks_m: FloatArray) -> FloatArray | None:
        """Longest leg along a line of the rectangle, as near to `middle_m` as it can be, shape (2, 3)."""
        best = None
        for low_m, high_m in self._gaps_m(axis, across_m, blocks_m):
            leg_m = np.zeros((2, 3))
            leg_m[:, axis], leg_m[:, 1 - axis] = _span_m(middle_m, low_m, high_m, self.length_m), across_m
            leg_m[:, 2] = self.height_m
            if _length_m(leg_m) > _length_m(best) + 1e-9:
                best = leg_m
        return best

    def _gaps_m(self, axis: int, across_m: float, blocks_m: FloatArray) -> list[tuple[float, float]]:
        """Free intervals along a line of the rectangle [m], in ascending order."""
        other, gaps, at_m = 1 - axis, [], self.low_m[axis]
        low_m, high_m = blocks_m[:, 0] - self.clear_m, blocks_m[:, 1] + self.clear_m
        met = (low_m[:, other] < across_m) & (across_m < high_m[:, other])
        for start_m, end_m in sorted(zip(low_m[met, axis].tolist(), high_m[met, axis].tolist(), strict=True)):
            gaps.append((at_m, min(start_m, self.high_m[axis])))
            at_m = max(at_m, end_m)
        gaps.append((at_m, self.high_m[axis]))
        return [(start_m, end_m) for start_m, end_m in gaps if end_m > start_m]


def _span_m(middle_m: float, low_m: float, high_m: float, length_m: float) -> FloatArray:
    """Interval of a length inside another one, its middle as near as possible to a place, shape (2,)."""
    half_m = min(length_m, high_m - low_m) / 2
    centre_m = min(max(middle_m, low_m + half_m), high_m - half_m)
    return np.array([centre_m - half_m, centre_m + half_m])


def _length_m(leg_m: FloatArray | None) -> float:
    return 0.0 if leg_m is None else float(np.linalg.norm(leg_m[1] - leg_m[0]))
