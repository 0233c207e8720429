"""Grasps of a given object: of a target in sight [Boroushaki2023], sections 4.5.2 and 5, or of one chosen from afar.

And of any object, the surest of all: five failures in a row end a search, and a grasp that holds begins the count anew.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from planners.extraction.candidates import tried_before
from planners.grasp_at_pixel import grasp_across, grasp_at_pixel
from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.errors import NothingToGrasp
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView, ExtractionAction, GraspMaps, InstanceMasks
from rfcompass.types.record import Record

# Ours. Below the first, a target is not worth a try while a neighbour can be taken; how far off that may be [pixel].
_WORTH, _BESIDE_PX = 0.15, 6
# Ours: an object so near to where a grasp was chosen, seen from above, is the one that it was chosen for [m].
_SAME_M = 0.02
# Ours: grasps so near to one that the arm cannot reach are not tried either [m].
_UNREACHED_M = 0.02


@dataclass(frozen=True, slots=True)
class ChosenGrasp(Record):
    """What to go for, and what it promises.

    Attributes:
        action: The grasp.
        chance: Promise of success, after what has failed there, in [0, 1]; 0 where no image told it.
        on_target: Whether it goes for the target.
        reached: False if the arm was asked, and cannot go there.
    """

    action: ExtractionAction
    chance: float = 0.0
    on_target: bool = False
    reached: bool = True


def grasp_target(
    view: DepthView,
    target: BoolArray,
    masks: InstanceMasks,
    grasps: GraspMaps,
    failed_m: Sequence[FloatArray] = (),
    table_m: float = 0.0,
) -> ChosenGrasp:
    """Choose the best grasp of a target in sight; if that is hardly one, the best of what lies beside it.

    Args:
        view: Where the target is in sight.
        target: Its pixels, shape (H, W).
        masks: Objects in the view.
        grasps: The best grasp at each pixel.
        failed_m: Where grasps have failed, in the world [m], shape (3,) each.
        table_m: Height of the table in the world [m].

    Raises:
        NothingToGrasp: If no pixel of the target has a depth.
    """
    seen = target & np.isfinite(view.depth_m)
    if not seen.any():
        message = f"none of the target's {int(target.sum())} pixels has a depth"
        raise NothingToGrasp(message, masks=masks.count)
    # The target is an object of its own here, whatever else its mask covers: what failed on it counts for it alone.
    objects = InstanceMasks(np.where(target, masks.labels.max() + 1, masks.labels))
    quality = grasps.quality * tried_before(points_image(view), objects, failed_m)
    own = _best(quality, seen)
    beside = ndimage.binary_dilation(target, iterations=_BESIDE_PX) & ~target
    labels = [int(label) for label in np.unique(masks.labels[beside]) if label > 0]
    others = np.isin(masks.labels, labels) & ~target & np.isfinite(view.depth_m)
    if quality[own] < _WORTH and others.any():
        other = _best(quality, others)
        if quality[other] > max(quality[own], _WORTH):
            return _chosen(grasp_at_pixel(view, grasps, *other), int(masks.labels[other]), float(quality[other]))
    placed = grasp_at_pixel(view, grasps, *own) if quality[own] > 0 else grasp_across(view, seen, table_m)
    return _chosen(placed, int(masks.labels[own]), float(quality[own]), on_target=True)


def surest_grasp(
    view: DepthView, masks: InstanceMasks, grasps: GraspMaps, failed_m: Sequence[FloatArray] = ()
) -> ChosenGrasp | None:
    """Choose the best grasp of any object; None if there is none.

    Args:
        view: What the camera sees.
        masks: Its objects.
        grasps: The best grasp at each pixel.
        failed_m: Where grasps have failed, in the world [m], shape (3,) each.
    """
    quality = grasps.quality * tried_before(points_image(view), masks, failed_m)
    best = _best(quality, (masks.labels > 0) & np.isfinite(view.depth_m))
    if masks.labels[best] == 0 or not quality[best] > 0:
        return None
    return _chosen(grasp_at_pixel(view, grasps, *best), int(masks.labels[best]), float(quality[best]))


def grasp_again(
    action: ExtractionAction,
    view: DepthView,
    masks: InstanceMasks,
    grasps: GraspMaps,
    failed_m: Sequence[FloatArray] = (),
) -> ChosenGrasp | None:
    """Choose the grasp of an object anew in another image, one from nearer.

    Args:
        action: What was chosen in the first image.
        view: The second one.
        masks: Its objects.
        grasps: The best grasp at each of its pixels.
        failed_m: Where grasps have failed, in the world [m], shape (3,) each.

    Returns:
        The best grasp on the object that the second image shows where the first grasp was, with the scores and the
        label of the first; None where there is no such object, or no grasp on it.
    """
    points_m = points_image(view)
    off_m = np.linalg.norm(points_m[..., :2] - action.T_world_hand[:2, 3], axis=2)
    off_m = np.where(np.isfinite(off_m) & (masks.labels > 0), off_m, np.inf)
    nearest = np.unravel_index(int(off_m.argmin()), off_m.shape)
    if not off_m[nearest] < _SAME_M:
        return None
    quality = grasps.quality * tried_before(points_m, masks, failed_m)
    best = _best(quality, (masks.labels == masks.labels[nearest]) & np.isfinite(view.depth_m))
    if not quality[best] > 0:
        return None
    T_world_hand, aperture_m = grasp_at_pixel(view, grasps, *best)
    return ChosenGrasp(replace(action, T_world_hand=T_world_hand, aperture_m=aperture_m), float(quality[best]))


def without_near(view: DepthView, grasps: GraspMaps, point_m: FloatArray) -> GraspMaps:
    """The same maps without grasps within 2 cm of a point, seen from above, where the arm cannot go.

    Args:
        view: What the maps are of.
        grasps: The best grasp at each pixel.
        point_m: In the world [m], shape (3,).
    """
    off_m = np.linalg.norm(points_image(view)[..., :2] - np.asarray(point_m)[:2], axis=2)
    return replace(grasps, quality=np.where(off_m < _UNREACHED_M, 0.0, grasps.quality))


def _best(quality: FloatArray, pixels: BoolArray) -> tuple[int, int]:
    row, column = np.unravel_index(int(np.argmax(np.where(pixels, quality, -1.0))), quality.shape)
    return int(row), int(column)


def _chosen(placed: tuple[FloatArray, float], label: int, quality: float, *, on_target: bool = False) -> ChosenGrasp:
    T_world_hand, aperture_m = placed
    return ChosenGrasp(ExtractionAction(label, T_world_hand, aperture_m, quality), quality, on_target)
