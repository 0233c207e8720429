"""What the stops of a fetch cost in time: drives at the youBot's limits, and the antenna's way at its carrier's speed.

A drive takes max(d / v, |Δθ| / ω), a motion of the arm max_k |Δq_k| / v_k at the share of the limits that planned paths
use, accelerations left out. The carrier drives from where it is to the start of the next track and along it, while the
robot stands; computing is not counted.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from planners.path_timing import in_time
from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import Robot
from rfcompass.robots.youbot import MAX_SPEED_M_S, MAX_TURN_RAD_S
from rfcompass.types.motions import APPROACH
from rfcompass.types.observation import Observation
from rfcompass.types.record import Record

# Ours: the paper prints no speed of the robot that slides its antenna.
CARRIER_M_S = 0.2


@dataclass(frozen=True, slots=True)
class TimeSpent(Record):
    """Time since the stop before.

    Attributes:
        drive_s: Driving [s].
        scan_s: Bringing the antenna to its tracks and along them [s].
        arm_s: Moving the arm, and the hand's fingers [s].
    """

    drive_s: float = 0.0
    scan_s: float = 0.0
    arm_s: float = 0.0

    @property
    def total_s(self) -> float:
        """All of it [s]."""
        return self.drive_s + self.scan_s + self.arm_s

    def __add__(self, other: "TimeSpent") -> "TimeSpent":
        return TimeSpent(self.drive_s + other.drive_s, self.scan_s + other.scan_s, self.arm_s + other.arm_s)


def drive_time_s(motion: Pose2) -> float:
    """Least time of a straight drive of the youBot [s]: it drives and turns at once."""
    return max(float(np.hypot(motion.x_m, motion.y_m)) / MAX_SPEED_M_S, abs(motion.theta_rad) / MAX_TURN_RAD_S)


def track_m(observation: Observation) -> FloatArray:
    """Where the antenna was read through during a scan, in order [m], shape (M, 3); M = 0 where no reads were made."""
    tracks = [trace.antenna_positions_m for trace in observation.scan.traces.values()]
    return max(tracks, key=len) if tracks else np.zeros((0, 3))


@dataclass(slots=True)
class TimeAccount:
    """Adds up what happens between two stops.

    Args:
        carrier_m_s: Speed of the antenna's carrier [m/s].
    """

    carrier_m_s: float = CARRIER_M_S
    _spent: TimeSpent = field(init=False, default_factory=TimeSpent)
    _antenna_m: FloatArray = field(init=False, default_factory=lambda: np.zeros((0, 3)))

    def drove(self, motions: Sequence[Pose2]) -> None:
        """Count straight drives, one after the other."""
        self._spent += TimeSpent(drive_s=sum(map(drive_time_s, motions)))

    def moved_arm(self, robot: Robot, path: Sequence[FloatArray]) -> None:
        """Count a motion of a robot's arm through joint values, each of shape (Q,)."""
        self._spent += TimeSpent(arm_s=float(in_time(robot, APPROACH, np.array(path)).times_s[-1]))

    def scanned(self, observation: Observation) -> None:
        """Count a scan, and the antenna's way to where it began."""
        way_m = np.concatenate([self._antenna_m, track_m(observation)])
        length_m = float(np.linalg.norm(np.diff(way_m, axis=0), axis=1).sum())
        self._spent += TimeSpent(scan_s=length_m / self.carrier_m_s)
        self._antenna_m = way_m[-1:]

    def close(self) -> TimeSpent:
        """Return what was counted since the last time, and begin anew."""
        spent, self._spent = self._spent, TimeSpent()
        return spent
