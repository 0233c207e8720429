"""`rfcompass view PATH`: a trace or a run as one HTML page."""

import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rfcompass.cli.output import JsonFlag, answering, messages, print_json

if TYPE_CHECKING:
    from rfcompass.recordings import Trace
    from rfcompass.viz.page import PagePart


def view(
    path: Annotated[Path, typer.Argument(help="Trace or run folder.")],
    out: Annotated[Path | None, typer.Option(help="HTML file to write; PATH.html for a trace.")] = None,
    show: Annotated[bool, typer.Option(help="Open the page in a browser.")] = False,
    as_json: JsonFlag = False,
) -> None:
    """Draw a trace (antenna path, tags, SAR images, phases) on one page, or lead to the page of a run."""
    with answering(as_json):
        target = _run_page(path, out) or _trace_page(path, out)
        messages().print(f"page: {target}", markup=False)
        if as_json:
            print_json({"page": str(target)})
        if show:
            webbrowser.open(target.resolve().as_uri())


def _run_page(path: Path, out: Path | None) -> Path | None:
    """Page of a run folder, copied if asked for elsewhere; None if the path is no run."""
    from rfcompass.errors import TraceError
    from rfcompass.files import write_text_atomic
    from rfcompass.recordings import VIEW_FILE, is_run

    if not is_run(path):
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
