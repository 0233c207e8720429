"""`rfcompass import KIND PATH`: foreign logs become traces."""

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rfcompass.cli.antennas import (
    CarrierOption,
    PhaseModulus,
    PosesOption,
    PositionOption,
    carriage_of,
    table_hz,
)
from rfcompass.cli.output import JsonFlag, answering, messages, print_json

if TYPE_CHECKING:
    from rfcompass.recordings import Trace, TraceMeta


def import_recording(
    kind: Annotated[str, typer.Argument(help="Layout of the recording: adarf, itemtest, llrpkit, sllurp or spool.")],
    path: Annotated[Path, typer.Argument(help="Folder or file to import.")],
    out: Annotated[Path | None, typer.Option(help="Trace folder to write; by default named after PATH.")] = None,
    sweep: Annotated[str | None, typer.Option(help="Which sweep, if PATH holds several.")] = None,
    frequencies: Annotated[
        str | None,
        typer.Option(help="MHz of channel 1, 2, … in the reader's own table: a list, or a text file with one."),
    ] = None,
    antenna_position: PositionOption = None,
    poses: PosesOption = None,
    carrier: CarrierOption = None,
    frame: Annotated[str | None, typer.Option(help="Name of the frame of the antenna positions.")] = None,
    dimensions: Annotated[int | None, typer.Option(help="2 if tags and antennas share one plane, else 3.")] = None,
    phase_sign: Annotated[int | None, typer.Option(help="+1 if the phase grows with distance, else -1.")] = None,
    phase_modulus: Annotated[PhaseModulus | None, typer.Option(help="pi for readers that mix up half turns.")] = None,
    overwrite: Annotated[bool, typer.Option(help="Replace a trace that is already there.")] = False,
    as_json: JsonFlag = False,
) -> None:
    """Convert a recording of another program into a trace."""
    from rfcompass.recordings import import_log, write_trace

    with answering(as_json):
        carriage = carriage_of(antenna_position, poses, carrier)
        trace = import_log(
            kind,
            path,
            sweep=sweep,
            frequencies_hz=table_hz(frequencies),
            meta=_meta(
                frame=frame,
                dimensions=dimensions,
                phase_sign=phase_sign,
                phase_modulus=phase_modulus and phase_modulus.value,
            ),
            carriage=carriage and carriage(),
        )
        target = out or Path(f"{path.resolve().name.split('.')[0]}_trace")
        write_trace(trace, target, overwrite=overwrite)
        told = _told(trace)
        messages().print(f"{target}: {trace.quality.reads} reads of {len(trace.epcs)} tags", markup=False)
        for reason, count in told.get("dropped", {}).items():
            messages().print(f"dropped: {reason} {count}")
        if carriage is None and told:
            messages().print("where the antennas were is not known: they are put at the origin")
        if kind == "spool":
            messages().print(f"{path} is kept; once the trace is as you want it, delete it", markup=False)
        if as_json:
            print_json({"trace": str(target), "reads": trace.quality.reads, "epcs": trace.epcs, **told})


def _meta(**options: object) -> "TraceMeta | None":
    """Conventions that were given, over those of a usual reader; None if none was."""
    from rfcompass.recordings.foreign_log import READER_META

    given: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    return replace(READER_META, **given) if given else None


def _told(trace: "Trace") -> dict[str, Any]:
    """What the importer counted, if it did."""
    unknown = json.loads(trace.meta.unknown_json)
    return unknown.get("import") or unknown.get("recording") or {}
