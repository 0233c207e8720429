"""Forward kinematics as casadi expressions, folded from the placements of pinocchio's model.

    T_base_link = Π_j  T_parent_j · M_j(q_j) · T_link,    M_j a turn about, or a slide along, the axis of joint j

The packaged pinocchio has no casadi bindings; this equals its numbers to rounding.
"""

from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import pinocchio as pin

from rfcompass.arrays import FloatArray
from rfcompass.robots import Robot

# Entries of a placement below this are rounding; as zeros they drop out of the expressions.
_ZERO = 1e-15


class Pose(NamedTuple):
    """A pose of casadi expressions: rotation (3, 3) and position [m] (3)."""

    R: Any
    p: Any

    def __matmul__(self, other: "Pose") -> "Pose":
        """Compose two poses."""
        return Pose(self.R @ other.R, self.R @ other.p + self.p)

    def act(self, point: Any) -> Any:  # noqa: ANN401 - casadi has no types
        """Move a point, shape (3)."""
        return self.R @ point + self.p


class SymbolicKinematics:
    """Poses of links for symbolic joint values.

    Args:
        robot: Any robot.
        joints: Expressions of all joint values, in the order of `joint_names` (Q).
        base: Pose of the base in the frame of the answers; the identity if None.
    """

    def __init__(self, robot: Robot, joints: Any, base: Pose | None = None) -> None:  # noqa: ANN401
        self._kinematics = robot.kinematics
        joint_map = self._kinematics.joint_map
        self._positions = ca.DM(_sparse(joint_map.gain)) @ joints + joint_map.offset
        self._poses = {0: base or Pose(ca.DM.eye(3), ca.DM.zeros(3, 1))}

    def pose(self, link: str) -> Pose:
        """Pose of a link.

        Raises:
            RobotModelError: If there is no such link.
        """
        joint, T = self._kinematics.placement(self._kinematics.frame_id(link))
        return self._joint_pose(joint) @ constant(T.rotation, T.translation)

    def _joint_pose(self, joint: int) -> Pose:
        if joint not in self._poses:
            parent, T = self._kinematics.joint_placement(joint)
            motion = _motion(self._kinematics.model, joint, self._positions[joint - 1])
            self._poses[joint] = self._joint_pose(parent) @ constant(T.rotation, T.translation) @ motion
        return self._poses[joint]


def constant(R: FloatArray, p: FloatArray) -> Pose:
    """A pose of numbers."""
    return Pose(ca.DM(_sparse(R)), ca.DM(_sparse(p)))


def planar(x_m: Any, y_m: Any, theta_rad: Any) -> Pose:  # noqa: ANN401
    """A pose in the floor plane."""
    c, s = ca.cos(theta_rad), ca.sin(theta_rad)
    R = ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))
    return Pose(R, ca.vertcat(x_m, y_m, 0))


def _motion(model: Any, joint: int, value: Any) -> Pose:  # noqa: ANN401
    """Turn about, or slide along, the axis of a joint: R = I + sin [a]x + (1 - cos) [a]x²."""
    linear, angular = joint_axis(model, joint)
    if np.any(linear):
        return Pose(ca.DM.eye(3), ca.DM(_sparse(linear)) * value)
    a = _sparse(angular)
    skew = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    R = ca.DM.eye(3) + ca.sin(value) * ca.DM(skew) + (1 - ca.cos(value)) * ca.DM(_sparse(skew @ skew))
    return Pose(R, ca.DM.zeros(3, 1))


def joint_axis(model: Any, joint: int) -> tuple[FloatArray, FloatArray]:  # noqa: ANN401
    """Axis of a joint in its own frame: along which it slides, about which it turns; one of the two is zero."""
    joint_model = model.joints[joint]
    data = joint_model.createData()
    joint_model.calc(data, pin.neutral(model))
    S = np.asarray(data.S).reshape(6)
    return S[:3], S[3:]


def _sparse(values: FloatArray) -> FloatArray:
    return np.where(np.abs(values) < _ZERO, 0.0, values)
