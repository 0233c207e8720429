"""`rfcompass survey TRACE`: position of every tag in the antenna frame."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from rfcompass.cli.output import JsonFlag, answering, messages, print_json, print_table


class SurveyMethod(StrEnum):
    """Ways to locate a tag."""

    HYPERBOLIC = "hyperbolic"
    SAR = "sar"


def survey_command(
    trace: Annotated[Path, typer.Argument(help="Trace folder.")],
    method: Annotated[SurveyMethod, typer.Option(help="Phase fit, or matched filter.")] = SurveyMethod.HYPERBOLIC,
    epc: Annotated[list[str] | None, typer.Option(help="Locate this tag only; may be repeated.")] = None,
    stop: Annotated[int | None, typer.Option(help="Which stop, if the trace has several.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Locate every tag of a recorded sweep."""
    from rfcompass.localization import survey
    from rfcompass.recordings import open_trace

    with answering(as_json):
        opened = open_trace(trace)
        scan = opened.scan(stop)
        for asked in epc or ():
            scan.trace(asked)  # an EPC that was asked for and never heard is no answer
        fixes = survey(scan, method.value, epcs=epc)
        silent = opened.quality.silent_epcs
        if silent and not epc:
            messages().print(f"never heard: {', '.join(silent)}", markup=False)
        if as_json:
            tags = [
                {"epc": fix.epc, "point_m": fix.point_m, "confident": fix.confident, "box_m": fix.box_m}
                for fix in fixes
            ]
            print_json({"frame": scan.frame, "method": method.value, "tags": tags})
            return
        rows = (
            (fix.epc, *(f"{value:.3f}" for value in fix.point_m), "yes" if fix.confident else "no",
             " x ".join(f"{100 * side:.0f}" for side in fix.box_m))
            for fix in fixes
        )  # fmt: skip
        columns = ("EPC", "x [m]", "y [m]", "z [m]", "confident", "box [cm]")
        print_table(f"{len(fixes)} tags in frame {scan.frame}, {method.value}", columns, rows)
