"""Pictures of the partitioned plane, like Fig. 1 and Fig. 6 of [Wang2013]."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import as_pose2
from rfcompass.types.comparisons import HalfSpaces
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.tags import TagLayout, TagPositions

ANCHOR_COLOUR, LINE_COLOUR, REGION_COLOUR, PART_COLOUR = "#3b6ea5", "#9aa7b4", "#f2c14e", "#d1495b"


def draw_partition(
    rows: HalfSpaces,
    anchors: Sequence[TagPositions],
    estimate: PartEstimate,
    part: TagLayout,
    part_length_m: float,
    bounds_m: FloatArray,
) -> Figure:
    """Draw the lines that the comparisons cut, the region they leave, and the estimated part in it.

    Args:
        rows: All rows in one frame, over the plane or over the pose [Wang2013], Eq. 3 or 7. Rows over the pose are
            cut at the estimated orientation.
        anchors: Robot tags of each stop, in the same frame; later stops are drawn darker.
        estimate: The answer in the same frame.
        part: Tags on the part.
        part_length_m: Length of the part along its x axis [m], for its outline.
        bounds_m: What to show [m], [[xmin, xmax], [ymin, ymax]], shape (2, 2).
    """
    figure = Figure(figsize=(7, 7), layout="constrained")
    axes = figure.add_subplot()
    _draw_lines(axes, *_plane_rows(rows, estimate.theta_rad), bounds_m)
    if len(estimate.region_m):
        axes.add_patch(
            Polygon(estimate.region_m, fc=REGION_COLOUR, ec="none", alpha=0.8, label="what is left", zorder=2)
        )
    for age, positions in enumerate(reversed(anchors)):
        label = "robot tags" if age == 0 else None
        axes.plot(
            *positions.points_m[:, :2].T, "s", color=ANCHOR_COLOUR, ms=6, alpha=0.75**age, label=label, zorder=3
        )  # fmt: skip
    _draw_part(axes, estimate, part, part_length_m)
    axes.set_xlim(*bounds_m[0])
    axes.set_ylim(*bounds_m[1])
    axes.set_aspect("equal")
    axes.set_xlabel("x in base [m]")
    axes.set_ylabel("y in base [m]")
    stops = "one stop" if len(anchors) == 1 else f"the last {len(anchors)} stops"
    axes.set_title(f"{len(rows)} comparisons of {stops}", loc="left")
    axes.legend(loc="upper left", frameon=True)
    return figure


def _plane_rows(rows: HalfSpaces, theta_rad: float | None) -> tuple[FloatArray, FloatArray]:
    """Cut rows over [x, y, cos θ, sin θ] at one θ, which leaves half-planes of the centre."""
    if rows.A.shape[1] == 2:
        return rows.A, rows.b
    theta = 0.0 if theta_rad is None else theta_rad
    return rows.A[:, :2], rows.b - rows.A[:, 2:] @ np.array([np.cos(theta), np.sin(theta)])


def _draw_lines(axes: Axes, A: FloatArray, b: FloatArray, bounds_m: FloatArray) -> None:
    """Draw each line a · p = b as a chord long enough to cross the picture."""
    centre, reach = bounds_m.mean(axis=1), float(np.ptp(bounds_m, axis=1).max())
    for normal, offset in zip(A, b, strict=True):
        length = np.hypot(*normal)
        if length < 1e-12:
            continue
        foot = centre + (offset - normal @ centre) / length**2 * normal
        along = np.array([-normal[1], normal[0]]) / length * reach
        axes.plot(*np.array([foot - along, foot + along]).T, color=LINE_COLOUR, lw=0.4, alpha=0.5, zorder=1)


def _draw_part(axes: Axes, estimate: PartEstimate, part: TagLayout, length_m: float) -> None:
    axes.plot(*estimate.centre_m, "+", color=PART_COLOUR, ms=14, mew=2, label="estimated centre", zorder=4)
    if estimate.theta_rad is None:
        return
    T_base_part = as_pose2([*estimate.centre_m, estimate.theta_rad])
    ends = T_base_part.apply(np.array([[-length_m / 2.0, 0.0], [length_m / 2.0, 0.0]]))
    axes.plot(*ends.T, color=PART_COLOUR, lw=5, alpha=0.5, solid_capstyle="butt", zorder=3)
    axes.plot(*T_base_part.apply(part.points_m[:, :2]).T, "o", color=PART_COLOUR, ms=5, zorder=4)
