"""`rfcompass partition FILE`: solve a partition problem given as JSON."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from rfcompass.cli.output import JsonFlag, answering, print_json


class Solver(StrEnum):
    """Ways to solve comparisons without reads."""

    PARTITION = "partition"
    CONSISTENCY = "consistency"
    POSTERIOR = "posterior"


def partition(
    file: Annotated[Path, typer.Argument(help="Problem as JSON, in one of the two shapes above.")],
    method: Annotated[
        Solver, typer.Option(help="Convex program, most comparisons met, or the posterior.")
    ] = Solver.PARTITION,
    as_json: JsonFlag = False,
) -> None:
    """Find a part from comparisons alone.

    For one stop, FILE holds

    \b
      {"anchors_m": [[x, y, z], ...],        robot tags, base frame
       "part_points_m": [[x, y, z], ...],    x, y in the part frame, z the height over the base frame
       "comparisons": [{"target": k, "nearer": i, "farther": j, "margin": 0.1}, ...],
       "bounds_m": [[xmin, xmax], [ymin, ymax]]}

    and for several

    \b
      {"part_points_m": ..., "bounds_m": ...,
       "stops": [{"pose": [x, y, theta], "anchors_m": ..., "comparisons": ...}, ...]}

    with each pose that stop's base frame in the last stop's, so that the last pose is [0, 0, 0]. Metres and radians;
    indices count from 0; "margin" and "bounds_m" may be left out.
    """  # noqa: D301 - \b is for the help page
    from rfcompass.errors import InputError
    from rfcompass.files import read_json
    from rfcompass.localization import answer_partition

    with answering(as_json):
        answer = answer_partition(read_json(file, InputError), method.value)
        if as_json:
            print_json(answer)
            return
        for key, value in answer.items():
            if key != "region":
                typer.echo(f"{key}: {value}")
