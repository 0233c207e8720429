"""The records that pass between layers: frozen, checked on construction, arrays read-only, SI units."""

from rfcompass.types.comparisons import Comparisons, HalfSpaces
from rfcompass.types.configuration import Configuration
from rfcompass.types.epc import canonical_epc
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.fixes import TagFix
from rfcompass.types.grasp_task import GraspTask, Solution
from rfcompass.types.grasps import (
    Contacts,
    Failure,
    GraspCandidate,
    GraspFailure,
    GraspOutcome,
    GraspPlan,
    MeasureAdvice,
    ReachMap,
    RunEvent,
    RunLog,
)
from rfcompass.types.hands import Hand, Jaw
from rfcompass.types.items import ItemSize
from rfcompass.types.located_items import LocatedItem
from rfcompass.types.motions import STAGES, StageCertificate, TimedPath
from rfcompass.types.observation import Observation
from rfcompass.types.parts import Assembly, Part, StablePose, TagSelection
from rfcompass.types.piles import DepthView, ExtractionAction, InstanceMasks, VoxelGrid
from rfcompass.types.placed_shape import PlacedShape
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan, TagRead
from rfcompass.types.robot_state import RobotState
from rfcompass.types.search import (
    GRASP_OUTCOMES,
    SEARCH_ENDS,
    GraspAttempt,
    GraspMaps,
    PileLook,
    SearchResult,
    SearchStep,
)
from rfcompass.types.shapes import Box, Cylinder, Mesh, Sphere
from rfcompass.types.tagged_items import TaggedItem
from rfcompass.types.tags import ROLES, TagLayout, TagPositions
from rfcompass.types.volumes import SearchVolume
from rfcompass.types.workspace import Workspace
from rfcompass.types.world import Body, Clearance, World, world_of_scene

__all__ = [
    "GRASP_OUTCOMES",
    "ROLES",
    "SEARCH_ENDS",
    "STAGES",
    "Assembly",
    "Body",
    "Box",
    "Clearance",
    "Comparisons",
    "Configuration",
    "Contacts",
    "Cylinder",
    "DepthView",
    "ExtractionAction",
    "Failure",
    "GraspAttempt",
    "GraspCandidate",
    "GraspFailure",
    "GraspMaps",
    "GraspOutcome",
    "GraspPlan",
    "GraspTask",
    "HalfSpaces",
    "Hand",
    "InstanceMasks",
    "ItemSize",
    "Jaw",
    "LocatedItem",
    "MeasureAdvice",
    "Mesh",
    "Observation",
    "Part",
    "PartEstimate",
    "PileLook",
    "PlacedShape",
    "ProximityMatrix",
    "ReachMap",
    "ReadTrace",
    "RobotState",
    "RunEvent",
    "RunLog",
    "Scan",
    "SearchResult",
    "SearchStep",
    "SearchVolume",
    "Solution",
    "Sphere",
    "StablePose",
    "StageCertificate",
    "TagFix",
    "TagLayout",
    "TagPositions",
    "TagRead",
    "TagSelection",
    "TaggedItem",
    "TimedPath",
    "VoxelGrid",
    "Workspace",
    "World",
    "canonical_epc",
    "world_of_scene",
]
