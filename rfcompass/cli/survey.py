"""`rfcompass survey TRACE`: position of every tag in the antenna frame."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rfcompass.cli.output import JsonFlag, answering, messages, print_json, print_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rfcompass.localization import MeasureMore
    from rfcompass.types.fixes import TagFix
    from rfcompass.types.reads import Scan


class SurveyMethod(StrEnum):
    """Ways to locate a tag."""

    HYPERBOLIC = "hyperbolic"
    SAR = "sar"
    WRIST = "wrist"


def survey_command(
    trace: Annotated[Path, typer.Argument(help="Trace folder.")],
    method: Annotated[
        SurveyMethod, typer.Option(help="Phase fit; matched filter; the same for FuseBot's wrist, with advice.")
    ] = SurveyMethod.HYPERBOLIC,
    epc: Annotated[list[str] | None, typer.Option(help="Locate this tag only; may be repeated.")] = None,
    stop: Annotated[int | None, typer.Option(help="Which stop, if the trace has several.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Locate every tag of a recorded sweep."""
    from rfcompass.localization import WRIST_SAR, survey
    from rfcompass.recordings import open_trace

    with answering(as_json):
        opened = open_trace(trace)
        scan = opened.scan(stop)
        for asked in epc or ():
            scan.trace(asked)  # an EPC that was asked for and never heard is no answer
        fixes = survey(scan, WRIST_SAR if method is SurveyMethod.WRIST else method.value, epcs=epc)
        silent = opened.quality.silent_epcs
        if silent and not epc:
            messages().print(f"never heard: {', '.join(silent)}", markup=False)
        advice = _advice(scan, fixes) if method is SurveyMethod.WRIST else {}
        if as_json:
            tags = [
                {"epc": fix.epc, "point_m": fix.point_m, "confident": fix.confident, "box_m": fix.box_m}
                for fix in fixes
            ]
            print_json({"frame": scan.frame, "method": method.value, "tags": tags, "advice": _advice_json(advice)})
            return
        rows = (
            (fix.epc, *(f"{value:.3f}" for value in fix.point_m), "yes" if fix.confident else "no",
             " x ".join(f"{100 * side:.0f}" for side in fix.box_m))
            for fix in fixes
        )  # fmt: skip
        columns = ("EPC", "x [m]", "y [m]", "z [m]", "confident", "box [cm]")
        print_table(f"{len(fixes)} tags in frame {scan.frame}, {method.value}", columns, rows)
        for unsure, more in advice.items():
            best = more.options[0]
            box = " x ".join(f"{100 * side:.0f}" for side in best.box_m)
            enough = "enough" if best.enough else "not enough"
            typer.echo(f"{unsure}: measure more, best {best.aid}: box {box} cm, {enough}")


def _advice(scan: "Scan", fixes: "Sequence[TagFix]") -> "dict[str, MeasureMore]":
    """What to measure for the tags that are not confident."""
    from rfcompass.localization import WRIST_SAR, default_volume, measure_more

    volume = default_volume(scan)
    found = {fix.epc: measure_more(scan.trace(fix.epc), fix, volume, WRIST_SAR) for fix in fixes}
    return {epc: more for epc, more in found.items() if more is not None}


def _advice_json(advice: "dict[str, MeasureMore]") -> dict[str, Any]:
    return {
        epc: [{"aid": one.aid, "box_m": one.box_m, "enough": one.enough} for one in more.options]
        for epc, more in advice.items()
    }
