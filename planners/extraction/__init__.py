"""What to take out of a pile next: FuseBot's rule, X-Ray's, simpler ones, ours.

    grid, view, masks, grasps ──policy.choose──▶ ExtractionAction

A policy is a frozen record of parameters without memory. `best_cluster` says where to look before.
"""

from planners.extraction.blind_policies import LargestMaskPolicy, RandomPolicy
from planners.extraction.candidates import Candidates, find_candidates
from planners.extraction.clusters import Cluster, best_cluster, clusters_of, highest_voxel_m
from planners.extraction.fewest_actions import ActionCosts, FewestActionsPolicy
from planners.extraction.fusebot_policy import FuseBotPolicy
from planners.extraction.layers import LayerRules
from planners.extraction.mask_policy import MaskPolicy
from planners.extraction.naive_policy import NaivePolicy
from planners.extraction.projection import MaskColumns, project_masks
from planners.extraction.scores import mask_scores
from planners.extraction.xray_policy import MapMassPolicy, XRayPolicy

__all__ = [
    "ActionCosts",
    "Candidates",
    "Cluster",
    "FewestActionsPolicy",
    "FuseBotPolicy",
    "LargestMaskPolicy",
    "LayerRules",
    "MapMassPolicy",
    "MaskColumns",
    "MaskPolicy",
    "NaivePolicy",
    "RandomPolicy",
    "XRayPolicy",
    "best_cluster",
    "clusters_of",
    "find_candidates",
    "highest_voxel_m",
    "mask_scores",
    "project_masks",
]
