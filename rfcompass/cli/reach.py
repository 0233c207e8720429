"""`rfcompass reach`: which grasps from above can an arm do, and from where?"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rfcompass.cli.output import JsonFlag, answering, messages, print_json

if TYPE_CHECKING:
    from planners.task_map import TaskMap
    from rfcompass.robots import Robot
    from rfcompass.types import Configuration, SearchVolume


def reach_command(
    robot: Annotated[str, typer.Option(help="Robot with a tool, by name or file.")] = "youbot",
    lowest: Annotated[float, typer.Option(help="Lowest height of the tool over the floor [m].")] = 0.025,
    highest: Annotated[float, typer.Option(help="Highest height of the tool over the floor [m].")] = 0.065,
    spacing: Annotated[float, typer.Option(min=0.002, help="Edge of a voxel [m].")] = 0.02,
    headings: Annotated[int, typer.Option(min=1, help="Headings of the jaws, spread over half a turn.")] = 12,
    solid_tags: Annotated[bool, typer.Option(help="Take the robot's tags for solid bodies.")] = False,
    seed: Annotated[
        int, typer.Option(min=0, help="Of the postures that an arm without a closed form starts from.")
    ] = 0,
    out: Annotated[Path, typer.Option(help="Map to write, npz; a page to look at goes beside it.")] = Path("reach.npz"),
    overwrite: Annotated[bool, typer.Option(help="Replace a file that is already there.")] = False,
    as_json: JsonFlag = False,
) -> None:
    """Map the grasps from straight above that an arm can do; write the map and a page."""
    import numpy as np

    from planners import IkRules, InverseKinematics, MapMaker, top_down
    from rfcompass.errors import InputError
    from rfcompass.robots import CollisionModel, load_robot
    from rfcompass.robots.touching_links import without_always_touching

    with answering(as_json):
        if out.exists() and not overwrite:
            raise InputError(f"{out} is there already; --overwrite replaces it", file=str(out))
        if not highest > lowest:
            raise InputError(f"--highest {highest} is not above --lowest {lowest}", lowest=lowest, highest=highest)
        machine = load_robot(robot)
        start = _start(machine)
        ik = InverseKinematics(
            machine,
            model=without_always_touching(CollisionModel(machine, with_tags=solid_tags)),
            rules=IkRules(certify=False, explain=False),
        )
        rng = np.random.default_rng(seed)
        volume = _volume(machine, (lowest, highest), spacing)
        messages().print("asking the arm; this takes some seconds, for an arm without a closed form minutes")
        made = MapMaker(ik=ik, spacing_m=spacing, spread=True).make(volume, top_down(headings), start, rng)
        made.save(out)
        page = _draw(machine, start, made, out.with_suffix(".html"))
        share = float(made.reached.mean())
        messages().print(f"{out}: {share:.1%} of {made.reached.size} grasps can be done; {page}", markup=False)
        if as_json:
            counts = {"voxels": made.reached.shape[:3], "headings": headings, "reached": int(made.reached.sum())}
            print_json({"map": str(out), "page": str(page), "share": share, "spacing_m": spacing, **counts})


def _start(robot: "Robot") -> "Configuration":
    """Posture "scan"; without one the middle of every joint, as fingers that are closed at rest touch each other."""
    import numpy as np

    if "scan" in robot.description.postures:
        return robot.posture("scan")
    middle = (robot.limits.lower + robot.limits.upper) / 2
    return robot.configuration(np.where(np.isfinite(middle), middle, 0.0))


def _volume(robot: "Robot", heights: tuple[float, float], spacing: float) -> "SearchVolume":
    """What the tool gets to at these heights: the box around random postures, on a grid through the base's origin."""
    import numpy as np

    from rfcompass.robots.touching_links import random_joints
    from rfcompass.types import SearchVolume

    draws = random_joints(robot, np.random.default_rng(0), 2000)
    places = [robot.tool_pose(robot.configuration(draw)).translation[:2] for draw in draws]
    low, high = (spacing * np.round(edge / spacing) for edge in (np.min(places, axis=0), np.max(places, axis=0)))
    return SearchVolume(np.array([*low, heights[0]]), np.array([*high, heights[1]]))


def _draw(robot: "Robot", start: "Configuration", made: "TaskMap", page: Path) -> Path:
    import numpy as np

    from rfcompass.geometry import Pose2
    from rfcompass.viz.meshcat_page import write_scene
    from rfcompass.viz.robot_scene import RobotScene

    scene = RobotScene()
    scene.draw_robot([robot.visual_shapes(start)])
    scene.draw_reach(made.reach_map, Pose2())
    scene.look_at(np.array([0.2, 0.0, 0.1]), np.array([0.9, -1.2, 1.0]))
    write_scene(page, scene.window, f"What the arm of {robot.name} can grasp from above")
    return page
