"""The antenna's carrier comes near the part once a scan has told about where it lies."""

from dataclasses import dataclass, field

import numpy as np

from planners.antenna_track import NearTrack
from planners.free_legs import track_information
from rfcompass.arrays import FloatArray
from rfcompass.errors import OutOfReach, TagNeverHeard
from rfcompass.geometry.pose2 import Pose2
from rfcompass.interfaces import AntennaCarrier
from rfcompass.localization.locate_base import locate_base
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.observation import Observation

# Ours. Legs that were planned for a place further than this from where the part now seems to lie are planned anew; the
# carrier keeps out of a square of this half width about the robot's base.
MOVED_M = 0.3
ROBOT_M = 0.45
FROM_M = 1.5
# What legs must tell to be worth driving [1/m]. Two whole legs at 1.2 m tell 0.37; those along two walls, of a part in
# the far corner of the room, 0.002.
LEAST_INFORMATION = 0.02
# Corners of the rectangle in the order in which the carrier looks from them: far ones first, as it starts at the first.
_CORNERS = ((1, 1), (1, 0), (0, 1), (0, 0))
_QUARTERS = ((0.75, 0.75), (0.75, 0.25), (0.25, 0.75), (0.25, 0.25))


@dataclass(frozen=True, slots=True)
class _Place:
    """Where part and base are in the antenna's frame [m], shape (2,) each."""

    part_m: FloatArray
    base_m: FloatArray


@dataclass(slots=True)
class NearAntenna:
    """Plans the carrier's legs from what the robot has found out.

    Args:
        carrier: Who moves the antenna.
        track: How near, how long, and inside which rectangle of the antenna's frame.
        from_m: A part that seems to be further from the base's centre than this is not approached yet [m]: of legs
            about the part, the robot's own tags would give poor images.
        keep_out_m: Obstacles that are known, as rectangles in that frame [m], shape (B, 2, 2).
    """

    carrier: AntennaCarrier
    track: NearTrack
    from_m: float = FROM_M
    keep_out_m: FloatArray = field(default_factory=lambda: np.zeros((0, 2, 2)))
    _planned_for_m: FloatArray | None = field(init=False, default=None)
    _option: int = field(init=False, default=0)
    _next_look: int = field(init=False, default=0)
    _looked: int = field(init=False, default=0)

    def comes_nearer(self, observation: Observation, estimate: PartEstimate) -> bool:
        """Send the carrier to legs about the part, unless it drives such already or there is no room.

        Args:
            observation: The newest stop; its reads tell where the base stands in the antenna's frame.
            estimate: Where the part is, in that stop's base frame.

        Returns:
            Whether the next scan will be made from other legs.
        """
        if estimate.distance_m > self.from_m:
            return False
        place = self._place(observation, estimate)
        if place is None or (
            self._planned_for_m is not None and _apart_m(place.part_m, self._planned_for_m) <= MOVED_M
        ):
            return False
        return self._takes(place, 0)

    def changes_sides(self, observation: Observation, estimate: PartEstimate) -> bool:
        """Send the carrier to the next legs about the part, which lie elsewhere and so see other reflections.

        Args and returns as for `comes_nearer`; False too where every L has had its turn.
        """
        place = self._place(observation, estimate)
        return place is not None and self._takes(place, self._option + 1)

    def _place(self, observation: Observation, estimate: PartEstimate) -> "_Place | None":
        """Where part and robot are among the antenna's positions; None if the scan does not tell."""
        try:
            base = locate_base(observation)
        except TagNeverHeard:
            return None
        if base.theta_rad is None:
            return None
        x_m, y_m = base.centre_m
        return _Place(Pose2(x_m, y_m, base.theta_rad).apply(estimate.centre_m), base.centre_m)

    def _takes(self, place: "_Place", option: int) -> bool:
        options_m = self._options_m(place)
        if option >= len(options_m):
            return False
        self._planned_for_m, self._option = place.part_m, option
        self.carrier.use_legs(options_m[option])
        return True

    def _options_m(self, place: "_Place") -> list[FloatArray]:
        """Tracks about the part that tell enough, shape (L, 2, 3) each, the most telling first."""
        robot_m = place.base_m + np.array([[-ROBOT_M], [ROBOT_M]])
        blocks_m = np.concatenate([self.keep_out_m, robot_m[None]])
        return [
            legs_m
            for legs_m in self.track.free_m(place.part_m, blocks_m)
            if track_information(place.part_m, legs_m) >= LEAST_INFORMATION
        ]

    def looks_from_elsewhere(self) -> bool:
        """Send the carrier to the next place to look from, where the part could not be heard or placed.

        These are each corner of its rectangle, along the two sides that meet there, and then the free legs about the
        middle of each quarter of it. The one after the last is the first.

        Returns:
            False where no place has room for legs, or each had its turn since the part was last found.
        """
        while self._looked < len(_CORNERS) + len(_QUARTERS):
            legs_m = self._look_m(self._next_look)
            self._next_look = (self._next_look + 1) % (len(_CORNERS) + len(_QUARTERS))
            self._looked += 1
            if legs_m is not None:
                self._planned_for_m = None
                self.carrier.use_legs(legs_m)
                return True
        return False

    def _look_m(self, index: int) -> FloatArray | None:
        """Legs to look along [m], shape (2, 2, 3); None if there is no room."""
        if index < len(_CORNERS):
            try:
                return self.track.corner_legs_m(_CORNERS[index], self.keep_out_m)
            except OutOfReach:
                return None
        share = np.array(_QUARTERS[index - len(_CORNERS)])
        middle_m = (1.0 - share) * self.track.low_m + share * self.track.high_m
        return next(self.track.free_m(middle_m, self.keep_out_m), None)

    def found(self) -> None:
        """The part was found: all looks may be had again."""
        self._looked = 0


def _apart_m(one_m: FloatArray, other_m: FloatArray) -> float:
    return float(np.linalg.norm(one_m - other_m))
