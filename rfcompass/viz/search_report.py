"""A search in a pile as a page to read: what was seen, believed and gone for in each action, and what came of it."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rfcompass.arrays import FloatArray
from rfcompass.types.piles import DepthView
from rfcompass.types.search import SearchResult, SearchStep
from rfcompass.viz.page import PageFigure, PagePart, PageTable, write_page

# Ours: half the hand's width along and across the closing that is drawn [m]; ticks between pixels.
_HALF_ALONG_M, _HALF_ACROSS_M = 0.0545, 0.011
_CHOSEN, _OTHER, _HAND = "#d4380d", "#1d2733", "#1554c0"
_SHOWN_SCORES = 12


def write_search_report(path: Path, result: SearchResult, facts: Sequence[tuple[str, str]] = ()) -> None:
    """Write the page of a search: one self-contained HTML file, atomically.

    Args:
        path: File to write.
        result: The search.
        facts: Rows of name and value.
    """
    parts: list[PagePart] = [result.message, PageTable("The search", ("what", "value"), list(facts))]
    rows = [_row(number, step) for number, step in enumerate(result.steps, start=1)]
    columns = ("action", "at [s]", "goes for", "score", "chance", "came of it", "jaws [mm]", "hidden [l]")
    parts.append(PageTable("Actions", columns, rows))
    for number, step in enumerate(result.steps, start=1):
        parts.append(PageFigure(f"Action {number}: {_goes_for(step)}: {step.attempt.outcome}.", draw_decision(step)))
    parts.append(
        "Left: the image in which the object was chosen, borders of objects, their scores (the largest ones, as share "
        "of the best), the chosen object in red and the hand in blue. Right: where the target was thought to be, the "
        "sum over each column, and the hand."
    )
    write_page(path, "A search in a pile", parts)


def draw_decision(step: SearchStep) -> Figure:
    """Draw one decision: objects with their scores and the hand in the image, and the map from above."""
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    image, above = figure.subplots(1, 2, width_ratios=(1.45, 1))
    _draw_image(image, step)
    _draw_map(above, step)
    return figure


def _draw_image(axes: Axes, step: SearchStep) -> None:
    view, labels = step.view, step.masks.labels
    if view.colour is None:
        axes.imshow(view.depth_m, cmap="gray_r")
    else:
        axes.imshow(view.colour.astype(np.uint8))
    chosen = step.action.mask_label
    for label in np.unique(labels[labels > 0]):
        colour, width = (_CHOSEN, 1.6) if label == chosen else (_OTHER, 0.6)
        axes.contour(labels == label, levels=[0.5], colors=[colour], linewidths=[width])
    scores = sorted(step.action.scores.items(), key=lambda one: -one[1])[:_SHOWN_SCORES]
    best = max((score for _, score in scores), default=0.0)
    for label, score in scores:
        if best > 0 and (labels == label).any():
            row, column = np.argwhere(labels == label).mean(axis=0)
            axes.text(column, row, f"{score / best:.2f}", color="white", fontsize=7, ha="center", va="center")
    corners = pixels_of(view, _hand_m(step.action.T_world_hand))
    axes.plot(*corners.T, color=_HAND, lw=1.4)
    axes.set(xlim=(-0.5, labels.shape[1] - 0.5), ylim=(labels.shape[0] - 0.5, -0.5), xticks=[], yticks=[])


def _draw_map(axes: Axes, step: SearchStep) -> None:
    hand_m = _hand_m(step.action.T_world_hand)
    if step.grid is None:
        axes.text(0.5, 0.5, "the target is in sight", ha="center", va="center", transform=axes.transAxes)
        axes.set(xticks=[], yticks=[])
        return
    grid = step.grid
    ends_m = grid.origin_m[:2] - grid.spacing_m / 2
    far_m = ends_m + grid.spacing_m * np.array(grid.values.shape[:2])
    axes.imshow(
        grid.values.sum(axis=2).T, origin="lower", extent=(ends_m[0], far_m[0], ends_m[1], far_m[1]), cmap="magma"
    )
    axes.plot(*hand_m[:, :2].T, color="#7fb2ff", lw=1.4)
    axes.set(xlabel="x [m]", ylabel="y [m]")


def _hand_m(T_world_hand: FloatArray) -> FloatArray:
    """Outline of the open hand, closed, in the world [m], shape (5, 3); the jaws close along the tool's y."""
    signs = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1), (1, 1)], dtype=np.float64)
    local = np.column_stack([signs[:, 0] * _HALF_ACROSS_M, signs[:, 1] * _HALF_ALONG_M, np.zeros(5)])
    return np.asarray(local @ T_world_hand[:3, :3].T + T_world_hand[:3, 3])


def pixels_of(view: DepthView, points_m: FloatArray) -> FloatArray:
    """Column and row at which points of the world appear, shape (P, 3) [m] to (P, 2)."""
    R, t = view.T_world_camera[:3, :3], view.T_world_camera[:3, 3]
    seen = (points_m - t) @ R @ view.intrinsics.T
    return np.asarray(seen[:, :2] / seen[:, 2:])


def _goes_for(step: SearchStep) -> str:
    return "the target" if step.on_target else f"object {step.action.mask_label}"


def _row(number: int, step: SearchStep) -> tuple[object, ...]:
    attempt = step.attempt
    came = attempt.outcome + (", the target" if attempt.shows_target else "")
    came += f": {attempt.message}" if attempt.message else ""
    came += f"; {len(attempt.epcs)} tag(s) gone" if attempt.epcs else ""
    return (
        number,
        f"{step.elapsed_s:.0f}",
        _goes_for(step),
        f"{step.action.score:.3g}",
        f"{step.chance:.2f}",
        came,
        f"{1000 * attempt.gap_m:.0f}",
        f"{1000 * step.hidden_m3:.1f}",
    )
