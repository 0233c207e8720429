"""`rfcompass import KIND PATH`: foreign logs become traces."""

from pathlib import Path
from typing import Annotated

import typer

from rfcompass.cli.output import JsonFlag, answering, messages, print_json


def import_recording(
    kind: Annotated[str, typer.Argument(help="Layout of the recording: adarf.")],
    path: Annotated[Path, typer.Argument(help="Folder or file to import.")],
    out: Annotated[Path | None, typer.Option(help="Trace folder to write; by default named after PATH.")] = None,
    sweep: Annotated[str | None, typer.Option(help="Which sweep, if PATH holds several.")] = None,
    overwrite: Annotated[bool, typer.Option(help="Replace a trace that is already there.")] = False,
    as_json: JsonFlag = False,
) -> None:
    """Convert a recording of another program into a trace."""
    from rfcompass.recordings import importer, write_trace

    with answering(as_json):
        trace = importer(kind)(path, sweep=sweep)
        target = out or Path(f"{path.resolve().name.split('.')[0]}_trace")
        write_trace(trace, target, overwrite=overwrite)
        quality = trace.quality
        messages().print(f"{target}: {quality.reads} reads of {len(trace.epcs)} tags", markup=False)
        if as_json:
            print_json({"trace": str(target), "reads": quality.reads, "epcs": trace.epcs})
