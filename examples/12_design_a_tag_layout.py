"""Design a tag layout: where should a robot carry its tags to locate a part as well as it can?

The robot's mounts say where tags may go. Places are chosen one by one and then exchanged, until no exchange lowers the
expected error over the part's poses about the hand. Two tags stay beside the jaws: the stop rule looks at them.

You will see the expected error of the default layout and of the designed one over the workspace, in `layout.png`, and
get `layout.json`, which `YouBot("…/layout.json")` wears. Takes 15 s.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from planners.tag_layout import design_for, error_map, hand_stops
from rfcompass import PartDatabase, YouBot
from rfcompass.robots import Robot, load_mounts, write_layout
from rfcompass.viz.layout_figures import draw_expected_error


def main(fast: bool = False, out: Path = Path("runs/12_layout")) -> float:
    """Design nine tags for a leg with two; return the expected error [m]."""
    robot, leg = YouBot(), PartDatabase(":memory:").part("table_leg_3")
    points_m = leg.layout(2).points_m + np.array([0.0, 0.0, leg.resting_height_m])
    design = design_for(robot, load_mounts("youbot"), points_m, 9, np.random.default_rng(0), poses=20 if fast else 100)
    print(f"default layout: {100 * design.present_error_m:.1f} cm expected, designed: {100 * design.error_m:.1f} cm")
    for epc, link, point_m in zip(design.layout.epcs, design.layout.frames, design.layout.points_m, strict=True):
        print(f"  {epc[-4:]} on {link:<18} at {', '.join(f'{100 * c:6.1f}' for c in point_m)} cm")
    out.mkdir(parents=True, exist_ok=True)
    write_layout(design.layout, out / "layout.json", "Nine tags for a lying table leg with two tags.")
    both = {"default": robot, "designed": Robot(replace(robot.description, layout=design.layout))}
    maps = {name: error_map(one, points_m, pitch_m=0.08 if fast else 0.04) for name, one in both.items()}
    first = hand_stops(robot)[0]
    anchors_m = {name: one.tag_positions(first).points_m for name, one in both.items()}
    errors_m = {name: one.errors_m for name, one in maps.items()}
    picture = draw_expected_error(errors_m, maps["default"].x_m, maps["default"].y_m, anchors_m)
    picture.savefig(out / "layout.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'layout.png'}; layout: {out / 'layout.json'}")
    return design.error_m


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
