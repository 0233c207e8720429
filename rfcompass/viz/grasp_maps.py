"""The grasps of a depth image as a picture."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rfcompass.arrays import FloatArray
from rfcompass.types import DepthView, GraspMaps
from rfcompass.viz.search_report import pixels_of

_SHOWN = ("#d4380d", "#1554c0")  # the best grasp, the others


def draw_grasps(axes: Axes, view: DepthView, maps: GraspMaps, pixels: Sequence[tuple[int, int]]) -> None:
    """Draw the quality over the depth, and where the jaws of some grasps close.

    Args:
        axes: Where to draw.
        view: The image.
        maps: The best grasp at each of its pixels.
        pixels: Row and column of the grasps, best first.
    """
    axes.imshow(view.depth_m, cmap="gray_r")
    shown = axes.imshow(np.where(maps.quality > 0, maps.quality, np.nan), cmap="viridis", vmin=0, vmax=1)
    axes.figure.colorbar(shown, ax=axes, shrink=0.7, label="chance to hold")
    for number, pixel in reversed(list(enumerate(pixels))):
        axes.plot(*pixels_of(view, jaws_m(view, maps, pixel)).T, "o-", color=_SHOWN[number > 0], markersize=4)
    rows, columns = view.depth_m.shape
    axes.set(xlim=(-0.5, columns - 0.5), ylim=(rows - 0.5, -0.5), xticks=[], yticks=[])


def draw_grasp_maps(view: DepthView, maps: GraspMaps, pixels: Sequence[tuple[int, int]]) -> Figure:
    """Draw the grasps of an image, beside its colours if it has them; arguments as for `draw_grasps`."""
    figure = Figure(figsize=(11.0 if view.colour is not None else 5.5, 3.6), layout="constrained")
    axes = figure.subplots(1, 1 if view.colour is None else 2, squeeze=False)[0]
    if view.colour is not None:
        axes[0].imshow(view.colour.astype(np.uint8))
        axes[0].set(xticks=[], yticks=[])
    draw_grasps(axes[-1], view, maps, pixels)
    if pixels:
        axes[-1].set_title(f"best: {maps.quality[pixels[0]]:.2f}", loc="left")
    return figure


def jaws_m(view: DepthView, maps: GraspMaps, pixel: tuple[int, int]) -> FloatArray:
    """Both ends of what a pixel's grasp closes on, at the pixel's own height, in the world [m], shape (2, 3)."""
    row, column = pixel
    ray = np.linalg.inv(view.intrinsics) @ np.array([column, row, 1.0])
    point_m = view.T_world_camera[:3, :3] @ (view.depth_m[pixel] * ray) + view.T_world_camera[:3, 3]
    angle_rad, half_m = maps.angle_rad[pixel], maps.width_m[pixel] / 2
    along = half_m * np.array([np.cos(angle_rad), np.sin(angle_rad), 0.0])
    return np.stack([point_m - along, point_m + along])
