"""A robot: what its description says, with the kinematics that put its tags into the base frame."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import RobotModelError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots.description import RobotDescription, Tool
from rfcompass.robots.kinematics import Kinematics
from rfcompass.robots.limits import JointLimits, read_limits
from rfcompass.robots.shapes import LinkShape, read_collisions, read_visuals
from rfcompass.robots.tagging import tag_links, with_tags
from rfcompass.robots.urdf_xml import read_urdf
from rfcompass.types.configuration import Configuration
from rfcompass.types.placed_shape import PlacedShape
from rfcompass.types.tags import TagLayout, TagPositions


@dataclass(frozen=True, eq=False)
class Robot:
    """Any robot with tags on it.

    The frame "base" of every answer is the description's base frame. A mobile robot's lies on the floor
    (`base_footprint`), so that z is the height above the floor.

    Args:
        description: URDF, tag layout, tool and postures.

    Raises:
        RobotModelError: If the URDF cannot be used, or the layout, the tool or a posture does not fit it.
    """

    description: RobotDescription
    kinematics: Kinematics = field(init=False, repr=False)
    limits: JointLimits = field(init=False, repr=False)
    _urdf: Element = field(init=False, repr=False)
    _shapes: tuple[LinkShape, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Read the URDF, mount the tags and check that everything named exists."""
        described = self.description
        urdf = with_tags(read_urdf(described.urdf), described.layout)
        object.__setattr__(self, "_urdf", urdf)
        object.__setattr__(self, "kinematics", Kinematics(urdf, described.base_frame))
        object.__setattr__(self, "limits", read_limits(urdf, self.joint_names))
        object.__setattr__(self, "_shapes", read_visuals(urdf, described.urdf, described.package_dirs))
        if described.tool is not None:
            self.kinematics.frame_id(described.tool.frame)
        for name in described.postures:
            self.check_limits(self.posture(name))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as the description; the other process builds its own model."""
        return Robot, (self.description,)

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self.description.name

    @property
    def layout(self) -> TagLayout:
        """How the tags are mounted."""
        return self.description.layout

    @property
    def is_mobile(self) -> bool:
        """True if the base drives."""
        return self.description.base == "planar"

    @property
    def joint_names(self) -> tuple[str, ...]:
        """URDF names of the moving joints, in the order of a configuration (Q)."""
        return self.kinematics.joint_names

    @property
    def tool(self) -> Tool:
        """Where the robot grasps.

        Raises:
            RobotModelError: If the description does not say so.
        """
        if self.description.tool is None:
            raise RobotModelError(f"robot {self.name}: its description names no tool frame", robot=self.name)
        return self.description.tool

    @property
    def arm_joints(self) -> tuple[str, ...]:
        """Names of the joints between base and tool.

        Raises:
            RobotModelError: If the description names no tool.
        """
        return self.kinematics.joints_moving(self.tool.frame)

    def configuration(
        self, joints: Mapping[str, float] | npt.ArrayLike | None = None, base: Pose2 | None = None
    ) -> Configuration:
        """Make a configuration.

        Args:
            joints: All values in the order of `joint_names`, shape (Q,), or some by name, the others at rest: at
                zero, or the nearest value inside the limits.
            base: Pose `T_world_base`; the origin if None.

        Raises:
            RobotModelError: If a joint name is not known; lists those that are.
            ShapeError: If an array has not Q values.
        """
        if joints is None or isinstance(joints, Mapping):
            joints = self._named(joints or {})
        values = read_only(joints, f"joints of {self.name}", (len(self.joint_names),))
        return Configuration(values, base or Pose2())

    def _named(self, joints: Mapping[str, float]) -> FloatArray:
        if unknown := sorted(set(joints) - set(self.joint_names)):
            message = f"robot {self.name} has no joint {unknown[0]!r}; it has: {', '.join(self.joint_names)}"
            raise RobotModelError(message, joint=unknown[0], joints=list(self.joint_names))
        at_rest = np.clip(0.0, self.limits.soft_lower, self.limits.soft_upper)
        return np.array([joints.get(name, rest) for name, rest in zip(self.joint_names, at_rest, strict=True)])

    def posture(self, name: str, base: Pose2 | None = None) -> Configuration:
        """Take a named posture of the description.

        Raises:
            RobotModelError: If there is none of that name; lists those that there are.
        """
        if name not in self.description.postures:
            known = sorted(self.description.postures)
            message = f"robot {self.name} has no posture {name!r}; it has: {', '.join(known) or 'none'}"
            raise RobotModelError(message, posture=name, known=known)
        return self.configuration(self.description.postures[name], base)

    def check_limits(self, configuration: Configuration, *, soft: bool = False) -> None:
        """Accept a configuration inside the joint limits.

        Args:
            configuration: What to check.
            soft: Apply the narrower limits of the safety controller, where the URDF has them.

        Raises:
            JointLimitError: For the first joint outside; names joint, value and limits.
        """
        self.limits.check(self._joints(configuration), soft=soft)

    def tag_positions(self, configuration: Configuration) -> TagPositions:
        """Positions of all tags in the base frame: forward kinematics at this configuration."""
        poses = self.kinematics.poses(configuration.joints, self._tag_ids)
        points_m = np.array([T.translation for T in poses]).reshape(-1, 3)
        return TagPositions("base", self.layout.epcs, points_m)

    def tag_dipoles(self, configuration: Configuration) -> FloatArray:
        """Directions of all tags' electrical axes in the base frame, unit vectors, shape (N, 3)."""
        links = [self.kinematics.frame_id(link) for link in self.layout.frames]
        poses = self.kinematics.poses(configuration.joints, links)
        turned = [T.rotation @ dipole for T, dipole in zip(poses, self.layout.dipoles, strict=True)]
        return np.array(turned).reshape(-1, 3)

    def tag_positions_batch(self, joints: npt.ArrayLike) -> FloatArray:
        """Positions of all tags in the base frame at many configurations [m], shape (B, N, 3).

        Args:
            joints: Joint values in the order of `joint_names`, shape (B, Q).
        """
        from rfcompass.robots.joint_chain import tag_points  # noqa: PLC0415 - numba is slow to import

        values = read_only(joints, f"joints of {self.name}", (None, len(self.joint_names)))
        return np.asarray(tag_points(self._chain, values))

    def tag_jacobians(self, configuration: Configuration) -> FloatArray:
        """Derivatives of the tags' base-frame positions by the joint values [m/rad or m/m], shape (N, 3, Q)."""
        return self.kinematics.point_jacobians(configuration.joints, self._tag_ids)

    def link_pose(self, configuration: Configuration, link: str) -> "pin.SE3":
        """Pose `T_base_link`.

        Raises:
            RobotModelError: If there is no such link; lists those that there are.
        """
        return self.kinematics.poses(configuration.joints, [self.kinematics.frame_id(link)])[0]

    def tool_pose(self, configuration: Configuration) -> "pin.SE3":
        """Pose `T_base_tool`.

        Raises:
            RobotModelError: If the description names no tool.
        """
        return self.link_pose(configuration, self.tool.frame)

    def visual_shapes(self, configuration: Configuration) -> tuple[PlacedShape, ...]:
        """All shapes to draw, tags included, placed in the world (z = 0 is the height of the base frame)."""
        T_world_base = _lifted(configuration.base)
        links = sorted({shape.link for shape in self._shapes})
        poses = self.kinematics.poses(configuration.joints, [self.kinematics.frame_id(link) for link in links])
        T_world = {link: T_world_base @ T.homogeneous for link, T in zip(links, poses, strict=True)}
        return tuple(shape.placed(T_world[shape.link]) for shape in self._shapes)

    @cached_property
    def collision_shapes(self) -> tuple[LinkShape, ...]:
        """All shapes that bump into things, in their links.

        Raises:
            RobotModelError: If a mesh is missing.
        """
        return read_collisions(self._urdf, self.description.urdf, self.description.package_dirs)

    @property
    def tag_shapes(self) -> tuple[LinkShape, ...]:
        """The tags as solid bodies, in their links: for checks in which a tag must not be bent."""
        links = set(tag_links(self.layout))
        return tuple(shape for shape in self._shapes if shape.link in links)

    def _joints(self, configuration: Configuration) -> FloatArray:
        return read_only(configuration.joints, f"joints of {self.name}", (len(self.joint_names),))

    @cached_property
    def _tag_ids(self) -> list[int]:
        return [self.kinematics.frame_id(link) for link in tag_links(self.layout)]

    @cached_property
    def _chain(self) -> Any:  # noqa: ANN401 - its type would import numba
        from rfcompass.robots.build_chain import build_chain  # noqa: PLC0415

        return build_chain(self.kinematics, self._urdf, tag_links(self.layout))


def _lifted(pose: Pose2) -> FloatArray:
    """A pose in the plane as a homogeneous pose in space, shape (4, 4)."""
    T = np.eye(4)
    T[:2, :2], T[:2, 3] = pose.rotation, pose.translation_m
    return T
