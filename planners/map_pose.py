"""Where the base stands on a map: told once, or heard from the robot's own tags."""

from dataclasses import dataclass, field
from typing import Protocol

from rfcompass.errors import TagNeverHeard
from rfcompass.geometry.pose2 import Pose2
from rfcompass.localization.locate_base import locate_base
from rfcompass.types.observation import Observation


class MapPose(Protocol):
    """Knows where the base stands on the map."""

    def base_pose(self, observation: Observation) -> Pose2 | None:
        """Pose of the base in the map frame at a stop; None if that is not known."""
        ...


@dataclass(frozen=True, slots=True)
class KnownStart:
    """The pose on the map is known where odometry begins, as on a charging station; from there on odometry tells.

    Attributes:
        T_map_odom: Pose of the frame of odometry on the map.
    """

    T_map_odom: Pose2

    def base_pose(self, observation: Observation) -> Pose2:
        """Pose of the base in the map frame."""
        return self.T_map_odom @ observation.base_pose


@dataclass(slots=True)
class RadioPose:
    """The robot's own tags, seen from the antenna's track, tell the pose; where they do not, odometry from there."""

    _T_map_odom: Pose2 | None = field(init=False, default=None)
    _told_by: Observation | None = field(init=False, default=None)

    def base_pose(self, observation: Observation) -> Pose2 | None:
        """Pose of the base in the frame of the antenna's positions; None before the tags have first told it."""
        if observation is not self._told_by:  # images take longer than all else here
            self._listen(observation)
            self._told_by = observation
        return None if self._T_map_odom is None else self._T_map_odom @ observation.base_pose

    def _listen(self, observation: Observation) -> None:
        try:
            base = locate_base(observation)
        except TagNeverHeard:
            base = None
        if base is not None and base.theta_rad is not None:
            T_map_base = Pose2(float(base.centre_m[0]), float(base.centre_m[1]), base.theta_rad)
            self._T_map_odom = T_map_base @ observation.base_pose.inverse()
