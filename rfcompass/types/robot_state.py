"""What a robot believes about itself."""

from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.observation import read_covariance
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class RobotState(Record):
    """Odometry and joint sensors at one moment.

    Attributes:
        joints: One value for each moving joint, in the order of the robot's `joint_names`
            (revolute and continuous [rad], prismatic [m]), shape (Q,).
        base: Believed pose `T_odom_base`.
        base_covariance: Covariance of (x, y, θ) of that pose [m², m rad, rad²], shape (3, 3).
    """

    joints: FloatArray
    base: Pose2 = field(default_factory=Pose2)
    base_covariance: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))

    def __post_init__(self) -> None:
        """Freeze the arrays; check the covariance."""
        set_ = object.__setattr__
        set_(self, "joints", read_only(self.joints, "RobotState.joints", (None,)))
        set_(self, "base_covariance", read_covariance(self.base_covariance, "RobotState.base_covariance"))
