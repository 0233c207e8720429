"""Maps of where a hidden item can be, after FuseBot [Boroushaki2023], section 4.

    views ──map_views──▶ VisualMap ─▶ C ┐
    tags  ──known_items, rf_certainty_map─▶ R ┴─fuse_maps─▶ C + R ──occupancy_map──▶ where the target can be

`posterior_map` is ours, beside the paper's: the probability of the target's place given views, tags and sizes.

Every map is a `VoxelGrid` over one `Workspace` that stands on the table.
"""

from rfcompass.mapping.camera import back_project, clean_depth_m
from rfcompass.mapping.depth_segmenter import DepthSegmenter
from rfcompass.mapping.item_lookup import located_items, tagged_items
from rfcompass.mapping.item_occupancy import item_occupancy, items_occupancy
from rfcompass.mapping.network_segmenter import NetworkSegmenter, labels_of_masks
from rfcompass.mapping.occupancy import fuse_maps, occupancy_map
from rfcompass.mapping.posterior_map import PosteriorRules, posterior_map
from rfcompass.mapping.readings import READINGS
from rfcompass.mapping.rf_kernels import TagKernel, deformable_kernel, rigid_kernel
from rfcompass.mapping.rf_map import RfKernels, RfMap, known_items, rf_certainty_map, tagged_target_map
from rfcompass.mapping.target_kernels import TargetKernel, box_target, gaussian_target
from rfcompass.mapping.visible_target import RED, ColourRule, VisibleTarget, find_visible_target
from rfcompass.mapping.visual_map import LogOdds, VisualMap, map_views
from rfcompass.mapping.xray import xray_map, xray_occupancy

__all__ = [
    "READINGS",
    "RED",
    "ColourRule",
    "DepthSegmenter",
    "LogOdds",
    "NetworkSegmenter",
    "PosteriorRules",
    "RfKernels",
    "RfMap",
    "TagKernel",
    "TargetKernel",
    "VisibleTarget",
    "VisualMap",
    "back_project",
    "box_target",
    "clean_depth_m",
    "deformable_kernel",
    "find_visible_target",
    "fuse_maps",
    "gaussian_target",
    "item_occupancy",
    "items_occupancy",
    "known_items",
    "labels_of_masks",
    "located_items",
    "map_views",
    "occupancy_map",
    "posterior_map",
    "rf_certainty_map",
    "rigid_kernel",
    "tagged_items",
    "tagged_target_map",
    "xray_map",
    "xray_occupancy",
]
