"""`rfcompass proximity TRACE`: m for every pair of tags."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from rfcompass.cli.output import JsonFlag, answering, print_json, print_table


def proximity(
    trace: Annotated[Path, typer.Argument(help="Trace folder.")],
    kind: Annotated[str, typer.Option(help="Meter, for example phase_l1 or pinit_dtw; auto picks the best.")] = "auto",
    epc: Annotated[list[str] | None, typer.Option(help="Compare these tags only; may be repeated.")] = None,
    stop: Annotated[int | None, typer.Option(help="Which stop, if the trace has several.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Compare every tag of a recorded sweep with every other one; small m means near."""
    from rfcompass.recordings import open_trace
    from rfcompass.rf import meter

    with answering(as_json):
        scan = open_trace(trace).scan(stop)
        for asked in epc or ():
            scan.trace(asked)
        matrix = meter(kind).measure(scan, anchors=tuple(epc) if epc else None)
        if as_json:
            print_json({"kind": matrix.kind, "epcs": matrix.anchor_epcs, "m": matrix.anchor_m})
            return
        rows = (
            (name, *("" if np.isnan(m) else f"{m:.3g}" for m in row))
            for name, row in zip(matrix.anchor_epcs, matrix.anchor_m, strict=True)
        )
        columns = ("EPC", *(f"…{name[-4:]}" for name in matrix.anchor_epcs))
        print_table(f"proximity m, {matrix.kind}", columns, rows)
