"""From grasps of a part to poses of the hand in front of the robot, and the quick reasons against them.

A grasp is a pose in the part's frame; the part lies at its estimated pose. An arm that keeps its tool in a vertical
plane (`planar_arm`) can approach at a slant only in the plane through its first joint and the hand. So a slanted grasp
is turned about the vertical through the contacts until it lies in that plane: within the friction cone for a part with
faces, as far as need be for one that is round.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planners.antipodal import turn, without_twins
from planners.closed_form import BEYOND_LIMIT, REACHED, solve_all
from planners.grasp_question import is_round
from planners.planar_arm import PlanarArm
from rfcompass.arrays import FloatArray
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import Failure, GraspCandidate
from rfcompass.types.hands import Hand
from rfcompass.types.shapes import Shape

UNREACHABLE, JOINT_LIMIT, SCENE_COLLISION = "unreachable", "joint_limit", "scene_collision"
_UP = np.array([0.0, 0.0, 1.0])
# An approach this near to the vertical needs no turning.
_VERTICAL = 1e-9


@dataclass(frozen=True, slots=True)
class Turning:
    """How grasps may be turned about the vertical to suit an arm.

    Attributes:
        arm: Whose plane.
        depth_m: Distance of the contacts from the tool's origin, against the approach [m].
        most_rad: Largest turn [rad].
    """

    arm: PlanarArm
    depth_m: float
    most_rad: float


def turning_for(arm: PlanarArm, shape: Shape, depth_m: float, friction: float) -> Turning:
    """How grasps of a shape may be turned: any way if it is round about the vertical, else inside the friction cone."""
    return Turning(arm, depth_m, np.pi if is_round(shape) else float(np.arctan(friction)))


def into_arm_plane(
    candidates: Sequence[GraspCandidate], robot: Robot, T_base_part: FloatArray, turning: Turning
) -> list[GraspCandidate]:
    """Turn slanted grasps into the arm's plane; those that would have to turn too far are rejected.

    Args:
        candidates: Grasps in the part's frame; rejected ones stay as they are.
        robot: Whose tool.
        T_base_part: Pose of the part, shape (4, 4).
        turning: How they may be turned.
    """
    places = [i for i, row in enumerate(candidates) if row.rejection is None]
    if not places:
        return list(candidates)
    T = T_base_part @ np.array([candidates[i].T_part_hand for i in places])
    approach = T[:, :3, :3] @ robot.tool.approach_axis
    pivots = T[:, :3, 3] - turning.depth_m * approach
    angles = _angles(pivots, approach, turning.arm)
    turned = list(candidates)
    T_part_base = np.linalg.inv(T_base_part)
    for k, i in enumerate(places):
        if abs(angles[k]) > turning.most_rad:
            turned[i] = replace(turned[i], score=None, rejection=_turns_too_far(float(angles[k]), turning.most_rad))
        elif angles[k] != 0.0:
            turned[i] = replace(turned[i], T_part_hand=T_part_base @ _turned(T[k], pivots[k], float(angles[k])))
    return without_twins(turned, robot.tool)


def _angles(pivots: FloatArray, approach: FloatArray, arm: PlanarArm) -> FloatArray:
    """Turns that bring approaches (N, 3) into the arm's plane; 0 for vertical ones [rad], shape (N,)."""
    offsets = pivots[:, :2] - arm.axis_m
    # The approach may point outwards or back: half a turn of the plane is the same plane.
    angles = np.arctan2(offsets[:, 1], offsets[:, 0]) - np.arctan2(approach[:, 1], approach[:, 0])
    angles = (angles + np.pi / 2) % np.pi - np.pi / 2
    return np.where(np.hypot(approach[:, 0], approach[:, 1]) < _VERTICAL, 0.0, angles)


def _turns_too_far(angle_rad: float, most_rad: float) -> Failure:
    message = (
        f"to approach in the arm's plane the hand would have to turn by {np.rad2deg(abs(angle_rad)):.0f} degrees, "
        f"and friction holds {np.rad2deg(most_rad):.0f}"
    )
    return Failure(UNREACHABLE, message, (("turn_rad", angle_rad), ("most_rad", most_rad)))


def _turned(T: FloatArray, pivot: FloatArray, angle_rad: float) -> FloatArray:
    """A pose, turned about the vertical through a point, shape (4, 4)."""
    R, found = turn(_UP, angle_rad), np.eye(4)
    found[:3, :3] = R @ T[:3, :3]
    found[:3, 3] = pivot + R @ (T[:3, 3] - pivot)
    return found


def floor_failures(
    hand: Hand, T_base_hands: FloatArray, opening_m: float, floor_m: float | None
) -> list[Failure | None]:
    """Which hands would reach into the floor.

    Args:
        hand: Boxes that it is made of.
        T_base_hands: Poses of the tool frame, shape (N, 4, 4).
        opening_m: Opening of the jaws [m].
        floor_m: Height of the floor [m]; None where there is none.
    """
    if floor_m is None or not len(T_base_hands):
        return [None] * len(T_base_hands)
    low, high = hand.boxes_m(opening_m).transpose(1, 0, 2)
    upwards = T_base_hands[:, 2, :3] @ hand.R_tool_hand
    lowest = np.minimum(upwards[:, None] * low, upwards[:, None] * high).sum(axis=2).min(axis=1)
    depths = floor_m - (lowest + T_base_hands[:, 2, 3])
    return [_in_floor(float(depth)) if depth >= 0 else None for depth in depths]


def _in_floor(depth_m: float) -> Failure:
    message = f"the hand and the floor overlap by {depth_m * 1e3:.1f} mm"
    return Failure(SCENE_COLLISION, message, (("first", "hand"), ("second", "floor"), ("depth_m", depth_m)))


def reach_failures(
    arm: PlanarArm, robot: Robot, T_base_hands: FloatArray, start: Configuration
) -> list[Failure | None]:
    """Which hand poses an arm with a closed form does not get to, all at once.

    Args:
        arm: Its dimensions.
        robot: Whose.
        T_base_hands: Poses of the tool frame, shape (N, 4, 4).
        start: Present joints.
    """
    R, tool = T_base_hands[:, :3, :3], robot.tool
    tasks = np.concatenate([T_base_hands[:, :3, 3], R @ tool.approach_axis, R @ tool.closing_axis], axis=1)
    near = start.joints[[robot.joint_names.index(name) for name in robot.arm_joints]]
    _, status, joint, beyond = solve_all(arm, np.ascontiguousarray(tasks), near, True)
    return [
        _reach_failure(robot, tasks[i, :3], status[i], joint[i], beyond[i]) for i in range(len(tasks))
    ]  # fmt: skip


def _reach_failure(
    robot: Robot, point_m: FloatArray, status: FloatArray, joint: FloatArray, beyond: FloatArray
) -> Failure | None:
    if (status == REACHED).any():
        return None
    x, y, z = point_m
    where = f"({x:.3f}, {y:.3f}, {z:.3f}) m"
    if (status == BEYOND_LIMIT).any():
        least = int(np.where(status == BEYOND_LIMIT, beyond, np.inf).argmin())
        name, by = robot.arm_joints[int(joint[least])], float(beyond[least])
        message = f"at {where} joint {name} would have to go {by:.3f} beyond its limit"
        return Failure(JOINT_LIMIT, message, (("joint", name), ("beyond", by)))
    return Failure(UNREACHABLE, f"the arm cannot hold its tool at {where} as asked")
