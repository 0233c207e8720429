"""Your own segmentation network in the place of ours."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.errors import ShapeError
from rfcompass.types.piles import DepthView, InstanceMasks


@dataclass(frozen=True)
class NetworkSegmenter:
    """Let any function segment a depth image.

    Attributes:
        network: Takes depth [m], NaN where nothing was seen, shape (H, W), a copy of its own; returns a label for each
            pixel, 0 for the background, shape (H, W). For a network that finds one mask for each object, as Mask
            R-CNN does, put `labels_of_masks` behind it.
    """

    network: Callable[[FloatArray], IntArray]

    def segment(self, view: DepthView) -> InstanceMasks:
        """Ask the network.

        Raises:
            ShapeError: If its answer is not a whole number of at least 0 for each pixel.
        """
        labels = np.asarray(self.network(view.depth_m.copy()))
        if labels.shape != view.depth_m.shape:
            message = f"the network gave labels of shape {labels.shape} for an image of {view.depth_m.shape}"
            raise ShapeError(message, name="labels", expected=view.depth_m.shape, got=labels.shape)
        return InstanceMasks(labels)


def labels_of_masks(masks: Sequence[BoolArray], shape: tuple[int, int]) -> IntArray:
    """Make one label image of a mask for each object, best first: where masks overlap, the first wins.

    Args:
        masks: One for each object, shape (H, W) each.
        shape: H and W, for when there are no masks.

    Raises:
        ShapeError: If a mask has another shape.
    """
    labels = np.zeros(shape, dtype=np.int64)
    for number, mask in enumerate(masks, start=1):
        if np.shape(mask) != shape:
            message = f"mask {number} has shape {np.shape(mask)}, not {shape}"
            raise ShapeError(message, name="masks", expected=shape, got=np.shape(mask))
        labels[np.asarray(mask, dtype=bool) & (labels == 0)] = number
    return labels
