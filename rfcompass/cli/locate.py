"""`rfcompass locate TRACE`: the part's pose from a recorded scan with robot tags."""

from pathlib import Path
from typing import Annotated

import typer

from rfcompass.cli.comparator import comparator_json
from rfcompass.cli.estimates import Estimator, estimate_json, localizer, one_line
from rfcompass.cli.output import JsonFlag, answering, print_json


def locate(
    trace: Annotated[Path, typer.Argument(help="Trace folder with stops.csv.")],
    part: Annotated[str, typer.Option(help="Part to find, by its name in the part database.")],
    estimator: Annotated[Estimator, typer.Option(help="How to find it.")] = Estimator.POSTERIOR,
    proximity: Annotated[str, typer.Option(help="Meter for stops without ready-made proximities.")] = "auto",
    last: Annotated[int | None, typer.Option(min=1, help="Use the newest stops only; all by default.")] = None,
    robot: Annotated[str | None, typer.Option(help="Robot name or file; by default what the trace says.")] = None,
    database: Annotated[Path | None, typer.Option(help="Part database; by default the user's own.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Find a part from a recorded trace; the answer is in the base frame of the last stop."""
    from rfcompass.errors import TraceError
    from rfcompass.localization import measure_proximities
    from rfcompass.recordings import PartDatabase, open_trace
    from rfcompass.rf import meter
    from rfcompass.robots import load_robot

    with answering(as_json):
        opened = open_trace(trace)
        name = robot or opened.meta.robot
        if opened.stops is None:
            raise TraceError(f"{trace}: has no stops.csv: no robot carried tags; try survey", file="stops.csv")
        if name is None:
            raise TraceError(f"{trace}: does not say which robot carried the tags; use --robot", file="meta.json")
        with PartDatabase(database) as parts:
            wanted = parts.part(part)
        observations = opened.observations(load_robot(name, opened.meta.tag_layout), wanted)[-(last or 0) :]
        estimate = localizer(estimator, proximity).estimate(observations)
        if as_json:
            matrix = measure_proximities(observations[-1], meter(proximity))
            comparator = comparator_json(matrix, observations[-1].anchors)
            print_json({**estimate_json(estimate, matrix.kind), "comparator": comparator})
        else:
            where = f"base frame of stop {observations[-1].stop_id}"
            typer.echo(f"{part}: {one_line(estimate)}  ({where}; {estimate.method} of {estimate.stops} stops)")
