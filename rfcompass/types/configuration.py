"""Where a robot stands and how its joints are set."""

from dataclasses import dataclass, field

from rfcompass.arrays import FloatArray, read_only
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class Configuration(Record):
    """A robot's base pose and joint values.

    Attributes:
        joints: One value for each moving joint, in the order of the robot's `joint_names`
            (revolute and continuous [rad], prismatic [m]), shape (Q,).
        base: Pose `T_world_base` of the base; what "world" is, is the caller's choice (odometry, a room).
    """

    joints: FloatArray
    base: Pose2 = field(default_factory=Pose2)

    def __post_init__(self) -> None:
        """Freeze the joint values; refuse NaN and infinity."""
        object.__setattr__(self, "joints", read_only(self.joints, "Configuration.joints", (None,)))
