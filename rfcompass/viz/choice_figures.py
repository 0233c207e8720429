"""What a policy chose in a pile: objects coloured by their scores, and the grasp, as in Fig. 7 of [Boroushaki2023]."""

from collections.abc import Mapping

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from rfcompass.arrays import FloatArray
from rfcompass.errors import ShapeError
from rfcompass.types.piles import DepthView, ExtractionAction, InstanceMasks
from rfcompass.viz.colours import CHOSEN, PART, css

_BARRED, _TABLE = 0.55, 0.93  # greys
_LEAST_PIXELS = 60  # of an object that gets a number


def draw_choice(
    view: DepthView,
    masks: InstanceMasks,
    scores: Mapping[int, float],
    action: ExtractionAction | None = None,
    title: str = "",
) -> Figure:
    """Draw an image beside its objects with their scores.

    Grey objects have none, or the gate bars them. The chosen one has a border; the bar across it is the opening of the
    jaws, its ends are where they come down.

    Args:
        view: What the camera sees.
        masks: Its objects.
        scores: Score of each object by its label; the largest is 1 in the picture.
        action: What was chosen; nothing is marked if None.
        title: Of the picture.

    Raises:
        ShapeError: If masks and view differ in size.
    """
    if masks.labels.shape != view.depth_m.shape:
        message = f"masks: have shape {masks.labels.shape}, the view {view.depth_m.shape}"
        raise ShapeError(message, name="masks", expected=view.depth_m.shape, got=masks.labels.shape)
    figure = Figure(figsize=(10.5, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.imshow(view.depth_m if view.colour is None else view.colour, cmap="gray_r")
    shares = shares_of(scores)
    right.imshow(_painted(masks, shares))
    _write_numbers(right, masks, shares)
    for axes in (left, right):
        axes.set_axis_off()
        if action is not None:
            axes.contour(masks.labels == action.mask_label, [0.5], colors=[css(CHOSEN)], linewidths=1.4)
            _draw_jaws(axes, view, action)
    left.set_title(title, loc="left")
    right.set_title("score, the largest as 1", loc="left")
    figure.colorbar(ScalarMappable(Normalize(0, 1), "viridis"), ax=right, shrink=0.8)
    return figure


def shares_of(scores: Mapping[int, float]) -> dict[int, float]:
    """Scores from 0 to 1, those that are not finite left out; all 0 if none is above 0."""
    finite = {label: score for label, score in scores.items() if np.isfinite(score)}
    most = max(finite.values(), default=0.0)
    return {label: max(score, 0.0) / most if most > 0 else 0.0 for label, score in finite.items()}


def _painted(masks: InstanceMasks, shares: Mapping[int, float]) -> FloatArray:
    """Image of red, green and blue, shape (H, W, 3)."""
    image = np.full((*masks.labels.shape, 3), _TABLE)
    image[masks.labels > 0] = _BARRED
    for label, share in shares.items():
        image[masks.labels == label] = colormaps["viridis"](share)[:3]
    return image


def _write_numbers(axes: Axes, masks: InstanceMasks, shares: Mapping[int, float]) -> None:
    for label, share in shares.items():
        where = np.argwhere(masks.labels == label)
        if len(where) >= _LEAST_PIXELS:
            row, column = np.median(where, axis=0)
            colour = "black" if share > 0.6 else "white"
            axes.text(column, row, f"{share:.2f}", color=colour, ha="center", va="center", fontsize=7)


def _draw_jaws(axes: Axes, view: DepthView, action: ExtractionAction) -> None:
    """The opening, along the hand's y, at the height of its tool."""
    T = action.T_world_hand
    ends_m = T[:3, 3] + np.outer([-0.5, 0.5], action.aperture_m * T[:3, 1])
    in_camera = (ends_m - view.T_world_camera[:3, 3]) @ view.T_world_camera[:3, :3]
    pixels = in_camera @ view.intrinsics.T
    u, v = (pixels[:, :2] / pixels[:, 2:]).T
    axes.plot(u, v, "-", color=css(PART), lw=2.0, marker="s", ms=5)
