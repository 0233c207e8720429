"""Objects of an image that could be taken: the best grasp of each, and what failed there before."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planners.extraction.projection import check_same_image
from planners.grasp_at_pixel import middle_pixel
from rfcompass.arrays import BoolArray, FloatArray, IntArray, read_only
from rfcompass.errors import NothingToGrasp, ShapeError
from rfcompass.types import DepthView, GraspMaps, InstanceMasks
from rfcompass.types.record import Record

# Ours: a grasp so near to one that failed, seen from above, is believed so much less, for each failure; and so
# much less all others on the object in which that was.
NEAR_M, AGAIN, ELSEWHERE = 0.03, 0.25, 0.5


@dataclass(frozen=True, slots=True)
class Candidates(Record):
    """Objects that could be taken, in the order in which the image shows them: labels have no meaning.

    Attributes:
        labels: Of each object with a depth, shape (K,).
        pixels: Row and column of its best grasp; its middle where no pixel looks like a grasp, shape (K, 2).
        quality: g_i [Boroushaki2023], Eq. 5, lowered where grasps have failed, shape (K,).
        tried: How much it was lowered, 1 where nothing failed, shape (K,).
    """

    labels: IntArray
    pixels: IntArray
    quality: FloatArray
    tried: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays, one row for each object."""
        labels = read_only(self.labels, "Candidates.labels", (None,), np.int64)
        object.__setattr__(self, "labels", labels)
        object.__setattr__(self, "pixels", read_only(self.pixels, "Candidates.pixels", (len(labels), 2), np.int64))
        for name in ("quality", "tried"):
            object.__setattr__(self, name, read_only(getattr(self, name), f"Candidates.{name}", (len(labels),)))


def find_candidates(
    view: DepthView,
    masks: InstanceMasks,
    grasps: GraspMaps,
    points_m: FloatArray,
    failed_m: Sequence[FloatArray] = (),
) -> Candidates:
    """Find the best grasp of each object.

    Args:
        view: The image.
        masks: Its objects.
        grasps: The best grasp at each pixel.
        points_m: Point of the world that each pixel shows [m], shape (H, W, 3).
        failed_m: Where grasps have failed, in the world [m], shape (3,) each.

    Raises:
        NothingToGrasp: If no object has a pixel with a depth.
        ShapeError: If the images differ in size, or a place of a failed grasp is none.
    """
    check_same_image(view, masks.labels, "masks")
    check_same_image(view, grasps.quality, "grasps")
    usable = (masks.labels > 0) & np.isfinite(view.depth_m)
    if not usable.any():
        message = f"none of {masks.count} objects in the view has a pixel with a depth"
        raise NothingToGrasp(message, masks=masks.count)
    tried = tried_before(points_m, masks, failed_m)
    quality = grasps.quality * tried
    flat = np.flatnonzero(usable)
    labels, best = _best_of_each(masks.labels.ravel()[flat], flat, quality.ravel()[flat])
    pixels = np.column_stack(np.unravel_index(best, usable.shape))
    for k in np.flatnonzero(quality.ravel()[best] == 0):
        pixels[k] = middle_pixel(usable & (masks.labels == labels[k]))
    return Candidates(labels, pixels, quality.ravel()[best], tried[tuple(pixels.T)])


def tried_before(points_m: FloatArray, masks: InstanceMasks, failed_m: Sequence[FloatArray]) -> FloatArray:
    """By how much a grasp at each pixel is believed less for the failures so far, shape (H, W).

    Args:
        points_m: Point of the world that each pixel shows [m], shape (H, W, 3).
        masks: Objects; a failure counts for the nearest one within 3 cm.
        failed_m: Where grasps have failed, in the world [m], shape (3,) each; infinite where that counts no more.

    Raises:
        ShapeError: If a place is none.
    """
    tried = np.ones(points_m.shape[:2])
    for point_m in failed_m:
        off_m = _off_m(points_m, masks, point_m)
        if off_m.min() < NEAR_M:
            same = masks.labels == masks.labels.ravel()[off_m.argmin()]
            tried *= np.where(off_m < NEAR_M, AGAIN, np.where(same, ELSEWHERE, 1.0))
    return tried


def failed_place(point_m: FloatArray) -> FloatArray:
    """Where a grasp has failed [m], shape (3,); infinite where that counts no more.

    Raises:
        ShapeError: If it is not three numbers.
    """
    place_m = read_only(point_m, "failed_m", (3,), finite=False)
    if np.isnan(place_m).any():
        raise ShapeError(f"failed_m: {place_m.tolist()} is no place", name="failed_m", got=place_m.tolist())
    return place_m


def failed_object(points_m: FloatArray, masks: InstanceMasks, point_m: FloatArray) -> int:
    """Label of the object for which a failed grasp counts, 0 for none; arguments as for `tried_before`."""
    off_m = _off_m(points_m, masks, point_m)
    return int(masks.labels.ravel()[off_m.argmin()]) if off_m.min() < NEAR_M else 0


def _off_m(points_m: FloatArray, masks: InstanceMasks, point_m: FloatArray) -> FloatArray:
    """Level distance of each pixel of an object from a place [m], infinite elsewhere, shape (H, W)."""
    x_m, y_m, _ = failed_place(point_m)
    off_m = np.hypot(points_m[..., 0] - x_m, points_m[..., 1] - y_m)
    return np.where((masks.labels == 0) | np.isnan(off_m), np.inf, off_m)


def _best_of_each(labels: IntArray, flat: IntArray, quality: FloatArray) -> tuple[IntArray, IntArray]:
    """Labels in the order of their first pixels, and the pixel of each with the best quality; the first of several."""
    known, first, group = np.unique(labels, return_index=True, return_inverse=True)
    order = np.lexsort((flat, -quality, group))
    starts = np.searchsorted(group[order], np.arange(len(known)))
    shown = np.argsort(first)
    return known[shown], flat[order[starts]][shown]


def pixels_of(masks: InstanceMasks, label: int) -> BoolArray:
    """Pixels of one object, shape (H, W)."""
    return np.asarray(masks.labels == label)
