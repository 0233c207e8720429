"""From reads to tag positions, and from comparisons to the part's pose."""

from rfcompass.localization.compared_stop import ComparedStop, compared_stops
from rfcompass.localization.comparing import compare_proximities
from rfcompass.localization.consistency import ConsistencyLocalizer
from rfcompass.localization.follow_tag import follow_tag
from rfcompass.localization.hyperbolic import HyperbolicSurveyor
from rfcompass.localization.layout_design import DesignedLayout, design_layout
from rfcompass.localization.layout_error import LayoutError
from rfcompass.localization.locate_all import LocatedTags, locate_all
from rfcompass.localization.lying_tags import lying_tags
from rfcompass.localization.measure_more import MeasureMore, MoreAperture, measure_more
from rfcompass.localization.measuring import measure_proximities
from rfcompass.localization.nearest_tag import NearestTagLocalizer
from rfcompass.localization.next_best_stop import StopScores, next_best_stop
from rfcompass.localization.noise_model import NoiseModel, noise_of
from rfcompass.localization.partition import PartitionLocalizer
from rfcompass.localization.partition_file import answer_partition
from rfcompass.localization.partition_solver import PartitionSolution, solve_partition
from rfcompass.localization.phase_model import PathCovariance
from rfcompass.localization.phase_sign import PhaseSign, detect_phase_sign
from rfcompass.localization.pose_posterior import PosePosterior
from rfcompass.localization.posterior import PosteriorLocalizer
from rfcompass.localization.problem import PartitionProblem, bounds_about, build_partition, comparison_rows
from rfcompass.localization.reach import in_reach_by_base_end, in_reach_by_mean, next_goal, well_positioned
from rfcompass.localization.sar import WRIST_SAR, SarSurveyor, sar_image
from rfcompass.localization.sar_localizer import SarLocalizer
from rfcompass.localization.search_volume import default_volume
from rfcompass.localization.settled import StopRule
from rfcompass.localization.survey import SURVEYORS, survey
from rfcompass.localization.window import recent_stops

__all__ = [
    "SURVEYORS",
    "WRIST_SAR",
    "ComparedStop",
    "ConsistencyLocalizer",
    "DesignedLayout",
    "HyperbolicSurveyor",
    "LayoutError",
    "LocatedTags",
    "MeasureMore",
    "MoreAperture",
    "NearestTagLocalizer",
    "NoiseModel",
    "PartitionLocalizer",
    "PartitionProblem",
    "PartitionSolution",
    "PathCovariance",
    "PhaseSign",
    "PosePosterior",
    "PosteriorLocalizer",
    "SarLocalizer",
    "SarSurveyor",
    "StopRule",
    "StopScores",
    "answer_partition",
    "bounds_about",
    "build_partition",
    "compare_proximities",
    "compared_stops",
    "comparison_rows",
    "default_volume",
    "design_layout",
    "detect_phase_sign",
    "follow_tag",
    "in_reach_by_base_end",
    "in_reach_by_mean",
    "locate_all",
    "lying_tags",
    "measure_more",
    "measure_proximities",
    "next_best_stop",
    "next_goal",
    "noise_of",
    "recent_stops",
    "sar_image",
    "solve_partition",
    "survey",
    "well_positioned",
]
