"""Take the pictures of docs/own_robot.md, piles.md and search.md: python docs/take_pictures.py, from the project's folder.

Needs a Chromium.
"""

import runpy
import tempfile
from pathlib import Path

import numpy as np

from planners import GraspPlanner
from rfcompass import PartDatabase, PartEstimate, YouBot, view
from rfcompass.simulation.piles import make_pile
from rfcompass.studies.search_methods import search_method
from rfcompass.studies.searching import SearchRun, SearchTask, tagged_items_of
from rfcompass.types import Body, Box, World
from rfcompass.viz.screenshot import take_picture
from rfcompass.viz.search_report import draw_decision

END_S = 3600.0  # later than any motion: a page then stops at its end
IMAGES = Path(__file__).parent / "images"


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        runpy.run_path("examples/16_your_own_robot.py")["main"](fast=True, out=out)
        take_picture(out / "my_ur5e.html", IMAGES / "own_robot.png", (1000, 560), at_s=END_S)
        runpy.run_path("examples/20_a_pile.py")["main"](out=out)
        take_picture(out / "pile.html", IMAGES / "pile.png", (800, 500))
        draw_search(IMAGES / "search.png")
        page = view_youbot().save(out / "youbot.html")
        take_picture(page, IMAGES / "grasp_view.png", (1000, 560), at_s=END_S)


def view_youbot():
    """The youBot grasps a leg that is known to a centimetre and five degrees, beside a crate."""
    robot, leg = YouBot(), PartDatabase(":memory:").part("table_leg_3")
    mean, spread = np.array([0.42, 0.02, np.pi / 2]), np.diag([0.01**2, 0.008**2, np.deg2rad(5) ** 2])
    draws = np.random.default_rng(3).multivariate_normal(mean, spread, 1000)
    estimate = PartEstimate(
        leg.part_id, mean[:2], mean[2], "posterior", 3, leg.resting_height_m, covariance=spread, samples=draws
    )
    T_base_crate = np.eye(4)
    T_base_crate[:3, 3] = 0.6, 0.45, 0.1
    world = World((Body("crate", Box([0.2, 0.2, 0.2]), T_base_crate),))
    plan = GraspPlanner(robot).plan(leg, estimate, world)
    return view(robot, estimate, plan, part=leg, world=world)


def draw_search(path):
    """The first decision of a search in a small pile."""
    scene = make_pile("poured_1p10", 3, "hidden")
    tags = tagged_items_of(scene, "any", 0, 3)
    run = SearchRun.of(SearchTask(scene, tags, 3), search_method("ours", tags.target_size))
    draw_decision(next(iter(run.search.steps()))).savefig(path, dpi=110)


if __name__ == "__main__":
    main()
