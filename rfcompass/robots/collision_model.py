"""What two independent collision checkers share: the solids of a robot and its world, and the pairs to look at."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import RobotModelError, ShapeError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots.collision_pairs import Pair, above_floor, allowed_pairs, checked_pairs, joint_of, touch_pairs
from rfcompass.robots.robot import Robot
from rfcompass.robots.solids import Solid, body_solids, padded, robot_solids
from rfcompass.types.world import WORLD, World


@dataclass(frozen=True, eq=False)
class CollisionModel:
    """A robot in its world.

    Args:
        robot: Whose links.
        world: Floor and bodies, some of which may ride on a link.
        padding_m: Distance to keep from things: each link grows by at least this much to all sides [m]. Two links
            then keep twice this distance from each other.
        with_tags: Take the tags for solid bodies as well.
        allowed: Pairs of links or bodies that may touch, beside neighbours and what the bodies allow themselves.

    Raises:
        RobotModelError: If a mesh is missing, or a body rides on an unknown link, or a name in `allowed` is unknown.
        ShapeError: If the padding is negative or not finite.
    """

    robot: Robot
    world: World = field(default_factory=World)
    padding_m: float = 0.0
    with_tags: bool = False
    allowed: Iterable[tuple[str, str]] = ()
    solids: tuple[Solid, ...] = field(init=False, repr=False)
    pairs: tuple[tuple[int, int], ...] = field(init=False, repr=False)
    over_floor: tuple[int, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Collect solids and pairs."""
        if not (np.isfinite(self.padding_m) and self.padding_m >= 0):
            raise ShapeError(f"padding_m is {self.padding_m}, not a finite distance >= 0", name="padding_m")
        links = tuple(padded(solid, self.padding_m) for solid in robot_solids(self.robot, with_tags=self.with_tags))
        self._check_bodies()
        solids = (*links, *(solid for body in self.world.bodies for solid in body_solids(body)))
        allowed = self._allowed | touch_pairs(self.world.bodies)
        object.__setattr__(self, "solids", solids)
        object.__setattr__(self, "pairs", tuple(checked_pairs(self.robot, solids, allowed)))
        floor = () if self.world.floor_m is None else above_floor(self.robot, solids, allowed)
        object.__setattr__(self, "over_floor", tuple(floor))

    def _check_bodies(self) -> None:
        links = set(self.robot.kinematics.link_names)
        for body in self.world.bodies:
            if body.name in links:
                raise RobotModelError(f"body {body.name!r} is called like a link of {self.robot.name}", body=body.name)
            if not body.stands_still:
                self.robot.kinematics.frame_id(body.parent)

    @property
    def _allowed(self) -> frozenset[Pair]:
        bodies = (body.name for body in self.world.bodies)
        return allowed_pairs(self.allowed, (*self.robot.kinematics.link_names, *bodies))

    @cached_property
    def carriers(self) -> tuple[str, ...]:
        """Links that carry solids, each once."""
        return tuple(dict.fromkeys(solid.carrier for solid in self.solids if solid.carrier != WORLD))

    @cached_property
    def joints_of_solids(self) -> tuple[int, ...]:
        """Number of the joint that moves each solid; 0: rigid to the base, -1: stands in the world."""
        return tuple(joint_of(self.robot, solid.carrier) for solid in self.solids)


def homogeneous(pose: Pose2) -> FloatArray:
    """A pose in the plane as a homogeneous pose in space, shape (4, 4)."""
    T = np.eye(4)
    T[:2, :2], T[:2, 3] = pose.rotation, pose.translation_m
    return T
