"""RFID-guided manipulation: the open reference implementation of RF-Compass and FuseBot.

The public names below load on first use, so that `import rfcompass` costs nothing.
Start reading at `rfcompass/interfaces.py`.
"""

from typing import TYPE_CHECKING

from rfcompass.lazy import lazy_names

if TYPE_CHECKING:
    from rfcompass.geometry.pose2 import Pose2 as Pose2
    from rfcompass.localization import ConsistencyLocalizer as ConsistencyLocalizer
    from rfcompass.localization import PartitionLocalizer as PartitionLocalizer
    from rfcompass.localization import PosteriorLocalizer as PosteriorLocalizer
    from rfcompass.localization import survey as survey
    from rfcompass.recordings.parts import PartDatabase as PartDatabase
    from rfcompass.recordings.trace import Trace as Trace
    from rfcompass.recordings.trace_store import open_trace as open_trace
    from rfcompass.recordings.trace_store import write_trace as write_trace
    from rfcompass.rf import meter as meter
    from rfcompass.robots.library import load_robot as load_robot
    from rfcompass.robots.robot import Robot as Robot
    from rfcompass.robots.youbot import YouBot as YouBot
    from rfcompass.types.estimate import PartEstimate as PartEstimate
    from rfcompass.types.fixes import TagFix as TagFix
    from rfcompass.types.observation import Observation as Observation
    from rfcompass.types.parts import Part as Part
    from rfcompass.types.proximity import ProximityMatrix as ProximityMatrix
    from rfcompass.types.reads import ReadTrace as ReadTrace
    from rfcompass.types.reads import Scan as Scan
    from rfcompass.viz.grasp_view import view as view

_HOME = {
    "ConsistencyLocalizer": "localization",
    "Observation": "types.observation",
    "Part": "types.parts",
    "PartDatabase": "recordings.parts",
    "PartEstimate": "types.estimate",
    "PartitionLocalizer": "localization",
    "Pose2": "geometry.pose2",
    "PosteriorLocalizer": "localization",
    "ProximityMatrix": "types.proximity",
    "ReadTrace": "types.reads",
    "Robot": "robots.robot",
    "Scan": "types.reads",
    "TagFix": "types.fixes",
    "Trace": "recordings.trace",
    "YouBot": "robots.youbot",
    "load_robot": "robots.library",
    "meter": "rf",
    "open_trace": "recordings.trace_store",
    "survey": "localization",
    "view": "viz.grasp_view",
    "write_trace": "recordings.trace_store",
}

__all__ = [
    "ConsistencyLocalizer",
    "Observation",
    "Part",
    "PartDatabase",
    "PartEstimate",
    "PartitionLocalizer",
    "Pose2",
    "PosteriorLocalizer",
    "ProximityMatrix",
    "ReadTrace",
    "Robot",
    "Scan",
    "TagFix",
    "Trace",
    "YouBot",
    "load_robot",
    "meter",
    "open_trace",
    "survey",
    "view",
    "write_trace",
]

__getattr__, __dir__ = lazy_names(__name__, _HOME)
