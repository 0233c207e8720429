"""The best grasps that a depth image shows, one for each place, best first."""

from dataclasses import dataclass

import numpy as np

from planners.extraction.projection import check_same_image
from planners.grasp_at_pixel import grasp_at_pixel
from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView, GraspMaps
from rfcompass.types.counts import check_count
from rfcompass.types.record import Record

APART_M = 0.03  # ours: about a finger's width; nearer to each other two grasps are the same one


@dataclass(frozen=True, slots=True)
class ImageGrasp(Record):
    """A grasp that an image shows.

    Attributes:
        row: Of its pixel.
        column: Of its pixel.
        quality: As the maps have it; the chance to hold, with `AntipodalQuality`.
        T_world_hand: Pose of the tool as in `grasp_at_pixel`, homogeneous, shape (4, 4).
        aperture_m: How far the jaws are open before they close [m].
    """

    row: int
    column: int
    quality: float
    T_world_hand: FloatArray
    aperture_m: float

    def __post_init__(self) -> None:
        """Freeze the pose."""
        object.__setattr__(self, "T_world_hand", read_only(self.T_world_hand, "ImageGrasp.T_world_hand", (4, 4)))


def best_grasps(view: DepthView, maps: GraspMaps, count: int = 5, apart_m: float = APART_M) -> tuple[ImageGrasp, ...]:
    """Choose the best grasps of an image, each at least so far from all better ones.

    Args:
        view: The image.
        maps: The best grasp at each of its pixels.
        count: How many at most.
        apart_m: How far the points that two of them show lie apart, seen from above [m].

    Returns:
        Best first; fewer than `count` where no other pixel has a quality above 0, none if no pixel has.

    Raises:
        InputError: If the count is below 1 or the distance negative.
        ShapeError: If maps and image differ in size.
    """
    check_count(count, "count", 1)
    if not (np.isfinite(apart_m) and apart_m >= 0):
        raise InputError(f"apart_m: {apart_m} is no distance", name="apart_m", got=apart_m)
    check_same_image(view, maps.quality, "grasps")
    points_m = points_image(view)[..., :2]
    left = np.where(np.isfinite(view.depth_m), maps.quality, 0.0)
    chosen: list[ImageGrasp] = []
    while len(chosen) < count and left.max(initial=0.0) > 0:
        row, column = (int(i) for i in np.unravel_index(int(left.argmax()), left.shape))
        pose_and_opening = grasp_at_pixel(view, maps, row, column)
        chosen.append(ImageGrasp(row, column, float(left[row, column]), *pose_and_opening))
        near = np.linalg.norm(points_m - points_m[row, column], axis=2) < apart_m
        left = np.where(near, 0.0, left)
        left[row, column] = 0.0
    return tuple(chosen)
