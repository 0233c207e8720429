"""A target in sight: grasp it, or first what stands in the way of that [Boroushaki2023], sections 4.5.2 and 5."""

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from planners.grasp_at_pixel import grasp_at_pixel
from rfcompass.arrays import BoolArray, FloatArray
from rfcompass.errors import NothingToGrasp
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView, ExtractionAction, GraspMaps, InstanceMasks

# Ours. Below the first, a target is not worth a try while a neighbour can be taken; pixels so near to a failed grasp,
# seen from above, are not tried again [m]; how far off a neighbour may be [pixel].
_WORTH, _AGAIN_M, _BESIDE_PX = 0.15, 0.02, 6


def grasp_target(
    view: DepthView,
    target: BoolArray,
    masks: InstanceMasks,
    grasps: GraspMaps,
    failed_m: Sequence[FloatArray] = (),
) -> tuple[ExtractionAction, bool]:
    """Choose the best grasp of a target in sight; if that is hardly one, the best of what lies beside it.

    Args:
        view: Where the target is in sight.
        target: Its pixels, shape (H, W).
        masks: Objects in the view.
        grasps: The best grasp at each pixel.
        failed_m: Where grasps have failed, in the world [m], shape (3,) each.

    Returns:
        The action, and whether it goes for the target.

    Raises:
        NothingToGrasp: If no pixel of the target has a depth.
    """
    seen = target & np.isfinite(view.depth_m)
    if not seen.any():
        message = f"none of the target's {int(target.sum())} pixels has a depth"
        raise NothingToGrasp(message, masks=masks.count)
    quality = np.where(_tried(view, failed_m), 0.0, grasps.quality)
    own = _best(quality, seen)
    beside = ndimage.binary_dilation(target, iterations=_BESIDE_PX) & ~target
    labels = [int(label) for label in np.unique(masks.labels[beside]) if label > 0]
    others = np.isin(masks.labels, labels) & ~target & np.isfinite(view.depth_m)
    if quality[own] < _WORTH and others.any():
        other = _best(quality, others)
        if quality[other] > max(quality[own], _WORTH):
            return _action(view, grasps, other, int(masks.labels[other]), float(quality[other])), False
    if quality[own] == 0.0:  # nothing there looks like a grasp: its middle
        own = _middle(seen)
    return _action(view, grasps, own, int(masks.labels[own]), float(quality[own])), True


def _best(quality: FloatArray, pixels: BoolArray) -> tuple[int, int]:
    row, column = np.unravel_index(int(np.argmax(np.where(pixels, quality, -1.0))), quality.shape)
    return int(row), int(column)


def _middle(pixels: BoolArray) -> tuple[int, int]:
    where = np.argwhere(pixels)
    row, column = where[np.argmin(np.linalg.norm(where - where.mean(axis=0), axis=1))]
    return int(row), int(column)


def _tried(view: DepthView, failed_m: Sequence[FloatArray]) -> BoolArray:
    tried = np.zeros(view.depth_m.shape, dtype=bool)
    if failed_m:
        points_m = points_image(view)
        for point_m in failed_m:
            off_m = np.linalg.norm(points_m[..., :2] - point_m[:2], axis=-1)
            tried |= np.nan_to_num(off_m, nan=np.inf) < _AGAIN_M
    return tried


def _action(view: DepthView, grasps: GraspMaps, pixel: tuple[int, int], label: int, quality: float) -> ExtractionAction:
    T_world_hand, aperture_m = grasp_at_pixel(view, grasps, *pixel)
    return ExtractionAction(label, T_world_hand, aperture_m, quality)
