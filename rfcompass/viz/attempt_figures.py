"""Figures of grasp trials: how many attempts a hand needs, like Fig. 14 and 15 of [Wang2013]."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from rfcompass.arrays import FloatArray

COLOURS = ("#d1495b", "#e0a458", "#3b6ea5", "#2a9d8f", "#6d597a")


def draw_attempts(
    curves: Mapping[str, Mapping[str, FloatArray]], references: Mapping[str, FloatArray] | None = None
) -> Figure:
    """Draw the share of runs that have succeeded within each number of attempts.

    Args:
        curves: For each panel, for example a rule, and each line in it, for example a hand: the share of runs that
            ended with success within 1, 2, … attempts, shape (T,) each.
        references: Curves to compare with, dashed, in every panel and in the colour of the line of that name; a
            single number is a first attempt without a curve.
    """
    figure = Figure(figsize=(4.2 * len(curves), 3.8), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(curves), sharex=True, sharey=True))
    for axes, (title, lines) in zip(panels, curves.items(), strict=True):
        colours = dict(zip(lines, COLOURS, strict=False))
        for name, share in lines.items():
            axes.step(np.arange(1, len(share) + 1), share, where="post", color=colours[name], label=name)
        for name, share in (references or {}).items():
            attempt = np.arange(1, len(share) + 1)
            style = "--" if len(share) > 1 else "o"
            axes.plot(attempt, share, style, color=colours.get(name, "grey"), lw=1.0, mfc="none", alpha=0.8)
        axes.set(title=title, xlabel="attempts", xlim=(0, max(map(len, lines.values()))), ylim=(0, 1.02))
    panels[0].set_ylabel("share of runs that hold the part")
    panels[-1].legend(loc="lower right", frameon=False)
    return figure
