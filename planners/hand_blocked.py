"""Does something stand where the hand would be? Asked before any inverse kinematics.

The palm and the open fingers are rigid to the tool frame, so where they are at a grasp depends on the grasp alone: if
they touch a body there, no posture of the arm and no place of the base does that grasp. Exact: coal's booleans of the
solids that every other check looks at, and much cheaper than to ask arm and base in vain.
"""

from collections.abc import Callable

import coal
import numpy as np
import pinocchio as pin

from planners.ik_failures import SCENE_COLLISION
from rfcompass.arrays import FloatArray
from rfcompass.robots import CollisionModel
from rfcompass.robots.collision_pairs import joint_of
from rfcompass.robots.quick_collisions import coal_shape
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import Failure
from rfcompass.types.world import WORLD

HandBlocked = Callable[[FloatArray], Failure | None]


def hand_blocked(model: CollisionModel, opened: Configuration, part_name: str) -> HandBlocked:
    """Return a function that says what stands where a hand would be, if anything does.

    Args:
        model: Robot and world, in the present base frame. The floor is not looked at.
        opened: Any posture with the hand open.
        part_name: The part, which is another question.

    Returns:
        From the pose of the tool frame (4, 4) to the failure `"scene_collision"`, or None.
    """
    robot, solids = model.robot, model.solids
    tool_joint, parents = joint_of(robot, robot.tool.frame), robot.kinematics.model.supports
    T_tool_base = robot.tool_pose(opened).inverse()

    def is_of_hand(i: int) -> bool:
        return solids[i].carrier != WORLD and tool_joint in parents[joint_of(robot, solids[i].carrier)]

    def stands(i: int) -> bool:
        return solids[i].carrier == WORLD and solids[i].owner != part_name

    pairs = [(i, j) for i, j in model.pairs if is_of_hand(i) and stands(j)]
    shapes = {i: coal_shape(solids[i]) for pair in pairs for i in pair}
    still = {j: _placed(pin.SE3(solids[j].T_carrier_solid)) for _, j in pairs}
    in_tool = {
        i: T_tool_base * robot.link_pose(opened, solids[i].carrier) * pin.SE3(solids[i].T_carrier_solid)
        for i, _ in pairs
    }  # fmt: skip
    request = coal.CollisionRequest()

    def blocked(T_base_hand: FloatArray) -> Failure | None:
        T = pin.SE3(T_base_hand[:3, :3], T_base_hand[:3, 3])
        placed = {i: _placed(T * T_tool_solid) for i, T_tool_solid in in_tool.items()}
        for i, j in pairs:
            if coal.collide(shapes[i], placed[i], shapes[j], still[j], request, coal.CollisionResult()):
                return _in_the_way(solids[i].owner, solids[j].owner)
        return None

    return blocked


def _placed(T: "pin.SE3") -> "coal.Transform3s":
    return coal.Transform3s(np.array(T.rotation), np.array(T.translation))


def _in_the_way(link: str, body: str) -> Failure:
    message = f"{body} stands where {link} would be at the grasp"
    return Failure(SCENE_COLLISION, message, (("first", link), ("second", body)))
