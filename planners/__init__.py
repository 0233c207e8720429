"""Planners: they act on estimates and never see truth.

The names below load on first use: casadi and pinocchio take a second to import.
"""

from typing import TYPE_CHECKING

from rfcompass.lazy import lazy_names

if TYPE_CHECKING:
    from planners.base_placement import BasePlacement as BasePlacement
    from planners.base_placement import PartGrasp as PartGrasp
    from planners.base_placement import best_base_pose as best_base_pose
    from planners.base_placement import inverse_map as inverse_map
    from planners.ik import IkRules as IkRules
    from planners.ik import InverseKinematics as InverseKinematics
    from planners.motion_check import MotionChecker as MotionChecker
    from planners.motion_check import MotionReport as MotionReport
    from planners.reachability import MapMaker as MapMaker
    from planners.straight_motion import StraightMotion as StraightMotion
    from planners.straight_motion import move_straight as move_straight
    from planners.success import GraspChance as GraspChance
    from planners.success import pose_samples as pose_samples
    from planners.success import success_probability as success_probability
    from planners.task_map import TaskMap as TaskMap
    from planners.task_map import ToolDirections as ToolDirections
    from planners.task_map import load_task_map as load_task_map
    from planners.task_map import top_down as top_down

_HOME = {
    "BasePlacement": "base_placement",
    "GraspChance": "success",
    "IkRules": "ik",
    "InverseKinematics": "ik",
    "MapMaker": "reachability",
    "MotionChecker": "motion_check",
    "MotionReport": "motion_check",
    "PartGrasp": "base_placement",
    "StraightMotion": "straight_motion",
    "TaskMap": "task_map",
    "ToolDirections": "task_map",
    "best_base_pose": "base_placement",
    "inverse_map": "base_placement",
    "load_task_map": "task_map",
    "move_straight": "straight_motion",
    "pose_samples": "success",
    "success_probability": "success",
    "top_down": "task_map",
}

__all__ = [
    "BasePlacement",
    "GraspChance",
    "IkRules",
    "InverseKinematics",
    "MapMaker",
    "MotionChecker",
    "MotionReport",
    "PartGrasp",
    "StraightMotion",
    "TaskMap",
    "ToolDirections",
    "best_base_pose",
    "inverse_map",
    "load_task_map",
    "move_straight",
    "pose_samples",
    "success_probability",
    "top_down",
]

__getattr__, __dir__ = lazy_names(__name__, _HOME)
