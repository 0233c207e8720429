"""Fig. 10 and 11 of [Wang2013] from the rows of `path-ratio`: shares of runs by ratio, and the ways of one run."""

import numpy as np
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from rfcompass.evaluation.shortest_way import outlines_m
from rfcompass.studies.error_pictures import picked
from rfcompass.studies.radio_setup import LYING_HEIGHT_M
from rfcompass.types.scene import Scene
from rfcompass.viz.error_figures import Panel, draw_shares

LONGER = "way longer than the straight line by [%]"
LARGEST = 60.0
# Means and largest of ten [%] [Wang2013], Fig. 10 and 11.
_PAPER = {
    "in sight": {"paper, mean": 6.0, "paper, largest": 16.0},
    "hidden": {"paper, mean": 5.0, "paper, largest": 12.0},
}
_SAMPLES = ("way_x_m", "way_y_m")


def draw_path_ratio(table: pa.Table) -> dict[str, Figure]:
    """Draw the shares of runs by ratio, and the ways of the first seed in both scenes."""
    ways = list(dict.fromkeys(table.column("way").to_pylist()))
    panels = [
        Panel(
            sight,
            {
                way: 100.0 * (ratios - 1.0)
                for way in ways
                if len(ratios := picked(table, "ratio", sight=sight, way=way))
            },
            marks,
        )
        for sight, marks in _PAPER.items()
    ]
    seed = min(table.column("seed").to_pylist())
    return {
        "Runs that reached the part, by how much longer the way was. Dotted: the paper's.": draw_shares(
            panels, LONGER, LARGEST
        ),
        f"The ways of seed {seed}, from the dots; grey: what reaches the floor.": draw_ways(table, seed),
    }


def draw_ways(table: pa.Table, seed: int) -> Figure:
    """Draw the true ways of one seed, seen from above, a panel for each scene.

    Args:
        table: Rows of the study.
        seed: Whose.
    """
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    for place, sight in enumerate(_PAPER):
        axes = figure.add_subplot(1, len(_PAPER), place + 1)
        rows = [row for row in table.to_pylist() if (row["sight"], row["seed"]) == (sight, seed)]
        for row in rows:
            x_m, y_m = (np.array(row[name] or []) for name in _SAMPLES)
            axes.plot(x_m, y_m, ".-", lw=1.2, ms=4, label=f"{row['way']}: {row['ended']}")
            axes.plot(x_m[:1], y_m[:1], "ko", ms=5)
        if rows:
            _furnish(axes, sight, seed)
        axes.set_title(sight, loc="left", fontsize=10)
        axes.set_aspect("equal")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.legend(frameon=False, fontsize=8)
    return figure


def _furnish(axes: Axes, sight: str, seed: int) -> None:
    """Draw room, furniture and part of the `best` run of a seed, made anew from it."""
    from rfcompass.studies.fetching import SimulatedFetch  # noqa: PLC0415 - only where a picture is drawn
    from rfcompass.studies.path_ratio import path_task  # noqa: PLC0415 - which draws with this module

    job = SimulatedFetch(path_task({"sight": sight, "way": "best"}, seed))
    scene = job.scene
    if isinstance(scene, Scene) and scene.room is not None:
        for outline_m in outlines_m(scene.obstacles, LYING_HEIGHT_M, 1e-3):
            axes.add_patch(Polygon(outline_m, color="0.7"))
        axes.set_xlim(0.0, scene.room.size_m[0])
        axes.set_ylim(0.0, scene.room.size_m[1])
    axes.plot(*job.true_part_m, "r*", ms=11, label="part")
