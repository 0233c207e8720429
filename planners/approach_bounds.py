"""How fast two solids of a robot can approach, at most, when its joints and its base move.

The reach R_k of a joint k for a pair of solids is the longest distance that a point of the one that it moves against
the other can have from the joint's origin (1 for a sliding joint): turned by dq, the pair's distance changes by R_k dq
at most. What moves both does not change it, nor what turns a solid of revolution about its own axis, nor what moves
a solid level over the floor: there R_k is 0. Else the 2.5 mm of air between the pedestal and the upper arm of a UR5e,
which never change, would have every motion checked in steps of a millimetre.
"""

from typing import Any

import numpy as np

from planners.symbolic_fk import joint_axis
from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.robots.quick_collisions import QuickCollisions
from rfcompass.robots.solids import Solid

# A solid is round about an axis if it is off by less than this [m, rad]: far below any check's resolution. Ours.
_ROUND = 1e-9


def pair_reaches(checker: QuickCollisions) -> FloatArray:
    """What each joint, then the turn and the travel of the base, can add to the approach of each pair, (P, J + 2)."""
    count = len(checker.model.solids)
    reaches, turned = [_solid_reaches(checker, i) for i in range(count)], [_turned(checker, i) for i in range(count)]
    level, rows = _level(checker), []
    for i, j in checker.pair_solids:
        if j is None:
            rows.append(np.where(level, 0.0, reaches[i]))
            continue
        same = ((reaches[i] > 0) & (reaches[j] > 0)) | turned[i] | turned[j]
        rows.append(np.where(same, 0.0, reaches[i] + reaches[j]))
    return np.array(rows).reshape(-1, len(level))


def _level(checker: QuickCollisions) -> BoolArray:
    """Which joints, and turn and travel of the base, move everything level over the floor, shape (J + 2,)."""
    kinematics = checker.model.robot.kinematics
    pin_model, R_base_root = kinematics.model, kinematics.T_base_root.homogeneous[:3, :3]
    level = np.ones(pin_model.njoints - 1 + 2, dtype=bool)
    for joint in range(1, pin_model.njoints):
        linear, axis = joint_axis(pin_model, joint)
        upright = np.abs((R_base_root @ pin_model.jointPlacements[joint].rotation @ axis)[:2]).max() < _ROUND
        level[joint - 1] = pin_model.parents[joint] == 0 and not linear.any() and upright
    return level


def _turned(checker: QuickCollisions, i: int) -> BoolArray:
    """Which joints turn a solid about itself, or all else about it, so that nobody could tell, shape (J + 2,)."""
    solid, carrier = checker.model.solids[i], checker.model.joints_of_solids[i]
    pin_model = checker.model.robot.kinematics.model
    turned = np.zeros(pin_model.njoints - 1 + 2, dtype=bool)
    if carrier < 0 or solid.kind not in ("cylinder", "sphere"):
        return turned
    T_joint_solid = checker.frame_of(i).homogeneous @ solid.T_carrier_solid
    if carrier > 0:
        turned[carrier - 1] = _is_round(solid, T_joint_solid, joint_axis(pin_model, carrier))
    for joint in (k for k in range(1, pin_model.njoints) if pin_model.parents[k] == carrier):
        T = pin_model.jointPlacements[joint].inverse().homogeneous @ T_joint_solid
        turned[joint - 1] = _is_round(solid, T, joint_axis(pin_model, joint))
    return turned


def _is_round(solid: Solid, T_joint_solid: FloatArray, axes: tuple[FloatArray, FloatArray]) -> bool:
    """True if a joint only turns, and that leaves a cylinder or a sphere as it is."""
    linear, axis = axes
    if linear.any() or np.linalg.norm(np.cross(axis, T_joint_solid[:3, 3])) > _ROUND:
        return False
    return solid.kind == "sphere" or bool(np.linalg.norm(np.cross(axis, T_joint_solid[:3, 2])) < _ROUND)


def _solid_reaches(checker: QuickCollisions, i: int) -> FloatArray:
    """How far a unit of each joint, of a turn and of a travel of the base can move any point of a solid, (J + 2)."""
    model = checker.model
    pin_model, joint = model.robot.kinematics.model, model.joints_of_solids[i]
    reaches = np.zeros(pin_model.njoints - 1 + 2)
    if joint < 0:
        return reaches
    reach_m = _radius_m(checker, i)
    while joint > 0:
        slides = _slides(pin_model, joint)
        reaches[joint - 1] = 1.0 if slides else reach_m
        reach_m += float(np.linalg.norm(pin_model.jointPlacements[joint].translation))
        reach_m += _longest_slide(pin_model, joint) if slides else 0.0
        joint = pin_model.parents[joint]
    root_m = float(np.linalg.norm(model.robot.kinematics.T_base_root.translation))
    reaches[-2:] = reach_m + root_m, 1.0
    return reaches


def _radius_m(checker: QuickCollisions, i: int) -> float:
    """Longest distance of a point of a solid from the origin of the joint that moves it [m]."""
    solid, frame = checker.model.solids[i], checker.frame_of(i)
    centre = frame.act(solid.T_carrier_box[:3, 3])
    return float(np.linalg.norm(centre) + np.linalg.norm(solid.half_size_m))


def _slides(pin_model: Any, joint: int) -> bool:  # noqa: ANN401 - pinocchio has no types
    return "JointModelP" in pin_model.joints[joint].shortname()


def _longest_slide(pin_model: Any, joint: int) -> float:  # noqa: ANN401
    at = pin_model.joints[joint].idx_q
    limits = pin_model.lowerPositionLimit[at], pin_model.upperPositionLimit[at]
    return float(max(abs(limit) for limit in limits))
