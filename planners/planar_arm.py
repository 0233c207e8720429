"""Arms that yaw, pitch three times and roll, such as the youBot's: their dimensions, read from any model.

Joint 1 turns about the vertical, joints 2 to 4 about parallel horizontal axes, joint 5 about the tool's approach axis,
and the tool point lies on that axis. The tool then never leaves the vertical plane through joint 1, the *arm plane*.
In it, angles count from the vertical towards e_r, the horizontal direction to which a positive pitch leans:

    heading ψ = ψ0 + s1 q1                    of e_r
    link 2 at φ2 = α2 + s2 q2                 link 3 at φ3 = α3 + s2 q2 + s3 q3
    approach at p = αa + s2 q2 + s3 q3 + s4 q4    roll ρ = ρ0 + s5 q5

with angles at q = 0 and signs s = ±1 of the axes.
"""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from planners.symbolic_fk import joint_axis
from rfcompass.arrays import FloatArray
from rfcompass.robots import Robot

_SAME = 1e-9


class PlanarArm(NamedTuple):
    """Dimensions of a yaw-pitch-pitch-pitch-roll arm in the base frame.

    Attributes:
        axis_m: Where the axis of joint 1 stands, x and y [m], shape (2,).
        shoulder_m: Joint 2 in the arm plane, from that axis at the floor: r, z [m], shape (2,).
        upper_m: Distance between joints 2 and 3 [m].
        lower_m: Distance between joints 3 and 4 [m].
        hand_m: Tool from joint 4, along the approach axis and towards e_r of an upright tool [m], shape (2,).
        angles_rad: ψ0, α2, α3, αa, ρ0 [rad], shape (5,).
        signs: s1 to s5, shape (5,).
        lower: Joint limits [rad], shape (5,).
        upper: Joint limits [rad], shape (5,).
    """

    axis_m: FloatArray
    shoulder_m: FloatArray
    upper_m: float
    lower_m: float
    hand_m: FloatArray
    angles_rad: FloatArray
    signs: FloatArray
    lower: FloatArray
    upper: FloatArray


def read_planar_arm(robot: Robot, *, soft: bool = False) -> PlanarArm | None:
    """Read the dimensions of a robot's arm; None if it is of another kind.

    Args:
        robot: Robot with a tool.
        soft: Take the narrower limits of the safety controller.

    Raises:
        RobotModelError: If the description names no tool.
    """
    joints = _JointFrames(robot)
    if len(joints.axes) != 5 or not joints.plain:
        return None
    up, (z1, z2, z3, z4, z5) = np.array([0.0, 0.0, 1.0]), joints.axes
    normal = z2
    e_r = np.cross(normal, up)
    tool, approach, closing = joints.tool
    right_angles = [z1 @ normal, normal @ up, z5 @ normal, (joints.points[1:] - joints.points[0]) @ normal]
    parallel = [np.abs(z1 @ up) - 1, *(np.abs([z3, z4] @ normal) - 1), np.abs(z5 @ approach) - 1]
    on_axis = np.cross(tool - joints.points[4], z5)
    if max(np.abs(np.hstack([*right_angles, parallel, on_axis]))) > _SAME:
        return None

    def in_plane(vector: FloatArray) -> FloatArray:
        return np.array([vector @ e_r, vector @ up])

    p1, p2, p3, p4, _ = joints.points
    v2, v3, a = in_plane(p3 - p2), in_plane(p4 - p3), in_plane(approach)
    lean = np.array([a[1], -a[0]])
    angles = [np.arctan2(e_r[1], e_r[0]), np.arctan2(*v2), np.arctan2(*v3), np.arctan2(*a)]
    roll = np.arctan2(closing @ normal, in_plane(closing) @ lean)
    signs = np.sign([z1 @ up, 1.0, z3 @ normal, z4 @ normal, z5 @ approach])
    hand = in_plane(tool - p4)
    lower, upper = joints.limits(soft)
    shoulder = np.array([(p2 - p1) @ e_r, p2[2]])
    return PlanarArm(
        p1[:2], shoulder, float(np.linalg.norm(v2)), float(np.linalg.norm(v3)), np.array([hand @ a, hand @ lean]),
        np.array([*angles, roll]), signs, lower, upper,
    )  # fmt: skip


class _JointFrames:
    """Axes and origins of the arm's joints, and the tool, in the base frame with every joint at zero."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        kinematics = robot.kinematics
        model, names = kinematics.model, list(kinematics.model.names)
        data = model.createData()
        pin.forwardKinematics(model, data, pin.neutral(model))
        self._ids = [names.index(name) for name in robot.arm_joints]
        poses = [kinematics.T_base_root * data.oMi[i] for i in self._ids]
        self.axes = [T.rotation @ joint_axis(model, i)[1] for T, i in zip(poses, self._ids, strict=True)]
        self.points = np.array([T.translation for T in poses])
        T = robot.tool_pose(robot.configuration(np.zeros(len(robot.joint_names))))
        self.tool = T.translation, T.rotation @ robot.tool.approach_axis, T.rotation @ robot.tool.closing_axis

    @property
    def plain(self) -> bool:
        """True if each joint of the arm turns by its own value, and nothing else moves the tool."""
        model, joint_map = self._robot.kinematics.model, self._robot.kinematics.joint_map
        rows = np.array(self._ids) - 1
        gain = joint_map.gain[rows][:, self._columns]
        turning = all("R" in model.joints[i].shortname() and model.joints[i].nq == 1 for i in self._ids)
        frame = model.frames[self._robot.kinematics.frame_id(self._robot.tool.frame)]
        chain = [i for i in model.supports[frame.parentJoint] if i > 0]
        return turning and chain == self._ids and bool((gain == np.eye(len(rows))).all())

    def limits(self, soft: bool) -> tuple[FloatArray, FloatArray]:
        limits = self._robot.limits
        lower, upper = (limits.soft_lower, limits.soft_upper) if soft else (limits.lower, limits.upper)
        return lower[self._columns], upper[self._columns]

    @property
    def _columns(self) -> list[int]:
        return [self._robot.joint_names.index(name) for name in self._robot.arm_joints]
