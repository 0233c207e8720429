"""The hand of a robot, read from its URDF: palm and two fingers as boxes in the hand's own axes.

Every collision shape becomes its bounding box along those axes. That is exact for boxes that are mounted straight, as
the youBot's are; other shapes grow, so that a hand of meshes touches a little early.
"""

from collections.abc import Sequence

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import RobotModelError
from rfcompass.robots.collision_pairs import joint_of
from rfcompass.robots.grasp_batch import VERDICTS, judge_grasps
from rfcompass.robots.grasp_judge import judge_grasp
from rfcompass.robots.robot import Robot
from rfcompass.robots.solids import Solid, robot_solids
from rfcompass.types.configuration import Configuration
from rfcompass.types.hands import FRICTION, GRIP_N, Hand, Jaw

__all__ = ["VERDICTS", "Hand", "hand_of", "judge_grasp", "judge_grasps", "opening_at"]

# Ours: what lies this near to the plane of a finger's inner face belongs to it [m].
_FLUSH_M = 0.001


def hand_of(robot: Robot, *, with_tags: bool = False, friction: float = FRICTION, grip_n: float = GRIP_N) -> Hand:
    """Read a robot's hand: what moves with its tool frame is the palm, what slides against that are the jaws.

    Args:
        robot: Any robot whose two fingers slide along the tool's closing axis.
        with_tags: Take the tags for solid bodies as well.
        friction: Coefficient of friction between jaw and part; ours.
        grip_n: Force with which each jaw presses [N]; ours.

    Raises:
        RobotModelError: If the description names no tool, or the hand is not of this kind: fingers that turn, none,
            only one, or a third; the message says which joint.
    """
    tool, solids = robot.tool, robot_solids(robot, with_tags=with_tags)
    palm = [solid for solid in solids if joint_of(robot, solid.carrier) == joint_of(robot, tool.frame)]
    fingers = [solid for solid in solids if _is_finger(robot, solid)]
    ends = _ends_of_travel(robot, fingers)
    lower, upper = (_bounds_at(robot, fingers, configuration) for configuration in ends)
    sides = _sides(robot, lower, upper)
    closed, opened = sorted((lower, upper), key=lambda bounds: _gap_m(bounds, sides))
    return Hand(
        approach_axis=tool.approach_axis,
        closing_axis=tool.closing_axis,
        palm_m=_bounds_at(robot, palm, ends[0]),
        left=_jaw(opened[sides > 0], 1.0),
        right=_jaw(opened[sides < 0], -1.0),
        least_m=max(_gap_m(closed, sides), 0.0),
        greatest_m=_gap_m(opened, sides),
        payload_kg=tool.payload_kg,
        friction=friction,
        grip_n=grip_n,
    )


def _is_finger(robot: Robot, solid: Solid) -> bool:
    """True if a joint beyond the tool's own carries the solid."""
    supports = list(robot.kinematics.model.supports[joint_of(robot, solid.carrier)])
    return joint_of(robot, robot.tool.frame) in supports[:-1]


def opening_at(robot: Robot, hand: Hand, configuration: Configuration) -> float:
    """Distance of the jaws [m] at a configuration: the share of the fingers' travel, of that hand's travel.

    Args:
        robot: Whose fingers.
        hand: Its hand, perhaps with another opening than the URDF's.
        configuration: Joint values.

    Raises:
        RobotModelError: If the robot's hand is not of the kind that `hand_of` reads.
    """
    fingers = [solid for solid in robot_solids(robot) if _is_finger(robot, solid)]
    lower, upper = (_bounds_at(robot, fingers, end) for end in _ends_of_travel(robot, fingers))
    sides = _sides(robot, lower, upper)
    ends = sorted((_gap_m(lower, sides), _gap_m(upper, sides)))
    share = (_gap_m(_bounds_at(robot, fingers, configuration), sides) - ends[0]) / (ends[1] - ends[0])
    return hand.least_m + float(np.clip(share, 0.0, 1.0)) * (hand.greatest_m - hand.least_m)


