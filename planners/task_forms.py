"""The freedoms of a task, spelled out as tasks with a fixed approach; and the error of an answer."""

import numpy as np
import pinocchio as pin

from planners.planar_arm import PlanarArm
from rfcompass.arrays import FloatArray
from rfcompass.robots import Tool
from rfcompass.types.grasp_task import GraspTask

# Pitches to try where the pitch is free; ours.
_PITCHES_RAD = np.deg2rad(np.arange(-180, 180, 1.0))


def fixed_tasks(arm: PlanarArm, task: GraspTask) -> FloatArray:
    """Tasks for `closed_form.solve_all` that cover one task, shape (B, 9); their closing axis is NaN where it is free.

    One, where the approach is fixed. Two where any heading will do, since the arm plane decides it. With a free
    approach, those of the directions in the arm plane that the closing axis allows, or one for each degree.
    """
    normal = _plane_normal(arm, task.point_m)
    if task.approach is None:
        axes = _free_approach(normal, task)
    elif not task.any_heading:
        axes = [(task.approach, task.closing)]
    elif task.is_vertical:
        axes = [(task.approach, None)]
    else:
        axes = [_turned(task, heading) for heading in _headings(normal)]
    free = np.full(3, np.nan)
    return np.array([np.concatenate([task.point_m, a, free if c is None else c]) for a, c in axes]).reshape(-1, 9)


def _plane_normal(arm: PlanarArm, point_m: FloatArray) -> FloatArray:
    """Horizontal unit vector across the arm plane through a point; across x above the axis of joint 1."""
    dx, dy = point_m[:2] - arm.axis_m
    heading = np.arctan2(dy, dx)
    return np.array([-np.sin(heading), np.cos(heading), 0.0])


def _headings(normal: FloatArray) -> tuple[float, float]:
    """Headings of the two horizontal directions in the arm plane [rad]."""
    towards = float(np.arctan2(-normal[0], normal[1]))
    return towards, towards + np.pi


def _turned(task: GraspTask, heading_rad: float) -> tuple[FloatArray, FloatArray | None]:
    """Both axes, turned about the vertical so that the approach gets a heading."""
    approach = np.asarray(task.approach)
    turn = heading_rad - np.arctan2(approach[1], approach[0])
    R = pin.rpy.rpyToMatrix(0.0, 0.0, turn)
    return R @ approach, None if task.closing is None else R @ task.closing


def _free_approach(normal: FloatArray, task: GraspTask) -> list[tuple[FloatArray, FloatArray | None]]:
    up = np.array([0.0, 0.0, 1.0])
    outward = np.cross(normal, up)
    pitched = [np.sin(p) * outward + np.cos(p) * up for p in _PITCHES_RAD]
    if task.closing is None:
        return [(a, None) for a in pitched]
    if task.any_heading:
        return [(a, c) for a in pitched for c in _as_high(a, normal, task.closing[2])]
    across = task.closing - (task.closing @ normal) * normal
    if np.linalg.norm(across) < 1e-9:
        return [(a, task.closing) for a in pitched]
    a = np.cross(normal, across) / np.linalg.norm(across)
    return [(a, task.closing), (-a, task.closing)]


def _as_high(approach: FloatArray, normal: FloatArray, height: float) -> list[FloatArray]:
    """Closing axes at right angles to an approach whose tips are at a height, on either side."""
    lean = np.cross(normal, approach)
    if abs(lean[2]) < abs(height) or abs(lean[2]) < 1e-12:
        return []
    cosine = height / lean[2]
    sine = np.sqrt(max(0.0, 1 - cosine**2))
    return [cosine * lean + side * sine * normal for side in (-1, 1)]


def task_error(task: GraspTask, T_base_tool: "pin.SE3", tool: Tool) -> tuple[float, float]:
    """Distance of a tool from the task's point [m], and the largest angle between its axes and the task's [rad]."""
    position_m = float(np.linalg.norm(T_base_tool.translation - task.point_m))
    approach, closing = T_base_tool.rotation @ tool.approach_axis, T_base_tool.rotation @ tool.closing_axis
    wanted, jaws = task.approach, task.closing
    angles = [0.0]
    if task.any_heading:
        if wanted is None:
            return position_m, _height_error(jaws, closing, task.jaws_alike)
        if task.is_vertical:
            return position_m, _angle(wanted, approach)
        wanted, jaws = _turned(task, float(np.arctan2(approach[1], approach[0])))
    if wanted is not None:
        angles.append(_angle(wanted, approach))
    if jaws is not None:
        off = _angle(jaws, closing)
        angles.append(min(off, np.pi - off) if task.jaws_alike else off)
    return position_m, max(angles)


def _height_error(jaws: FloatArray | None, closing: FloatArray, alike: bool) -> float:
    """How far a closing axis is from the wanted angle to the horizontal [rad]."""
    if jaws is None:
        return 0.0
    wanted, got = np.arcsin(jaws[2]), np.arcsin(np.clip(closing[2], -1, 1))
    return float(min(abs(got - wanted), abs(got + wanted)) if alike else abs(got - wanted))


def _angle(first: FloatArray, second: FloatArray) -> float:
    """Angle between two unit vectors [rad], exact for small ones."""
    (a, b, c), (x, y, z) = first.tolist(), second.tolist()
    across = np.hypot(np.hypot(b * z - c * y, c * x - a * z), a * y - b * x)
    return float(np.arctan2(across, a * x + b * y + c * z))
