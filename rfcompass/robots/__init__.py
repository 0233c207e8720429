"""Robots as data: a URDF, a tag layout, and the kinematics that put tags into the base frame.

The names below load on first use: pinocchio takes half a second to import.
"""

from typing import TYPE_CHECKING

from rfcompass.lazy import lazy_names

if TYPE_CHECKING:
    from rfcompass.robots.checks import RobotReport as RobotReport
    from rfcompass.robots.checks import check_urdf as check_urdf
    from rfcompass.robots.collision_model import CollisionModel as CollisionModel
    from rfcompass.robots.defect import Defect as Defect
    from rfcompass.robots.description import RobotDescription as RobotDescription
    from rfcompass.robots.description import Tool as Tool
    from rfcompass.robots.fcl_collisions import FclCollisions as FclCollisions
    from rfcompass.robots.grasp_batch import judge_grasps as judge_grasps
    from rfcompass.robots.grasp_judge import judge_grasp as judge_grasp
    from rfcompass.robots.hand import hand_of as hand_of
    from rfcompass.robots.layouts import known_layouts as known_layouts
    from rfcompass.robots.layouts import load_layout as load_layout
    from rfcompass.robots.layouts import write_layout as write_layout
    from rfcompass.robots.library import describe_robot as describe_robot
    from rfcompass.robots.library import described_robots as described_robots
    from rfcompass.robots.library import known_robots as known_robots
    from rfcompass.robots.library import load_robot as load_robot
    from rfcompass.robots.limits import JointLimits as JointLimits
    from rfcompass.robots.mounts import MountPatch as MountPatch
    from rfcompass.robots.mounts import Mounts as Mounts
    from rfcompass.robots.mounts import load_mounts as load_mounts
    from rfcompass.robots.quick_collisions import QuickCollisions as QuickCollisions
    from rfcompass.robots.robot import Robot as Robot
    from rfcompass.robots.tagging import tag_urdf as tag_urdf
    from rfcompass.robots.touching_links import always_touching as always_touching
    from rfcompass.robots.youbot import YouBot as YouBot

_HOME = {
    "CollisionModel": "collision_model",
    "Defect": "defect",
    "FclCollisions": "fcl_collisions",
    "JointLimits": "limits",
    "MountPatch": "mounts",
    "Mounts": "mounts",
    "QuickCollisions": "quick_collisions",
    "Robot": "robot",
    "RobotDescription": "description",
    "RobotReport": "checks",
    "Tool": "description",
    "YouBot": "youbot",
    "always_touching": "touching_links",
    "check_urdf": "checks",
    "describe_robot": "library",
    "described_robots": "library",
    "hand_of": "hand",
    "judge_grasp": "grasp_judge",
    "judge_grasps": "grasp_batch",
    "known_layouts": "layouts",
    "known_robots": "library",
    "load_layout": "layouts",
    "load_mounts": "mounts",
    "load_robot": "library",
    "tag_urdf": "tagging",
    "write_layout": "layouts",
}

__all__ = [
    "CollisionModel",
    "Defect",
    "FclCollisions",
    "JointLimits",
    "MountPatch",
    "Mounts",
    "QuickCollisions",
    "Robot",
    "RobotDescription",
    "RobotReport",
    "Tool",
    "YouBot",
    "always_touching",
    "check_urdf",
    "describe_robot",
    "described_robots",
    "hand_of",
    "judge_grasp",
    "judge_grasps",
    "known_layouts",
    "known_robots",
    "load_layout",
    "load_mounts",
    "load_robot",
    "tag_urdf",
    "write_layout",
]

__getattr__, __dir__ = lazy_names(__name__, _HOME)
