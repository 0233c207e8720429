"""How a robot's fingers are driven: which joints, and their values for an opening."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.hands import Hand


@dataclass(frozen=True, slots=True)
class HandJoints:
    """The fingers of one robot.

    Attributes:
        fingers: Links that slide against the palm.
        columns: Their joints, as places in a configuration, shape (F,).
        opened: Values at the greatest opening of the URDF [m], shape (F,).
        closing: Direction in which each value changes while the hand closes, +1 or -1, shape (F,).
        least: Lower limits [m], shape (F,).
        most: Upper limits [m], shape (F,).
    """

    fingers: tuple[str, ...]
    columns: IntArray
    opened: FloatArray
    closing: FloatArray
    least: FloatArray
    most: FloatArray

    def at_opening(self, configuration: Configuration, hand: Hand, opening_m: float) -> Configuration:
        """The same posture with the jaws this far apart, or as far as their joints go; both move by half.

        A hand whose fingers are mounted wider than the URDF's has the same travel from its greatest opening.
        """
        travel = (hand.greatest_m - opening_m) / 2
        joints = configuration.joints.copy()
        joints[self.columns] = np.clip(self.opened + self.closing * travel, self.least, self.most)
        return Configuration(joints, configuration.base)


def hand_joints(robot: Robot) -> HandJoints:
    """Find the joints of a robot's fingers; the hand itself is read and checked by `robots.hand_of`.

    Raises:
        RobotModelError: If the description names no tool.
    """
    arm = set(robot.arm_joints)
    moved_by = {link: robot.kinematics.joints_moving(link) for link in robot.kinematics.link_names}
    shaped = {shape.link for shape in robot.collision_shapes}
    fingers = [link for link, names in moved_by.items() if link in shaped and set(names) > arm]
    names = sorted({name for link in fingers for name in moved_by[link]} - arm, key=robot.joint_names.index)
    columns = np.array([robot.joint_names.index(name) for name in names], dtype=np.int64)
    least, most = robot.limits.lower[columns], robot.limits.upper[columns]
    wide = [_reach_m(robot, fingers, columns, ends) for ends in (least, most)]
    opens_upwards = wide[1] > wide[0]
    opened = most if opens_upwards else least
    closing = np.full(len(columns), -1.0 if opens_upwards else 1.0)
    return HandJoints(tuple(fingers), columns, opened, closing, least, most)


def _reach_m(robot: Robot, fingers: list[str], columns: IntArray, values: FloatArray) -> float:
    """Distance of the fingers' frames from the tool along the closing axis, summed up [m]."""
    joints = robot.configuration().joints.copy()
    joints[columns] = values
    configuration = Configuration(joints)
    T_tool_base = robot.tool_pose(configuration).inverse()
    places = [(T_tool_base * robot.link_pose(configuration, link)).translation for link in fingers]
    return float(np.abs(np.array(places) @ robot.tool.closing_axis).sum())
