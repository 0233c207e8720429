"""Errors of many trials as the papers draw them: cumulative shares, and how errors shrink from move to move."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rfcompass.arrays import FloatArray

_COLUMNS = 2


@dataclass(frozen=True, slots=True)
class Panel:
    """One pair of axes.

    Attributes:
        title: What all its lines share.
        lines: Values by label: errors of all trials, shape (n,), for shares; of each number of moves for progress.
        marks: Vertical lines by label, for example medians of a paper.
    """

    title: str
    lines: Mapping[str, FloatArray | Sequence[FloatArray]]
    marks: Mapping[str, float]


def draw_shares(panels: Sequence[Panel], what: str, largest: float) -> Figure:
    """Draw how many trials err by at most so much: one step curve for each line.

    Args:
        panels: What to draw; a line is the errors of all trials, shape (n,), in the unit of `what`.
        what: Name and unit of the horizontal axis.
        largest: Where the horizontal axis ends; what is larger lies to its right.
    """
    figure, grid = _grid(len(panels))
    for axes, panel in zip(grid, panels, strict=False):
        for label, errors in panel.lines.items():
            ordered = np.sort(np.asarray(errors, dtype=np.float64))
            axes.step([0.0, *ordered], np.linspace(0.0, 100.0, len(ordered) + 1), where="post", label=label)
        _mark(axes, panel.marks)
        _finish(axes, panel.title, what, "trials, %")
        axes.set_xlim(0.0, largest)
        axes.set_ylim(0.0, 100.0)
    return figure


def draw_progress(panels: Sequence[Panel], moves: Sequence[int], what: str, largest: float) -> Figure:
    """Draw median, 10 % and 90 % quantile of the error against the number of stops.

    Args:
        panels: What to draw; a line is a sequence with the errors after each number of stops.
        moves: Numbers of stops.
        what: Name and unit of the vertical axis.
        largest: Where the vertical axis ends.
    """
    figure, grid = _grid(len(panels))
    for axes, panel in zip(grid, panels, strict=False):
        for label, errors in panel.lines.items():
            low, middle, high = np.array([_quantiles(after) for after in errors]).T
            (line,) = axes.plot(moves, middle, "o-", ms=3, label=label)
            axes.fill_between(moves, low, high, color=line.get_color(), alpha=0.15, lw=0)
        for label, value in panel.marks.items():
            axes.axhline(value, color="0.4", ls=":", lw=1)
            axes.annotate(label, (moves[-1], value), ha="right", va="bottom", fontsize=8, color="0.3")
        _finish(axes, panel.title, "stops", what)
        axes.set_ylim(0.0, largest)
    return figure


def _quantiles(errors: FloatArray) -> FloatArray:
    """10 %, 50 % and 90 %; NaN where there is no answer at all."""
    return np.quantile(errors, (0.1, 0.5, 0.9)) if len(errors) else np.full(3, np.nan)


def _grid(count: int) -> tuple[Figure, list[Axes]]:
    rows = -(-count // _COLUMNS)
    figure = Figure(figsize=(10, 3.6 * rows), layout="constrained")
    return figure, [figure.add_subplot(rows, min(count, _COLUMNS), index + 1) for index in range(count)]


def _mark(axes: Axes, marks: Mapping[str, float]) -> None:
    for label, value in marks.items():
        axes.axvline(value, color="0.4", ls=":", lw=1)
        axes.annotate(label, (value, 2.0), rotation=90, ha="right", va="bottom", fontsize=8, color="0.3")


def _finish(axes: Axes, title: str, across: str, up: str) -> None:
    axes.set_title(title, loc="left", fontsize=10)
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, fontsize=8)
