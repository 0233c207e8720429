"""Planners: they act on estimates and never see truth.

The names below load on first use: casadi and pinocchio take a second to import.
"""

from typing import TYPE_CHECKING

from rfcompass.lazy import lazy_names

if TYPE_CHECKING:
    from planners.antipodal import AntipodalRules as AntipodalRules
    from planners.antipodal import antipodal_grasps as antipodal_grasps
    from planners.arm_path import plan_arm as plan_arm
    from planners.base_placement import BasePlacement as BasePlacement
    from planners.base_placement import PartGrasp as PartGrasp
    from planners.base_placement import best_base_pose as best_base_pose
    from planners.base_placement import inverse_map as inverse_map
    from planners.grasp import GraspPlanner as GraspPlanner
    from planners.grasp import GraspRules as GraspRules
    from planners.grasp_network import NetworkGraspQuality as NetworkGraspQuality
    from planners.grasp_quality import AntipodalQuality as AntipodalQuality
    from planners.grasp_quality import JawSizes as JawSizes
    from planners.grasp_stages import StageRules as StageRules
    from planners.hand_stops import FreeStops as FreeStops
    from planners.hand_stops import HandStops as HandStops
    from planners.ik import IkRules as IkRules
    from planners.ik import InverseKinematics as InverseKinematics
    from planners.measure_again import AgainRules as AgainRules
    from planners.measure_again import MeasureAgain as MeasureAgain
    from planners.motion_check import MotionChecker as MotionChecker
    from planners.motion_check import MotionReport as MotionReport
    from planners.navigation import plan_drive as plan_drive
    from planners.path_search import SearchRules as SearchRules
    from planners.reachability import MapMaker as MapMaker
    from planners.scan_motion import ScanMotion as ScanMotion
    from planners.scan_motion import plan_scan as plan_scan
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
    "AgainRules": "measure_again",
    "AntipodalQuality": "grasp_quality",
    "AntipodalRules": "antipodal",
    "BasePlacement": "base_placement",
    "FreeStops": "hand_stops",
    "GraspChance": "success",
    "GraspPlanner": "grasp",
    "GraspRules": "grasp",
    "HandStops": "hand_stops",
    "IkRules": "ik",
    "InverseKinematics": "ik",
    "JawSizes": "grasp_quality",
    "MapMaker": "reachability",
    "MeasureAgain": "measure_again",
    "MotionChecker": "motion_check",
    "MotionReport": "motion_check",
    "NetworkGraspQuality": "grasp_network",
    "PartGrasp": "base_placement",
    "ScanMotion": "scan_motion",
    "SearchRules": "path_search",
    "StageRules": "grasp_stages",
    "StraightMotion": "straight_motion",
    "TaskMap": "task_map",
    "ToolDirections": "task_map",
    "antipodal_grasps": "antipodal",
    "best_base_pose": "base_placement",
    "inverse_map": "base_placement",
    "load_task_map": "task_map",
    "move_straight": "straight_motion",
    "plan_arm": "arm_path",
    "plan_drive": "navigation",
    "plan_scan": "scan_motion",
    "pose_samples": "success",
    "success_probability": "success",
    "top_down": "task_map",
}

__all__ = [
    "AgainRules",
    "AntipodalQuality",
    "AntipodalRules",
    "BasePlacement",
    "FreeStops",
    "GraspChance",
    "GraspPlanner",
    "GraspRules",
    "HandStops",
    "IkRules",
    "InverseKinematics",
    "JawSizes",
    "MapMaker",
    "MeasureAgain",
    "MotionChecker",
    "MotionReport",
    "NetworkGraspQuality",
    "PartGrasp",
    "ScanMotion",
    "SearchRules",
    "StageRules",
    "StraightMotion",
    "TaskMap",
    "ToolDirections",
    "antipodal_grasps",
    "best_base_pose",
    "inverse_map",
    "load_task_map",
    "move_straight",
    "plan_arm",
    "plan_drive",
    "plan_scan",
    "pose_samples",
    "success_probability",
    "top_down",
]

__getattr__, __dir__ = lazy_names(__name__, _HOME)
