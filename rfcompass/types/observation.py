"""One stop of the robot, as an estimator sees it."""

from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import Scan
from rfcompass.types.record import Record
from rfcompass.types.tags import TagLayout, TagPositions


def _no_covariance() -> FloatArray:
    return np.zeros((3, 3))


@dataclass(frozen=True, slots=True)
class Observation(Record):
    """What was heard at one stop, and what the robot believes about itself there. Holds no truth.

    Attributes:
        stop_id: Number of the stop; newer stops have higher numbers.
        anchors: Robot tags in the base frame of this stop, from forward kinematics.
        part: How the tags are mounted on the part that is looked for.
        part_tag_heights_m: Height of each part tag in the base frame [m], shape (K,).
        scan: All reads of the stop; empty if a proximity matrix was given instead.
        proximity: Ready-made proximities, used in place of a meter if present.
        base_pose: Believed pose `T_odom_base` at this stop.
        base_covariance: Covariance of (x, y, θ) of that pose [m², m rad, rad²], shape (3, 3).
    """

    stop_id: int
    anchors: TagPositions
    part: TagLayout
    part_tag_heights_m: FloatArray
    scan: Scan = field(default_factory=Scan)
    proximity: ProximityMatrix | None = None
    base_pose: Pose2 = field(default_factory=Pose2)
    base_covariance: FloatArray = field(default_factory=_no_covariance)

    def __post_init__(self) -> None:
        """Freeze the arrays; check the covariance and that robot and part share no EPC."""
        K, set_ = len(self.part.epcs), object.__setattr__
        set_(self, "part_tag_heights_m", read_only(self.part_tag_heights_m, "Observation.part_tag_heights_m", (K,)))
        set_(self, "base_covariance", read_covariance(self.base_covariance, "Observation.base_covariance"))
        if shared := sorted(set(self.anchors.epcs) & set(self.part.epcs)):
            raise InputError(f"stop {self.stop_id}: tags {shared} are both on robot and part", epcs=shared)


def read_covariance(value: FloatArray, name: str) -> FloatArray:
    """Freeze a 3 x 3 covariance of (x, y, θ).

    Raises:
        InputError: If it is not symmetric or has a negative eigenvalue.
    """
    covariance = read_only(value, name, (3, 3))
    if not np.allclose(covariance, covariance.T, rtol=1e-9, atol=1e-15):
        raise InputError(f"{name}: is not symmetric", name=name)
    if (smallest := float(np.linalg.eigvalsh(covariance)[0])) < -1e-9 * max(1.0, float(np.trace(covariance))):
        raise InputError(f"{name}: eigenvalue {smallest:.3g} is negative", name=name, eigenvalue=smallest)
    return covariance
