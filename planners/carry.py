"""A posture to carry a part in: straight up from where the grasp ended, clear of the floor."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from planners.certificates import certify
from planners.grasp_worlds import GraspWorlds
from planners.hand_joints import hand_joints
from planners.ik import IkRules, InverseKinematics
from planners.margins import Surroundings
from planners.straight_motion import StraightMotion, move_straight
from rfcompass.arrays import FloatArray
from rfcompass.robots import FclCollisions, Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasp_task import GraspTask
from rfcompass.types.grasps import GraspPlan
from rfcompass.types.parts import Part
from rfcompass.types.record import Record
from rfcompass.types.world import Body, World

# Ours: how much further to lift a part for a drive [m]; the first that the arm can do.
RAISES_M = (0.15, 0.10, 0.05)


@dataclass(frozen=True, slots=True)
class Carry(Record):
    """How a part is carried.

    Attributes:
        joints: The way up from where the grasp ended, shape (C, Q); one posture if the arm can go no higher.
        floor_m: Height of the part's lowest point over the floor while it is carried [m], as believed.
    """

    joints: FloatArray
    floor_m: float


def plan_carry(robot: Robot, part: Part, plan: GraspPlan, raises_m: Sequence[float] = RAISES_M) -> Carry:
    """Plan the way from the end of a grasp to the posture in which the part is carried.

    The way is straight up and checked without gaps, with the part in the hand; fcl certifies it. Where the arm can do
    none of the raises, the part is carried as the grasp ended, which its plan has certified.

    Args:
        robot: Who holds the part.
        part: What it holds.
        plan: The grasp that was carried out.
        raises_m: Heights to try, in order [m].
    """
    T_base_part = plan.T_base_hand @ np.linalg.inv(plan.T_part_hand)
    T_base_part[3] = 0, 0, 0, 1
    standing = Surroundings(World((Body(part.part_id, part.shape, T_base_part),)), frozenset())
    worlds = GraspWorlds(robot, standing, part.part_id, hand_joints(robot).fingers)
    model = worlds.holding(plan.T_base_hand)
    ik, fcl = InverseKinematics(robot, model=model, rules=IkRules(certify=False, explain=False)), FclCollisions(model)
    last = Configuration(plan.retreat[-1])
    task = GraspTask.of_pose(robot.tool_pose(last).homogeneous, robot.tool.approach_axis, robot.tool.closing_axis)
    joints = plan.retreat[-1:]
    for raise_m in raises_m:
        way = move_straight(ik, task, last, np.array([0.0, 0.0, raise_m]))
        if isinstance(way, StraightMotion):
            path = [Configuration(row) for row in way.path]
            if certify(fcl, "carry", path, way.report).apart:
                joints = way.path
                break
    T_hand_part = np.linalg.inv(plan.T_part_hand)
    T_base_hand = robot.tool_pose(Configuration(joints[-1])).homogeneous
    return Carry(joints, _lowest_m(part, T_base_hand @ T_hand_part))


def _lowest_m(part: Part, T_base_part: FloatArray) -> float:
    """Height of the lowest corner of the part's bounding box [m]."""
    corners_m = np.array(list(product(*zip(part.shape.lower_m, part.shape.upper_m, strict=True))))
    return float((corners_m @ T_base_part[2, :3] + T_base_part[2, 3]).min())
