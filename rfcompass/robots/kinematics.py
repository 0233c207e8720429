"""Forward kinematics of a URDF through pinocchio, in terms of joint values and one chosen base frame."""

import copy
import threading
from functools import cached_property
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import RobotModelError
from rfcompass.robots.joint_map import read_joint_map
from rfcompass.robots.urdf_xml import axis_of, urdf_text, words


class Kinematics:
    """Poses of links in the base frame, for joint values in the model's order.

    A joint value is an angle [rad] or a travel [m] of a joint that follows no other; pinocchio's (cos, sin) pairs of
    continuous joints stay inside. May be shared among threads.

    Args:
        urdf: The robot.
        base_frame: Link that is the base frame; the root link if empty.

    Raises:
        RobotModelError: If pinocchio cannot use the URDF, the base frame is missing or moves against the root, or
            a joint has more than one degree of freedom.
    """

    def __init__(self, urdf: Element, base_frame: str = "") -> None:
        self.model = _build(urdf)
        self.base_frame = base_frame or _root_link(self.model)
        base = self.model.frames[self.frame_id(self.base_frame)]
        if base.parentJoint != 0:
            message = f"base frame {self.base_frame!r} moves with joint {self.model.names[base.parentJoint]!r}"
            raise RobotModelError(message, frame=self.base_frame)
        self.T_base_root = base.placement.inverse()
        self.joint_map = read_joint_map(urdf, list(self.model.names)[1:])
        self._scratch = threading.local()

    @property
    def joint_names(self) -> tuple[str, ...]:
        """URDF names of the free joints, in the order of the values (Q)."""
        return self.joint_map.names

    @cached_property
    def link_names(self) -> tuple[str, ...]:
        """All links."""
        return tuple(frame.name for frame in self.model.frames if frame.type == pin.FrameType.BODY)

    def frame_id(self, link: str) -> int:
        """Pinocchio's number of a link's frame.

        Raises:
            RobotModelError: If there is no such link; lists those that there are.
        """
        if not self.model.existFrame(link, pin.FrameType.BODY):
            message = f"robot {self.model.name!r} has no link {link!r}; it has: {', '.join(self.link_names)}"
            raise RobotModelError(message, link=link, links=list(self.link_names))
        return int(self.model.getFrameId(link, pin.FrameType.BODY))

    def joints_moving(self, link: str) -> tuple[str, ...]:
        """Names of the joints between the base and a link."""
        support = list(self.model.supports[self.model.frames[self.frame_id(link)].parentJoint])[1:]
        moves = (self.joint_map.gain[np.array(support, dtype=np.int64) - 1] != 0).any(axis=0)
        return tuple(name for name, is_moving in zip(self.joint_names, moves, strict=True) if is_moving)

    def poses(self, joints: FloatArray, frame_ids: list[int]) -> "list[pin.SE3]":
        """Poses `T_base_link` of some frames, by their numbers; joints (Q,)."""
        data = self._data
        pin.framesForwardKinematics(self.model, data, self.model_q(joints))
        return [self.T_base_root * data.oMf[i] for i in frame_ids]

    def point_jacobians(self, joints: FloatArray, frame_ids: list[int]) -> FloatArray:
        """Derivatives of the frames' origins in the base frame by the joint values, shape (F, 3, Q); joints (Q,)."""
        q, J = self.model_q(joints), np.zeros((len(frame_ids), 3, self.model.nv))
        if not q.size:  # pinocchio crashes on a robot that cannot move
            return J
        data, R = self._data, self.T_base_root.rotation
        pin.computeJointJacobians(self.model, data, q)
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        for row, i in enumerate(frame_ids):
            J[row] = R @ pin.getFrameJacobian(self.model, data, i, world)[:3]
        return J @ self.joint_map.gain

    def placement(self, frame_id: int) -> "tuple[int, pin.SE3]":
        """Joint that carries a frame (0 for the root) and the frame's pose in it."""
        frame = self.model.frames[frame_id]
        return frame.parentJoint, self._rooted(frame.parentJoint, frame.placement)

    def joint_placement(self, joint_id: int) -> "tuple[int, pin.SE3]":
        """Parent joint of a joint (0 for the base), and the joint's pose in it at rest."""
        parent = self.model.parents[joint_id]
        return parent, self._rooted(parent, self.model.jointPlacements[joint_id])

    def _rooted(self, parent: int, placement: "pin.SE3") -> "pin.SE3":
        """What hangs on the root is given in the base frame."""
        return placement if parent else self.T_base_root * placement

    @property
    def _data(self) -> Any:  # noqa: ANN401 - pinocchio has no types
        """Pinocchio's working memory, one for each thread."""
        if not hasattr(self._scratch, "data"):
            self._scratch.data = self.model.createData()
        return self._scratch.data

    @cached_property
    def _q_index(self) -> tuple[IntArray, IntArray]:
        """For each moving joint its place in pinocchio's q, and which of them are continuous."""
        joints = list(self.model.joints)[1:]
        places = np.array([joint.idx_q for joint in joints], dtype=np.int64)
        return places, np.flatnonzero([joint.nq == 2 for joint in joints])

    def model_q(self, joints: FloatArray) -> FloatArray:
        """Pinocchio's q, in which a continuous joint is (cos, sin); joints (Q,)."""
        positions = self.joint_map.positions(read_only(joints, "joints", (len(self.joint_names),)))
        places, endless = self._q_index
        q = np.empty(self.model.nq)
        q[places] = positions
        q[places[endless]] = np.cos(positions[endless])
        q[places[endless] + 1] = np.sin(positions[endless])
        return q


def _build(urdf: Element) -> Any:  # noqa: ANN401 - pinocchio has no types
    name = urdf.get("name", "")
    try:
        model = pin.buildModelFromXML(urdf_text(_bare(urdf)))
    except (ValueError, RuntimeError) as cause:
        reason = str(cause).rsplit("message:", maxsplit=1)[-1].strip().splitlines()[0]
        message = f"robot {name!r}: pinocchio cannot use its URDF: {reason}"
        raise RobotModelError(message, robot=name) from cause
    for joint_name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        if joint.nv > 1:
            message = f"joint {joint_name!r} of robot {name!r} has {joint.nv} degrees of freedom, not one"
            raise RobotModelError(message, joint=joint_name)
    return model


def _bare(urdf: Element) -> Element:
    """A copy of what kinematics need: no broken shape or colour can stop them, and every axis is a unit vector."""
    bare = copy.deepcopy(urdf)
    for link in bare.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    for material in bare.findall("material"):
        bare.remove(material)
    for joint in bare.findall("joint"):
        if joint.get("type") != "fixed" and (axis := joint.find("axis")) is not None:
            axis.set("xyz", words(axis_of(joint)))
    return bare


def _root_link(model: Any) -> str:  # noqa: ANN401 - pinocchio has no types
    return str(next(frame.name for frame in model.frames if frame.type == pin.FrameType.BODY))