def _ends_of_travel(robot: Robot, fingers: Sequence[Solid]) -> tuple[Configuration, Configuration]:
    """Configurations with the fingers at their lower and at their upper limits."""
    arm = set(robot.arm_joints)
    links = {solid.carrier for solid in fingers}
    names = sorted({name for link in links for name in robot.kinematics.joints_moving(link) if name not in arm})
    places = [robot.joint_names.index(name) for name in names]
    limits = [limit[places] for limit in (robot.limits.lower, robot.limits.upper)]
    if not np.isfinite(limits).all():
        raise RobotModelError(f"robot {robot.name}: a finger joint has no limit", joints=names)
    lower, upper = (robot.configuration(dict(zip(names, map(float, end), strict=True))) for end in limits)
    return lower, upper


def _bounds_at(robot: Robot, solids: Sequence[Solid], configuration: Configuration) -> FloatArray:
    """Bounding boxes in hand axes, shape (B, 2, 3)."""
    T_hand_base = np.linalg.inv(robot.tool_pose(configuration).homogeneous @ _T_tool_hand(robot))
    links = list(dict.fromkeys(solid.carrier for solid in solids))
    T_hand = {link: T_hand_base @ robot.link_pose(configuration, link).homogeneous for link in links}
    boxes = [_bounds(solid, T_hand[solid.carrier] @ solid.T_carrier_solid) for solid in solids]
    return np.array(boxes).reshape(-1, 2, 3)


def _T_tool_hand(robot: Robot) -> FloatArray:
    tool, T = robot.tool, np.eye(4)
    across = np.cross(tool.approach_axis, tool.closing_axis)
    T[:3, :3] = np.column_stack([tool.closing_axis, across, tool.approach_axis])
    return T


def _bounds(solid: Solid, T: FloatArray) -> FloatArray:
    """Lower and upper corner of a solid at a pose, shape (2, 3)."""
    lower, upper = np.empty(3), np.empty(3)
    for axis in range(3):
        upwards = T[[(axis + 1) % 3, (axis + 2) % 3, axis, 3]]
        lower[axis] = solid.lowest_m(upwards)
        upper[axis] = -solid.lowest_m(-upwards)
    return np.array([lower, upper])


def _sides(robot: Robot, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Side of each finger's box, +1 left or -1 right, from the boxes at both ends of the travel (B, 2, 3), shape (B,).

    Raises:
        RobotModelError: If a finger turns or moves along anything but the closing axis, or a side has none.
    """
    sides = np.sign((lower + upper)[:, :, 0].sum(axis=1))
    moved = upper - lower
    outward = moved[:, 0, 0] * sides
    slides = np.allclose(moved[:, 0], moved[:, 1], atol=1e-6) and np.allclose(moved[:, :, 1:], 0.0, atol=1e-6)
    both = (sides > 0).any() and (sides < 0).any() and (sides != 0).all()
    if not (both and slides and np.ptp(outward) < 1e-6 and abs(outward[0]) > 1e-6):
        message = f"robot {robot.name}: needs two fingers that slide along the closing axis, as far to each side"
        raise RobotModelError(message, robot=robot.name, frame=robot.tool.frame)
    return np.asarray(sides)


def _gap_m(bounds: FloatArray, sides: FloatArray) -> float:
    """Distance of the inner faces [m]."""
    return float(bounds[sides > 0, 0, 0].min() - bounds[sides < 0, 1, 0].max())


def _jaw(bounds: FloatArray, side: float) -> Jaw:
    """A jaw of boxes in hand axes (B, 2, 3)."""
    outward = bounds * [side, 1.0, 1.0]
    outward[:, :, 0].sort(axis=1)
    outward[:, :, 0] -= outward[:, 0, 0].min()
    flush = outward[:, 0, 0] <= _FLUSH_M
    return Jaw(outward, outward[flush][:, :, 1:])
