"""`rfcompass view PATH`: a trace, a run, a search or a grasp plan as one HTML page."""

import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rfcompass.cli.output import JsonFlag, answering, messages, print_json

if TYPE_CHECKING:
    from rfcompass.recordings import Trace
    from rfcompass.viz.grasp_view import View
    from rfcompass.viz.page import PagePart

# Plans did not say whose they were; the command took this one.
_OF_OLD_PLANS = "youbot"


def view(
    path: Annotated[Path, typer.Argument(help="Trace, run or search folder, or the JSON file of a grasp plan.")],
    out: Annotated[Path | None, typer.Option(help="HTML file to write; PATH.html by default.")] = None,
    show: Annotated[bool, typer.Option(help="Open the page in a browser; a plan live, until Ctrl-C.")] = False,
    robot: Annotated[
        str | None, typer.Option(help="Of a plan: the robot that it moves, by name or file; by default what it says.")
    ] = None,
    estimate: Annotated[
        Path | None, typer.Option(help="Of a plan: the estimate that it was made for; draws its samples.")
    ] = None,
    database: Annotated[Path | None, typer.Option(help="Part database; by default the user's own.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Draw a trace (antenna path, tags, SAR images, phases) or a grasp plan; or lead to the page of a run or search."""
    with answering(as_json):
        plan = _plan_view(path, robot, estimate, database) if path.is_file() and path.suffix == ".json" else None
        if plan is not None:
            target = plan.save(out or path.with_suffix(".html"))
        else:
            target = _run_page(path, out) or _trace_page(path, out)
        messages().print(f"page: {target}", markup=False)
        if as_json:
            print_json({"page": str(target)})
        if show and plan is not None:
            plan.show().wait()
        elif show:
            webbrowser.open(target.resolve().as_uri())


def _plan_view(path: Path, robot: str | None, estimate: Path | None, database: Path | None) -> "View":
    """Draw a grasp plan."""
    from rfcompass.cli.grasp_json import world_around
    from rfcompass.recordings import PartDatabase, read_estimate, read_plan, read_plan_setting
    from rfcompass.robots import load_robot
    from rfcompass.viz.grasp_view import view as draw

    plan, setting = read_plan(path), read_plan_setting(path)
    with PartDatabase(database) as parts:
        part = parts.part(plan.part_id)
    seen = None if estimate is None else read_estimate(estimate, height_m=part.resting_height_m)
    around = world_around(setting) if setting.scene is not None else None
    return draw(load_robot(robot or setting.robot or _OF_OLD_PLANS), seen, plan, part=part, world=around)


def _run_page(path: Path, out: Path | None) -> Path | None:
    """Page of the folder of a run or search, copied if asked for elsewhere; None if the path is neither."""
    from rfcompass.errors import TraceError
    from rfcompass.files import write_text_atomic
    from rfcompass.recordings import VIEW_FILE, is_run
    from rfcompass.recordings.search_folder import is_search

    if not (is_run(path) or is_search(path)):
        return None
    page = path / VIEW_FILE
    if not page.is_file():
        raise TraceError(f"{path}: the run has no {VIEW_FILE}", file=VIEW_FILE, path=str(path))
    if out is None:
        return page
    write_text_atomic(out, page.read_text(encoding="utf-8"))
    return out


def _trace_page(path: Path, out: Path | None) -> Path:
    """Draw the page of a trace."""
    from rfcompass.recordings import open_trace
    from rfcompass.viz.page import write_page

    trace, name = open_trace(path), path.resolve().name
    target = out or path.resolve().with_name(f"{name}.html")
    write_page(target, f"Trace {name}", trace_parts(trace))
    return target


def trace_parts(trace: "Trace") -> list["PagePart"]:
    """Everything that the page of a trace shows."""
    from rfcompass.localization import default_volume, sar_image, survey
    from rfcompass.viz.page import PageFigure, PageTable
    from rfcompass.viz.sweep_figures import draw_image, draw_phase, draw_survey

    scan, quality = trace.scan(trace.stop_ids[-1] if len(trace.stop_ids) else None), trace.quality
    tags = PageTable(
        "Reads",
        ("EPC", "reads", "cells heard"),
        [(tag.epc, tag.reads, f"{100 * tag.coverage:.0f} %") for tag in quality.tags],
    )
    summary = (
        f"{quality.reads} reads, {len(quality.tags)} tags, {len(quality.strays)} strays. Source: {trace.meta.source}."
    )
    if not scan.traces:
        return [summary, tags]
    fixes = survey(scan)
    positions_m = next(iter(scan.traces.values())).antenna_positions_m
    parts: list[PagePart] = [
        summary, PageFigure("Antenna path and located tags.", draw_survey(positions_m, fixes, scan.frame)), tags
    ]  # fmt: skip
    volume = default_volume(scan)
    for fix in fixes:
        one = scan.trace(fix.epc)
        image = draw_image(sar_image(one, volume), positions_m, fix, scan.frame)
        parts += [PageFigure(f"SAR image of {fix.epc}.", image), PageFigure("Its phase.", draw_phase(one))]
    return parts
