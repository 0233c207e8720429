"""`rfcompass proximity TRACE`: m for every pair of tags."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from rfcompass.cli.output import JsonFlag, answering, print_json, print_table
from rfcompass.errors import TooFewPairs

if TYPE_CHECKING:
    from rfcompass.types.proximity import ProximityMatrix

# A square table of so many tags fits 80 columns whatever m is; more are listed pair by pair.
_WIDEST_TABLE = 4


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
        _check_compared(matrix)
        if as_json:
            print_json({"kind": matrix.kind, "epcs": matrix.anchor_epcs, "m": matrix.anchor_m})
        elif len(matrix.anchor_epcs) <= _WIDEST_TABLE:
            _print_square(matrix)
        else:
            _print_pairs(matrix)


def _check_compared(matrix: "ProximityMatrix") -> None:
    if np.isnan(matrix.anchor_m).all():
        tags = len(matrix.anchor_epcs)
        lack = f"{matrix.kind} can compare no two of them" if tags > 1 else "there is nothing to compare it with"
        message = f"{tags} tag{'s' if tags > 1 else ''} with reads: {lack}"
        raise TooFewPairs(message, pairs=0, needed=1, tags=tags, meter=matrix.kind)


def _print_square(matrix: "ProximityMatrix") -> None:
    rows = (
        (name, *("" if np.isnan(m) else f"{m:.3g}" for m in row))
        for name, row in zip(matrix.anchor_epcs, matrix.anchor_m, strict=True)
    )
    columns = ("EPC", *(f"…{name[-4:]}" for name in matrix.anchor_epcs))
    print_table(f"proximity m, {matrix.kind}", columns, rows)


def _print_pairs(matrix: "ProximityMatrix") -> None:
    """One line for each pair that can be compared, the nearest first."""
    first, second = np.triu_indices(len(matrix.anchor_epcs), 1)
    m = matrix.anchor_m[first, second]
    nearest_first = np.argsort(m, kind="stable")[: int(np.isfinite(m).sum())]
    rows = ((matrix.anchor_epcs[first[k]], matrix.anchor_epcs[second[k]], f"{m[k]:.3g}") for k in nearest_first)
    print_table(f"proximity m, {matrix.kind}, {m.size} pairs", ("EPC", "other EPC", "m"), rows)
