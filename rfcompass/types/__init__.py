"""The records that pass between layers: frozen, checked on construction, arrays read-only, SI units."""

from rfcompass.types.comparisons import Comparisons, HalfSpaces
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.fixes import TagFix
from rfcompass.types.grasps import Failure, GraspCandidate, GraspOutcome, GraspPlan, ReachMap, RunEvent, RunLog
from rfcompass.types.observation import Observation
from rfcompass.types.piles import DepthView, ExtractionAction, InstanceMasks, VoxelGrid
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan, TagRead
from rfcompass.types.tags import ROLES, TagLayout, TagPositions
from rfcompass.types.volumes import SearchVolume

__all__ = [
    "ROLES",
    "Comparisons",
    "DepthView",
    "ExtractionAction",
    "Failure",
    "GraspCandidate",
    "GraspOutcome",
    "GraspPlan",
    "HalfSpaces",
    "InstanceMasks",
    "Observation",
    "PartEstimate",
    "ProximityMatrix",
    "ReachMap",
    "ReadTrace",
    "RunEvent",
    "RunLog",
    "Scan",
    "SearchVolume",
    "TagFix",
    "TagLayout",
    "TagPositions",
    "TagRead",
    "VoxelGrid",
]
