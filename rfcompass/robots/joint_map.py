"""Joints that follow others (`<mimic>`): from the values of the free joints to the positions of all."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import RobotModelError
from rfcompass.robots.urdf_xml import vector
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class JointMap(Record):
    """positions = gain · values + offset.

    Attributes:
        names: Free joints, in the order of the values (Q).
        gain: One non-zero entry at most in each row, shape (J, Q).
        offset: [rad or m], shape (J,).
    """

    names: tuple[str, ...]
    gain: FloatArray
    offset: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "gain", read_only(self.gain, "JointMap.gain", (None, len(self.names))))
        object.__setattr__(self, "offset", read_only(self.offset, "JointMap.offset", (len(self.gain),)))

    def positions(self, values: FloatArray) -> FloatArray:
        """Positions of all moving joints, shape (J,), for the values of the free ones (Q)."""
        return np.asarray(self.gain @ values + self.offset)


def read_joint_map(urdf: Element, moving: Sequence[str]) -> JointMap:
    """Read who follows whom.

    A joint that follows a fixed joint, or one that does not exist, stays at its offset.

    Args:
        urdf: The robot.
        moving: Names of its moving joints, in the order of the positions (J).

    Raises:
        RobotModelError: If joints follow each other in a ring, or a multiplier is no number.
    """
    joints = {joint.get("name", ""): joint for joint in urdf.findall("joint")}
    free = [name for name in moving if joints[name].find("mimic") is None]
    gain, offset = np.zeros((len(moving), len(free))), np.zeros(len(moving))
    for j, name in enumerate(moving):
        leader, scale, offset[j] = _follow(name, joints)
        if leader in free:
            gain[j, free.index(leader)] = scale
    return JointMap(tuple(free), gain, offset)


def _follow(name: str, joints: Mapping[str, Element]) -> tuple[str, float, float]:
    """Last joint of a chain of followers, and the scale and offset from its value to the position of the first."""
    scale, offset, leader, seen = 1.0, 0.0, name, [name]
    while leader in joints and (mimic := joints[leader].find("mimic")) is not None:
        offset += scale * float(vector(mimic, "offset", (0.0,))[0])
        scale *= float(vector(mimic, "multiplier", (1.0,))[0])
        leader = mimic.get("joint", "")
        if leader in seen:
            raise RobotModelError(f"joints follow each other in a ring: {' -> '.join([*seen, leader])}", joint=name)
        seen.append(leader)
    return leader, scale, offset
