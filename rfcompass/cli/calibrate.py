"""`rfcompass calibrate TRACE`: sign of the phase, and offsets of the carriers from a tag at a known place."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rfcompass.cli.output import JsonFlag, answering, messages, print_json

if TYPE_CHECKING:
    from rfcompass.recordings import Trace
    from rfcompass.rf.channel_offsets import ChannelOffsets


def calibrate(
    trace: Annotated[Path, typer.Argument(help="Trace folder.")],
    tag: Annotated[str | None, typer.Option(help="EPC of a tag whose place is known.")] = None,
    at: Annotated[str | None, typer.Option(help="Its place in the antenna frame: x,y,z in metres.")] = None,
    stop: Annotated[int | None, typer.Option(help="Which stop, if the trace has several.")] = None,
    out: Annotated[Path | None, typer.Option(help="Write the trace with what was found to this folder.")] = None,
    overwrite: Annotated[bool, typer.Option(help="Replace a trace that is already there.")] = False,
    as_json: JsonFlag = False,
) -> None:
    """Tell which sign the reader's phase has, and with a known tag what it adds to each carrier."""
    from dataclasses import replace

    from rfcompass.localization import detect_phase_sign
    from rfcompass.recordings import Trace, open_trace, write_trace

    with answering(as_json):
        place = _place(tag, at)
        opened = open_trace(trace)
        found = detect_phase_sign(opened.scan(stop))
        sign = -opened.meta.phase_sign if found.reversed else opened.meta.phase_sign
        fitting = Trace(
            replace(opened.meta, phase_sign=sign), opened.reads, opened.antenna_poses, opened.stops, opened.proximity
        )
        offsets = None if tag is None or place is None else _offsets(fitting, tag, place, stop)
        if out is not None:
            pairs = () if offsets is None else offsets.as_pairs()
            meta = replace(fitting.meta, channel_offsets_rad=pairs or fitting.meta.channel_offsets_rad)
            calibrated = Trace(meta, opened.reads, opened.antenna_poses, opened.stops, opened.proximity)
            write_trace(calibrated, out, overwrite=overwrite)
            messages().print(f"calibrated trace: {out}", markup=False)
        stated = "as stated" if not found.reversed else "the trace states the opposite"
        messages().print(
            f"focus {found.focus:.2f}, reversed {found.focus_reversed:.2f}, {found.tags} tags", markup=False
        )
        if as_json:
            print_json({"phase_sign": sign, "stated": opened.meta.phase_sign, "focus": found.focus,
                        "focus_reversed": found.focus_reversed, **_as_json(offsets)})  # fmt: skip
            return
        typer.echo(f"phase_sign {sign:+d} ({stated})")
        for freq_hz, offset_rad in () if offsets is None else offsets.as_pairs():
            typer.echo(f"{freq_hz / 1e6:9.3f} MHz  {offset_rad:6.3f} rad")


def _place(tag: str | None, at: str | None) -> "list[float] | None":
    from rfcompass.errors import InputError

    if (tag is None) != (at is None):
        raise InputError("a known tag needs both --tag and --at", tag=tag, at=at)
    if at is None:
        return None
    try:
        x, y, z = (float(text) for text in at.split(","))
    except ValueError as cause:
        raise InputError(f"--at {at!r} is no x,y,z in metres", at=at) from cause
    return [x, y, z]


def _offsets(trace: "Trace", tag: str, place_m: list[float], stop: int | None) -> "ChannelOffsets":
    import numpy as np

    from rfcompass.errors import InputError
    from rfcompass.rf import channel_offsets

    if trace.meta.channel_offsets_rad:
        raise InputError("the trace has channel_offsets_rad already; they would be taken out twice")
    return channel_offsets(trace.scan(stop).trace(tag), np.array(place_m), trace.meta.phase_sign)


def _as_json(offsets: "ChannelOffsets | None") -> dict[str, Any]:
    if offsets is None:
        return {"channel_offsets_rad": None, "agreement": None}
    pairs = {f"{freq_hz:.17g}": offset for freq_hz, offset in offsets.as_pairs()}
    return {"channel_offsets_rad": pairs, "agreement": offsets.agreement}
