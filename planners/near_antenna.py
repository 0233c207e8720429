"""The antenna's carrier comes near the part once a scan has told about where it lies."""

from dataclasses import dataclass, field

import numpy as np

from planners.antenna_track import NearTrack
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
# Corners of the rectangle in the order in which the carrier looks from them: far ones first, as it starts at the first.
_CORNERS = ((1, 1), (1, 0), (0, 1), (0, 0))


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
    _looks: int = field(init=False, default=0)

    def comes_nearer(self, observation: Observation, estimate: PartEstimate) -> bool:
        """Send the carrier to an L about the part, unless it drives one already or there is no room.

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
        """Send the carrier to the next L about the part, whose legs lie on other sides and so see other reflections.

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
        robot_m = place.base_m + np.array([[-ROBOT_M], [ROBOT_M]])
        options_m = self.track.options_m(place.part_m, np.concatenate([self.keep_out_m, robot_m[None]]))
        if option >= len(options_m):
            return False
        self._planned_for_m, self._option = place.part_m, option
        self.carrier.use_legs(options_m[option])
        return True

    def looks_from_elsewhere(self) -> bool:
        """Send the carrier along the next two sides of its rectangle, where the part could not be heard or placed.

        Returns:
            False where no side has room for legs, or every corner has had its turn since the part was last found.
        """
        while self._looks < len(_CORNERS):
            corner = _CORNERS[self._looks]
            self._looks += 1
            try:
                legs_m = self.track.corner_legs_m(corner, self.keep_out_m)
            except OutOfReach:
                continue
            self._planned_for_m = None
            self.carrier.use_legs(legs_m)
            return True
        return False

    def found(self) -> None:
        """The part was found: a later look around may begin anew."""
        self._looks = 0


def _apart_m(one_m: FloatArray, other_m: FloatArray) -> float:
    return float(np.linalg.norm(one_m - other_m))
