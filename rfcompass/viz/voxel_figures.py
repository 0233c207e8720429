"""Voxel maps as slices, in the manner of Fig. 3 and Fig. 6 of [Boroushaki2023]."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.types.piles import VoxelGrid

_MARK_COLOUR = "#1d2733"


def draw_maps(
    maps: Mapping[str, VoxelGrid], marks_m: Mapping[str, FloatArray] | None = None, y_m: float | None = None
) -> Figure:
    """Draw maps side by side, as Fig. 3 has C, R, C + R and the occupancy: from above and cut upright.

    From above a column shows its value of the largest size.

    Args:
        maps: Each map under its title, from left to right.
        marks_m: Points to mark under their names, in the world frame [m], shape (3,) each, for example tags.
        y_m: Where the upright cut goes [m]; through the voxel of the largest size of the last map if None.

    Raises:
        InputError: If there is no map, or the cut misses one.
    """
    if not maps:
        raise InputError("there is no map to draw", maps=[])
    last = list(maps.values())[-1]
    cut_m = _strongest_m(last)[1] if y_m is None else y_m
    figure = Figure(figsize=(4.2 * len(maps), 4.6), layout="constrained")
    panels = figure.subplots(2, len(maps), squeeze=False, height_ratios=(2, 1))
    for column, (title, grid) in enumerate(maps.items()):
        above, upright = panels[:, column]
        top = _show(above, _flattened(grid), grid, (0, 1))
        _show(upright, grid.values[:, _cut(grid, 1, cut_m)], grid, (0, 2), top)
        above.set_title(title, loc="left")
        above.axhline(cut_m, color=_MARK_COLOUR, lw=0.6, ls=":")
        _mark(above, marks_m or {}, (0, 1))
        _mark(upright, marks_m or {}, (0, 2))
        figure.colorbar(above.images[0], ax=[above, upright], shrink=0.7)
    return figure


def draw_kernels(
    kernels: Mapping[str, VoxelGrid], centre_m: FloatArray, item_size_m: FloatArray | None = None
) -> Figure:
    """Draw kernels in an upright cut through their middle, as Fig. 6 lays them over the item.

    Args:
        kernels: Each kernel under its title, from left to right.
        centre_m: The tag, in the world frame [m], shape (3,).
        item_size_m: Width and height of the item to outline about the tag [m], shape (2,); nothing if None.

    Raises:
        InputError: If there is no kernel, or the cut misses one.
    """
    if not kernels:
        raise InputError("there is no kernel to draw", kernels=[])
    figure = Figure(figsize=(4.2 * len(kernels), 3.4), layout="constrained")
    top = max(float(np.abs(grid.values).max()) for grid in kernels.values())
    for axes, (title, grid) in zip(figure.subplots(1, len(kernels), squeeze=False)[0], kernels.items(), strict=True):
        _show(axes, grid.values[:, _cut(grid, 1, float(centre_m[1]))], grid, (0, 2), top)
        axes.plot(centre_m[0], centre_m[2], "x", color=_MARK_COLOUR, ms=7)
        axes.set_title(title, loc="left")
        if item_size_m is not None:
            width_m, height_m = (float(edge_m) for edge_m in item_size_m)
            corner = float(centre_m[0]) - width_m / 2, float(centre_m[2]) - height_m / 2
            axes.add_patch(Rectangle(corner, width_m, height_m, fill=False, ec=_MARK_COLOUR, lw=1.5))
    figure.colorbar(figure.axes[0].images[0], ax=figure.axes)
    return figure


def _show(axes: Axes, image: FloatArray, grid: VoxelGrid, over: tuple[int, int], top: float | None = None) -> float:
    """Show values over two axes of the world; return the size of the strongest colour."""
    top = (float(np.abs(image).max()) or 1.0) if top is None else top
    low = grid.origin_m - grid.spacing_m / 2
    high = low + grid.spacing_m * np.array(grid.values.shape)
    a, b = over
    extent = (low[a], high[a], low[b], high[b])
    axes.imshow(image.T, origin="lower", extent=extent, cmap="RdBu_r", vmin=-top, vmax=top)
    axes.set(xlabel=f"{'xyz'[a]} [m]", ylabel=f"{'xyz'[b]} [m]")
    return top


def _flattened(grid: VoxelGrid) -> FloatArray:
    """Value of the largest size in each column, shape (X, Y)."""
    level = np.abs(grid.values).argmax(axis=2)[..., None]
    return np.take_along_axis(grid.values, level, axis=2)[..., 0]


def _strongest_m(grid: VoxelGrid) -> FloatArray:
    voxel = np.unravel_index(np.abs(grid.values).argmax(), grid.values.shape)
    return np.asarray(grid.origin_m + grid.spacing_m * np.array(voxel))


def _cut(grid: VoxelGrid, axis: int, at_m: float) -> int:
    index = round((at_m - float(grid.origin_m[axis])) / grid.spacing_m)
    if not 0 <= index < grid.values.shape[axis]:
        raise InputError(f"a cut at {'xyz'[axis]} = {at_m} m misses the map", axis="xyz"[axis], at_m=at_m)
    return index


def _mark(axes: Axes, marks_m: Mapping[str, FloatArray], over: tuple[int, int]) -> None:
    for name, point_m in marks_m.items():
        place = (point_m[over[0]], point_m[over[1]])
        axes.plot(*place, "+", color=_MARK_COLOUR, ms=8)
        around = {"fc": "white", "ec": "none", "alpha": 0.6, "pad": 0.5}
        axes.annotate(name, place, xytext=(4, 4), textcoords="offset points", fontsize=7, bbox=around)
