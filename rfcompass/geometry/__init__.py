"""Geometry of the plane: poses, angles, polygons, half-spaces and rigid registration."""

from rfcompass.geometry.angles import angle_difference, circular_mean, wrap_to_pi
from rfcompass.geometry.half_spaces import bisector_rows, change_frame
from rfcompass.geometry.polygons import (
    clip_polygon,
    intersect_half_planes,
    polygon_area_m2,
    polygon_centroid_m,
    polygon_contains,
)
from rfcompass.geometry.pose2 import Pose2, as_pose2
from rfcompass.geometry.registration import fit_pose2

__all__ = [
    "Pose2",
    "angle_difference",
    "as_pose2",
    "bisector_rows",
    "change_frame",
    "circular_mean",
    "clip_polygon",
    "fit_pose2",
    "intersect_half_planes",
    "polygon_area_m2",
    "polygon_centroid_m",
    "polygon_contains",
    "wrap_to_pi",
]
