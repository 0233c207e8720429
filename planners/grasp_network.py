"""Your own grasp network in the place of ours, one that answers with images as GG-CNN does [Morrison2018]."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from rfcompass.arrays import FloatArray
from rfcompass.errors import ShapeError
from rfcompass.mapping.camera import check_from_above, points_image
from rfcompass.types import DepthView, GraspMaps
from rfcompass.types.counts import check_count

# Of the published code of [Morrison2018]: edge of the images it was trained on, and the unit of its widths.
_GGCNN_PX, _GGCNN_WIDTH_PX = 300, 150.0
Images = tuple[FloatArray, FloatArray, FloatArray]


def ggcnn_answer(quality: FloatArray, cos: FloatArray, sin: FloatArray, width: FloatArray) -> Images:
    """Turn the four outputs of a GG-CNN [Morrison2018] into what `NetworkGraspQuality` expects.

    Its angle is counted anticlockwise as one looks at the image, ours from columns to rows, clockwise. Its width is in
    150 pixels, and its quality, a linear output, may leave [0, 1]. The published code smooths all three images
    after that, which is left to you.

    Args:
        quality: Shape (H, W).
        cos: cos(2φ), shape (H, W).
        sin: sin(2φ), shape (H, W).
        width: Shape (H, W).
    """
    angle = -np.arctan2(sin, cos) / 2
    return np.clip(quality, 0.0, 1.0), angle, np.maximum(width, 0.0) * _GGCNN_WIDTH_PX


def ggcnn_network(
    forward: Callable[[FloatArray], Sequence[FloatArray]], size_px: int = _GGCNN_PX
) -> Callable[[FloatArray], Images]:
    """Let a GG-CNN of a fixed image size [Morrison2018] rate images of any size, for `NetworkGraspQuality`.

    What was not seen takes the depth of the nearest pixel that was. The image is made square by its border, scaled to
    the network's size, and its mean taken off, within ± 1 m. The published code cuts a square out instead, fills
    holes by inpainting, and smooths the answer.

    Args:
        forward: Takes such an image, shape (size_px, size_px); gives quality, cos(2φ), sin(2φ) and width, same shape.
        size_px: Edge of the image that the network takes.

    Raises:
        InputError: If the edge is no whole number from 1 on.
    """
    check_count(size_px, "ggcnn_network.size_px", 1)

    def network(depth_m: FloatArray) -> Images:
        rows, columns = depth_m.shape
        edge = max(rows, columns)
        above, left = (edge - rows) // 2, (edge - columns) // 2
        border = ((above, edge - rows - above), (left, edge - columns - left))
        scaled = _resampled(np.pad(_without_holes(depth_m), border, mode="edge"), size_px)
        answer = [np.asarray(image, dtype=np.float64) for image in forward(np.clip(scaled - scaled.mean(), -1.0, 1.0))]
        if [image.shape for image in answer] != [(size_px, size_px)] * 4:
            got = [image.shape for image in answer]
            message = f"the network gave images of {got}, not four of {(size_px, size_px)}"
            raise ShapeError(message, name="answer", expected=(size_px, size_px), got=got)
        own = [_resampled(image, edge)[above : above + rows, left : left + columns] for image in answer]
        quality, angle, width_px = ggcnn_answer(own[0], own[1], own[2], own[3])
        return quality, angle, width_px * edge / size_px

    return network


def _without_holes(depth_m: FloatArray) -> FloatArray:
    """Depth with the nearest pixel's where there is none; 0 where nothing was seen at all."""
    blind = np.isnan(depth_m)
    if blind.all():
        return np.zeros(depth_m.shape)
    nearest = ndimage.distance_transform_edt(blind, return_distances=False, return_indices=True)
    return np.asarray(depth_m[tuple(nearest)])


def _resampled(image: FloatArray, edge: int) -> FloatArray:
    """A square image at another size, linear between the middles of pixels."""
    at = (np.arange(edge) + 0.5) * len(image) / edge - 0.5
    return np.asarray(ndimage.map_coordinates(image, np.meshgrid(at, at, indexing="ij"), order=1, mode="nearest"))


@dataclass(frozen=True, kw_only=True)
class NetworkGraspQuality:
    """Let any function rate grasps in a depth image; a `GraspQuality`. For a camera that looks straight down.

    Attributes:
        network: Takes depth [m], NaN where nothing was seen, shape (H, W), a copy of its own; returns quality in
            [0, 1], angle in which the jaws close, from the image's columns to its rows [rad], and width [pixel], of
            shape (H, W) each.
        depth_m: How far the tips go below the surface [m]; ours, the network does not say.
        table_m: Height of the table in the world [m].
        above_table_m: The tips stay so far above it [m].
    """

    network: Callable[[FloatArray], Images]
    depth_m: float = 0.03
    table_m: float = 0.0
    above_table_m: float = 0.004

    def quality(self, view: DepthView) -> GraspMaps:
        """Ask the network; angles are turned into the world, widths into metres at the depth of their pixel.

        A pixel without depth has no grasp, nor has one that shows nothing higher than the tips have to stay: a network
        that answers everywhere answers on the table, too.

        Raises:
            ShapeError: If it does not answer with three images of the view's shape, or with something that is not
                finite, or with a quality beyond [0, 1] or a width below 0.
            InputError: If the camera does not look down on the table, or its depths are in millimetres.
        """
        check_from_above(view, self.table_m)
        shape = view.depth_m.shape
        quality, angle, width = self._asked(view.depth_m.copy(), shape)
        depth_m, K = view.depth_m, view.intrinsics
        along = np.stack([np.cos(angle) / K[0, 0], np.sin(angle) / K[1, 1], np.zeros(shape)], axis=-1)
        in_world = along @ view.T_world_camera[:3, :3].T
        seen = np.isfinite(depth_m)
        over_table_m = np.where(seen, points_image(view)[..., 2] - self.table_m - self.above_table_m, 0.0)
        there = over_table_m > 0
        return GraspMaps(
            np.where(there, quality, 0.0),
            np.arctan2(in_world[..., 1], in_world[..., 0]),
            np.where(there, width * np.linalg.norm(along, axis=-1) * depth_m, 0.0),
            np.clip(over_table_m, 0.0, self.depth_m),
        )

    def _asked(self, depth_m: FloatArray, shape: tuple[int, ...]) -> list[FloatArray]:
        answer = self.network(depth_m)
        if len(answer) != 3:
            message = f"the network gave {len(answer)} images, not quality, angle and width"
            raise ShapeError(message, name="answer", expected=3, got=len(answer))
        images = [np.asarray(image, dtype=np.float64) for image in answer]
        for name, image, greatest in zip(("quality", "angle", "width"), images, (1.0, np.inf, np.inf), strict=True):
            if image.shape != shape:
                message = f"the network gave {name} of shape {image.shape} for an image of {shape}"
                raise ShapeError(message, name=name, expected=shape, got=image.shape)
            if lost := int((~np.isfinite(image)).sum()):
                message = f"the network's {name} is no number in {lost} pixels; it gives 0 where there is no grasp"
                raise ShapeError(message, name=name, lost=lost)
            least = -np.inf if name == "angle" else 0.0
            if not ((image >= least) & (image <= greatest)).all():
                low, high = float(np.min(image)), float(np.max(image))
                message = (
                    f"the network's {name} goes from {low:.3g} to {high:.3g}, not within {least:g} and {greatest:g}"
                )
                raise ShapeError(message, name=name, least=low, most=high)
        return images
