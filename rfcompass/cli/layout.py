"""`rfcompass layout`: where should a robot carry its tags?"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rfcompass.cli.output import JsonFlag, answering, messages, print_json

if TYPE_CHECKING:
    from planners.tag_layout import TagDesign
    from rfcompass.arrays import FloatArray
    from rfcompass.robots import Robot


def layout_command(
    tags: Annotated[int, typer.Option(min=2, help="Number of tags on the robot.")] = 9,
    part: Annotated[str, typer.Option(help="Part to look for, by its name in the part database.")] = "table_leg_3",
    part_tags: Annotated[int, typer.Option(min=1, help="Number of tags on the part.")] = 2,
    robot: Annotated[str, typer.Option(help="Robot that has a posture 'scan', by name or file.")] = "youbot",
    mounts: Annotated[str | None, typer.Option(help="Where tags may go, a JSON file; by default the robot's.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the poses that are expected.")] = 0,
    out: Annotated[Path, typer.Option(help="Layout file to write; a picture goes beside it.")] = Path("layout.json"),
    overwrite: Annotated[bool, typer.Option(help="Replace a file that is already there.")] = False,
    database: Annotated[Path | None, typer.Option(help="Part database; by default the user's own.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Choose places for the robot's tags with the least expected error; write a layout file and a picture."""
    import numpy as np

    from planners.tag_layout import design_for
    from rfcompass.errors import InputError
    from rfcompass.localization import lying_tags
    from rfcompass.recordings import PartDatabase
    from rfcompass.robots import load_mounts, load_robot, write_layout

    with answering(as_json):
        if out.exists() and not overwrite:
            raise InputError(f"{out} is there already; --overwrite replaces it", file=str(out))
        with PartDatabase(database) as parts:
            wanted = parts.part(part)
        carried = wanted.layout(part_tags)
        points_m = carried.points_m + np.array([0.0, 0.0, wanted.resting_height_m])
        machine = load_robot(robot)
        design = design_for(machine, load_mounts(mounts or robot), points_m, tags, np.random.default_rng(seed))
        for epc in lying_tags(carried):
            messages().print(f"warning: part tag {epc} lies flat: an upright antenna hardly hears it", markup=False)
        write_layout(design.layout, out, f"Designed for {robot} and {part} with {part_tags} tags on it.")
        picture = _draw(machine, design, points_m, out.with_suffix(".png"))
        summary = (
            f"expected error {100 * design.error_m:.1f} cm; the present layout: {100 * design.present_error_m:.1f}"
        )
        messages().print(f"{out}: {tags} tags, {summary}; {picture}", markup=False)
        if as_json:
            print_json({"layout": str(out), "picture": str(picture), **_answer(design)})


def _answer(design: "TagDesign") -> dict[str, Any]:
    tags = [
        {"epc": epc, "link": link, "point_m": point_m, "role": role}
        for epc, link, point_m, role in zip(
            design.layout.epcs, design.layout.frames, design.layout.points_m.tolist(), design.layout.roles, strict=True
        )
    ]
    return {"tags": tags, "expected_error_m": design.error_m, "present_error_m": design.present_error_m}


def _draw(robot: "Robot", design: "TagDesign", points_m: "FloatArray", file: Path) -> Path:
    """Draw the expected error of the present layout and of the designed one."""
    from dataclasses import replace

    from planners.tag_layout import error_map, hand_stops
    from rfcompass.robots import Robot as AnyRobot
    from rfcompass.viz.layout_figures import draw_expected_error

    both = {"present": robot, "designed": AnyRobot(replace(robot.description, layout=design.layout))}
    maps = {name: error_map(one, points_m) for name, one in both.items()}
    first = hand_stops(robot)[0]
    anchors_m = {name: one.tag_positions(first).points_m for name, one in both.items()}
    x_m, y_m = maps["present"].x_m, maps["present"].y_m
    figure = draw_expected_error({name: one.errors_m for name, one in maps.items()}, x_m, y_m, anchors_m)
    figure.savefig(file, dpi=130)
    return file
