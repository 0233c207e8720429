"""How far ahead a vertical hand can work, for three hands of the youBot: the table of docs/grasp.md.

The study hand is the one of an earlier reach study (urdf/variants); ours ends 9 mm lower, and with its tags as solid
bodies it is wider. Mechanical joint limits, arm straight ahead, floor and robot as the only obstacles, steps of 1 mm.

    python -m benchmarks.reach_table
"""

import numpy as np

from planners import IkRules, InverseKinematics
from rfcompass.robots import CollisionModel, Robot, YouBot, load_robot
from rfcompass.robots.layouts import data_folder
from rfcompass.types import Body, Box, GraspTask, Solution, World

DOWN = np.array([0.0, 0.0, -1.0])
JAWS = {"sideways": [0, 1.0, 0], "fore-aft": [1.0, 0, 0]}
RULES = IkRules(certify=False, explain=False, soft_limits=False, method="closed_form")


def reached(robot: Robot, world: World, with_tags: bool, tasks: list[GraspTask]) -> list[bool]:
    """Which tasks a robot can do."""
    ik = InverseKinematics(robot, model=CollisionModel(robot, world, with_tags=with_tags), rules=RULES)
    return [isinstance(ik.solve(task, robot.posture("scan")), Solution) for task in tasks]


def span(can: list[bool], x: np.ndarray) -> str:
    """First and last place that can be reached."""
    places = x[np.array(can)]
    return f"{places.min():.3f}..{places.max():.3f}" if places.size else "none"


def leg_across(d: float) -> World:
    """A table leg across the base, its centre `d` ahead."""
    T = np.eye(4)
    T[:3, 3] = d, 0.0, 0.025
    return World((Body("leg", Box(np.array([0.05, 0.4, 0.05])), T),))


def main() -> None:
    """Print the table as Markdown."""
    x = np.arange(0.25, 0.55, 0.001)
    study = load_robot(data_folder() / "variants" / "youbot_study_hand.json")
    hands = {"study hand": (study, False), "our hand": (YouBot(), False), "our hand, tags solid": (YouBot(), True)}
    print("| hand | jaws | tip 0.005 | 0.025 | 0.050 | 0.150 |\n|---|---|---|---|---|---|")
    for name, (robot, tags) in hands.items():
        for jaws, closing in JAWS.items():
            heights = (0.005, 0.025, 0.050, 0.150)
            rows = [[GraspTask([d, 0, z], DOWN, closing) for d in x] for z in heights]
            cells = [span(reached(robot, World(), tags, tasks), x) for tasks in rows]
            print(f"| {name} | {jaws} | {' | '.join(cells)} |")
    print("\n| hand | leg across the base: its centre can be grasped at |\n|---|---|")
    d = np.arange(0.30, 0.55, 0.005)
    for name, (robot, tags) in hands.items():
        can = []
        for centre in d:
            tasks = [GraspTask([centre, 0, z], DOWN, JAWS["fore-aft"]) for z in (0.075, 0.025)]
            can.append(all(reached(robot, leg_across(centre), tags, tasks)))
        print(f"| {name} | {span(can, d)} |")


if __name__ == "__main__":
    main()
