"""Figures of a sweep: the antenna path, where the tags are, and what the matched filter sees."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rfcompass.arrays import FloatArray
from rfcompass.types.fixes import TagFix
from rfcompass.types.piles import VoxelGrid
from rfcompass.types.reads import ReadTrace

PATH_COLOUR, TAG_COLOUR, LOW_COLOUR = "#3b6ea5", "#d1495b", "#e0a458"


def draw_survey(antenna_positions_m: FloatArray, fixes: Sequence[TagFix], frame: str) -> Figure:
    """Draw a plan view of the antenna path and every located tag with its confidence box.

    Args:
        antenna_positions_m: Antenna positions in `frame` [m], shape (M, 3).
        fixes: Located tags in the same frame.
        frame: Name of the frame, for the axis labels.
    """
    figure = Figure(figsize=(8, 5), layout="constrained")
    axes = figure.add_subplot()
    axes.plot(*antenna_positions_m[:, :2].T, ".", color=PATH_COLOUR, ms=4, label="antenna path")
    for index, fix in enumerate(fixes):
        _draw_fix(axes, fix, labelled=index == 0)
    _finish_plan(axes, f"Survey: {len(fixes)} tags", frame)
    axes.legend(loc="best", frameon=False)
    return figure


def draw_image(image: VoxelGrid, antenna_positions_m: FloatArray, fix: TagFix, frame: str) -> Figure:
    """Draw the SAR image of one tag, P / max P, as a plan view (maximum over the heights).

    Args:
        image: Power of the matched filter [Boroushaki2023], Eq. 1.
        antenna_positions_m: Antenna positions [m], shape (M, 3).
        fix: Where the tag was located.
        frame: Name of the frame, for the axis labels.
    """
    power = image.values.max(axis=2)
    lower = image.origin_m[:2] - image.spacing_m / 2.0
    upper = lower + np.array(power.shape) * image.spacing_m
    extent = (lower[0], upper[0], lower[1], upper[1])
    figure = Figure(figsize=(8, 5), layout="constrained")
    axes = figure.add_subplot()
    shown = axes.imshow(power.T / power.max(), origin="lower", extent=extent, cmap="viridis", vmin=0.0, vmax=1.0)
    axes.plot(*antenna_positions_m[:, :2].T, ".", color="white", ms=3)
    axes.plot(*fix.point_m[:2], "x", color=TAG_COLOUR, ms=10, mew=2)
    figure.colorbar(shown, ax=axes, label="matched filter power, P / max P")
    _finish_plan(axes, f"SAR image of {fix.epc}", frame)
    return figure


def draw_phase(trace: ReadTrace) -> Figure:
    """Draw the phase of one tag's channel along the antenna path, one line for each frequency."""
    figure = Figure(figsize=(8, 3.5), layout="constrained")
    axes = figure.add_subplot()
    path_m = np.concatenate([[0.0], np.linalg.norm(np.diff(trace.antenna_positions_m, axis=0), axis=1).cumsum()])
    for f, frequency_hz in enumerate(trace.frequencies_hz):
        heard = trace.mask[:, f]
        phase = -np.unwrap(np.angle(trace.channel[heard, f]))
        axes.plot(path_m[heard], phase, ".-", ms=3, lw=0.8, label=f"{frequency_hz / 1e6:.3f} MHz")
    axes.set_xlabel("along the antenna path [m]")
    axes.set_ylabel("2π f d / c + constant [rad]")
    axes.set_title(f"Unwrapped phase of {trace.epc}", loc="left")
    axes.legend(fontsize=7, frameon=False, ncols=2)
    return figure


def _draw_fix(axes: Axes, fix: TagFix, *, labelled: bool) -> None:
    x, y = fix.point_m[:2]
    colour = TAG_COLOUR if fix.confident else LOW_COLOUR
    axes.plot(x, y, "o", color=colour, ms=6, label="tag (box: 0.84 of peak power)" if labelled else None)
    axes.errorbar(x, y, xerr=fix.box_m[0] / 2, yerr=fix.box_m[1] / 2, color=colour, lw=1, alpha=0.6)
    axes.annotate(f"…{fix.epc[-4:]}", (x, y), textcoords="offset points", xytext=(5, 5), fontsize=8)


def _finish_plan(axes: Axes, title: str, frame: str) -> None:
    axes.set_aspect("equal")
    axes.set_xlabel(f"x in {frame} [m]")
    axes.set_ylabel(f"y in {frame} [m]")
    axes.set_title(title, loc="left")
