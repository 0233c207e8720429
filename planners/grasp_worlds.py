"""What may touch what in the course of a grasp: the part stands, lies between the fingers, hangs in the hand."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from planners.margins import Surroundings
from rfcompass.arrays import FloatArray
from rfcompass.robots import CollisionModel, Robot
from rfcompass.robots.hand import judge_grasp
from rfcompass.types.grasps import Contacts, Failure
from rfcompass.types.hands import Hand
from rfcompass.types.world import FLOOR, Body, Clearance, World

START_COLLISION = "start_collision"


@dataclass(eq=False)
class GraspWorlds:
    """The collision models of one part in one world.

    Args:
        robot: Robot with a hand.
        around: Floor and bodies in the present base frame, the part among them where it is thought to lie.
        part_name: Name of that body.
        fingers: Links that close on it.
    """

    robot: Robot
    around: Surroundings
    part_name: str
    fingers: Sequence[str]
    standing: CollisionModel = field(init=False)
    closing: CollisionModel = field(init=False)

    def __post_init__(self) -> None:
        """Build the models that all grasps share."""
        self.standing = CollisionModel(self.robot, self._world)
        freed = replace(self._part, may_touch=self._part.may_touch | set(self.fingers))
        self.closing = CollisionModel(self.robot, self._world.without(self.part_name).with_bodies(freed))

    @property
    def _world(self) -> World:
        return self.around.world

    @property
    def _part(self) -> Body:
        return next(body for body in self._world.bodies if body.name == self.part_name)

    def reaching(self, touching: Sequence[Clearance]) -> CollisionModel:
        """The model for the way from the start to the pre-grasp.

        The robot is where it is, so links of its own that overlap there do so by the coarseness of their shapes: such
        pairs may touch on the way.
        """
        if not touching:
            return self.standing
        return CollisionModel(self.robot, self._world, allowed=[(row.first, row.second) for row in touching])

    def holding(self, T_base_tool: FloatArray) -> CollisionModel:
        """The part in the hand; it may touch the fingers and what it lies on or leans against.

        Args:
            T_base_tool: Pose of the tool as it holds the part where it stands, shape (4, 4).
        """
        T_tool_part = np.linalg.inv(T_base_tool) @ self._part.T_parent_body
        T_tool_part[3] = 0, 0, 0, 1
        touches = {*self.fingers, FLOOR, *self._part.may_touch, *self.around.supports}
        return CollisionModel(
            self.robot, self._world.attach(self.part_name, self.robot.tool.frame, T_tool_part, touches)
        )  # fmt: skip

    def contacts(self, hand: Hand, T_base_hand: FloatArray, opening_m: float) -> Contacts | Failure:
        """Where the jaws close on the part as it stands, or why they do not hold it.

        Args:
            hand: The hand.
            T_base_hand: Pose of the tool frame, shape (4, 4).
            opening_m: Opening of the jaws as they come down [m].
        """
        T_part_hand = np.linalg.inv(self._part.T_parent_body) @ T_base_hand
        T_part_hand[3] = 0, 0, 0, 1
        return judge_grasp(hand, self._part.shape, T_part_hand, opening_m=opening_m)


def start_failure(robot: Robot, touching: Sequence[Clearance]) -> Failure | None:
    """The failure of a robot that touches something else than itself where it stands.

    Args:
        robot: Whose links.
        touching: Pairs that touch at the start, deepest first.
    """
    links = set(robot.kinematics.link_names)
    for row in touching:
        if not {row.first, row.second} <= links:
            depth_m = -row.distance_m
            message = f"where the robot stands now, {row.first} and {row.second} overlap by {depth_m * 1e3:.1f} mm"
            numbers = (("first", row.first), ("second", row.second), ("depth_m", depth_m))
            return Failure(START_COLLISION, message, numbers)
    return None
