"""Fetch all legs of a table: from a product's name to four parts in a row.

    python examples/18_four_legs.py

You will see the planned actions, what the task planner hears from each localisation, the tuple (φ, D, θ), and how far
from its goal each leg was put down; and get `four_legs.png`: where the legs lay, where they went, and the robot's way.
The distances between tags are simulated with 2 % noise, without radio. Takes 20 s.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from planners.pick_up import GraspTrial
from planners.task import RelativeLocation, parts_of_task, plan_task, row_at_the_start
from rfcompass import PartDatabase, YouBot
from rfcompass.errors import NoAnswer
from rfcompass.geometry import Pose2
from rfcompass.localization import ConsistencyLocalizer
from rfcompass.studies.fetching import FetchTask, JudgedStep
from rfcompass.studies.task_fetching import SimulatedTask


def main(fast: bool = False, out: Path = Path("runs/18_four_legs")) -> dict[str, float]:
    """Fetch and deliver; return how far from its goal each delivered leg truly lies [m]."""
    out.mkdir(parents=True, exist_ok=True)
    legs = parts_of_task(PartDatabase(":memory:"), (), "LACK")[: 2 if fast else 4]
    planned = plan_task(legs, 4, row_at_the_start(legs))
    for action in (action for one in planned for action in one.actions):
        print(f"planned   {action}")
    task = FetchTask(robot=YouBot(), part=legs[0], tags=4, localizer=ConsistencyLocalizer(), seed=3, sigma=0.02)
    room = SimulatedTask(task, legs[1:])

    before, way_m, missed_m = room.true_poses(), [np.zeros(2)], dict[str, float]()
    for one in planned:
        job, name = room.send_for(one.part), one.part.part_id
        try:
            for step in job.steps():
                way_m.append(said(name, step))
            trials = []
            for event in job.pick_up(step):
                if isinstance(event, GraspTrial):
                    trials.append(event)
                else:
                    way_m.append(said(name, event))
            end = room.deliver(one.part, trials[-1].plan, one.goal)
        except NoAnswer as failure:
            print(f"{name}: {failure.message}")
            continue
        way_m.append(end.put.T_odom_base.translation_m)
        missed_m[name] = end.centre_error_m
        print(f"{name}: put down, {100 * end.centre_error_m:.1f} cm from its goal")

    goals = {one.part.part_id: one.goal for one in planned}
    draw(before, room.true_poses(), goals, np.array(way_m)).savefig(out / "four_legs.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'four_legs.png'}")
    return missed_m


def said(name: str, judged: JudgedStep) -> np.ndarray:
    """Print what a planner hears; return where the base believes that it stands [m], shape (2,)."""
    found, base = RelativeLocation.of(judged.step.estimate), judged.step.configuration.base
    theta = "not known" if found.theta_rad is None else f"{np.rad2deg(found.theta_rad):6.1f} degrees"
    phi = np.rad2deg(found.phi_rad)
    print(f"{name}: {judged.step.phase:<9} φ = {phi:6.1f} degrees, D = {found.D_m:.2f} m, θ = {theta}")
    return base.translation_m


def draw(before: dict[str, Pose2], after: dict[str, Pose2], goals: dict[str, Pose2], way_m: np.ndarray) -> Figure:
    """Draw each leg where it lay and where it ended, and the base's way, as it believes, in the odometry frame."""
    figure = Figure(figsize=(8, 6), layout="constrained")
    axes = figure.add_subplot()
    axes.plot(*way_m.T, "o-", color="#3b6ea5", lw=0.8, ms=3, label="base, as believed")
    for poses, colour, label in ((before, "#999999", "lay"), (goals, "#d1495b", "goal"), (after, "#2a7f3f", "ends")):
        for index, pose in enumerate(poses.values()):
            ends_m = pose.apply(np.array([[-0.2, 0.0], [0.2, 0.0]]))
            wide = 2 if label == "goal" else 5
            axes.plot(*ends_m.T, color=colour, lw=wide, label=label if index == 0 else None, solid_capstyle="butt")
    axes.set_aspect("equal")
    axes.set_xlabel("x in odom [m]")
    axes.set_ylabel("y in odom [m]")
    axes.set_title(f"{len(goals)} legs, fetched one after the other", loc="left")
    axes.legend(frameon=False)
    return figure


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
