"""Fig. 7, 8, 12 and 13 of [Wang2013] from the rows of our studies."""

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from matplotlib.figure import Figure

from rfcompass.arrays import FloatArray
from rfcompass.evaluation.records import CellValue
from rfcompass.viz.error_figures import Panel, draw_progress, draw_shares

CM, DEGREES = 100.0, 180.0 / np.pi
CENTRE, THETA = "error of the centre [cm]", "error of θ [°]"
TAGS = (1, 2, 3, 4)
# Medians [cm] and [°] by number of part tags [Wang2013], Fig. 12 and 13.
FIG_12, FIG_13 = {1: 4.03, 2: 2.76, 4: 1.28}, {2: 5.77, 4: 3.3}


def picked(table: pa.Table, column: str, scale: float = 1.0, **cell: CellValue) -> FloatArray:
    """Values of a column in the rows of a cell, where there is one, times a factor, shape (n,)."""
    keep = pc.is_valid(table.column(column))
    for factor, value in cell.items():
        keep = pc.and_(keep, pc.equal(table.column(factor), value))
    return np.asarray(table.filter(keep).column(column).to_numpy() * scale)


def draw_accuracy(table: pa.Table) -> dict[str, Figure]:
    """Fig. 12 and 13: shares of trials by error, after three stops, for each rig in sight and its best method."""
    rigs = {"near L": "posterior", "far L": "posterior", "the paper's, X4": "paper"}
    figures = {}
    for title, column, scale, paper, largest in (
        (CENTRE, "centre_3_m", CM, FIG_12, 20.0),
        (THETA, "theta_3_rad", DEGREES, FIG_13, 30.0),
    ):
        panels = [
            Panel(
                f"{sight}, {rig}: {method}",
                {
                    f"K = {tags}": errors
                    for tags in TAGS
                    if len(errors := picked(table, f"{method}_{column}", scale, sight=sight, rig=rig, tags=tags))
                },
                {f"paper, K = {tags}": median for tags, median in paper.items()},
            )
            for rig, method in rigs.items()
            for sight in ("in sight", "hidden")
        ]
        figures[f"After three stops: {title}. Dotted: the paper's medians."] = draw_shares(panels, title, largest)
    return figures


def draw_resolution(table: pa.Table) -> dict[str, Figure]:
    """Fig. 7 and 8: error after each number of stops: median, and 10 to 90 % as a band."""
    moves, figures = (1, 2, 3, 5, 7, 10), {}
    for flips, name in ((0.0, "comparisons all right"), (0.1, "10 % of the comparisons flipped")):
        for title, column, scale, largest in (
            (CENTRE, "centre_{}_m", CM, 15.0),
            (THETA, "theta_{}_rad", DEGREES, 30.0),
        ):
            panels = [
                Panel(
                    arm,
                    {
                        method: [
                            picked(table, f"{method}_{column.format(count)}", scale, flips=flips, arm=arm)
                            for count in moves
                        ]
                        for method in ("paper", "consistency", "posterior")
                    },
                    {},
                )
                for arm in dict.fromkeys(table.column("arm").to_pylist())
            ]
            figures[f"{name}: {title}"] = draw_progress(panels, moves, title, largest)
    return figures
