"""Picture of a tag layout: where a part could be located how well."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from rfcompass.arrays import FloatArray

WORST_CM = 15.0  # beyond this, worse is no different


def draw_expected_error(
    maps_m: Mapping[str, FloatArray], x_m: FloatArray, y_m: FloatArray, anchors_m: Mapping[str, FloatArray]
) -> Figure:
    """Draw the expected error over the workspace, one panel for each layout.

    Args:
        maps_m: Expected error by layout [m], shape (Y, X) each.
        x_m: x of the columns in the base frame [m], shape (X,).
        y_m: y of the rows [m], shape (Y,).
        anchors_m: Tags of each layout at the first stop, base frame [m], shape (N, 3) each.
    """
    figure = Figure(figsize=(5.5 * len(maps_m), 5), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(maps_m), sharex=True, sharey=True))
    for axes, (name, errors_m) in zip(panels, maps_m.items(), strict=True):
        shown = axes.pcolormesh(
            x_m, y_m, 100.0 * errors_m, vmin=0.0, vmax=WORST_CM, cmap="viridis_r", shading="nearest"
        )
        tags_m = anchors_m[name]
        axes.plot(tags_m[:, 0], tags_m[:, 1], "s", color="#d1495b", mec="white", label="robot tags")
        axes.set(
            title=f"{name}: {100.0 * np.nanmean(errors_m):.1f} cm in the mean", xlabel="x in base [m]", aspect="equal"
        )
    panels[0].set_ylabel("y in base [m]")
    panels[0].legend(loc="upper left")
    figure.colorbar(shown, ax=list(panels), label="expected error of a part tag [cm]")
    return figure
