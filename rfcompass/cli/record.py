"""`rfcompass record HOST`: live reads from an LLRP reader into a trace."""

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rfcompass.cli.antennas import (
    CarrierOption,
    DimensionsOption,
    FrameOption,
    ModulusOption,
    PhaseModulus,
    PosesOption,
    PositionOption,
    SignOption,
    carriage_of,
    integers,
)
from rfcompass.cli.output import JsonFlag, answering, messages, print_json

if TYPE_CHECKING:
    from rfcompass.recordings import Recording, TraceMeta
    from rfcompass.recordings.sources import LlrpSource


def record_command(
    host: Annotated[str, typer.Argument(help="Name or address of the reader.")],
    port: Annotated[int, typer.Option(help="TCP port.")] = 5084,
    out: Annotated[Path, typer.Option(help="Trace folder to write.")] = Path("recording_trace"),
    overwrite: Annotated[bool, typer.Option(help="Replace a trace that is already there.")] = False,
    antennas: Annotated[str | None, typer.Option(help="Ports to read from, for example 1,2; all by default.")] = None,
    duration: Annotated[float | None, typer.Option(help="Seconds to read; until Ctrl-C by default.")] = None,
    reads: Annotated[int | None, typer.Option(help="Stop once so many reads were kept.")] = None,
    power: Annotated[float | None, typer.Option(help="Transmit power in dBm; the reader's choice by default.")] = None,
    session: Annotated[int, typer.Option(help="Gen2 session, 0 to 3.")] = 1,
    hop_table: Annotated[int | None, typer.Option(help="Hop table in use, for readers that have several.")] = None,
    patience: Annotated[float, typer.Option(help="Seconds to try to come back to a reader that was lost.")] = 60.0,
    antenna_position: PositionOption = None,
    poses: PosesOption = None,
    carrier: CarrierOption = None,
    frame: FrameOption = "antenna",
    dimensions: DimensionsOption = 3,
    phase_sign: SignOption = 1,
    phase_modulus: ModulusOption = PhaseModulus.HALF,
    as_json: JsonFlag = False,
) -> None:
    """Record what a reader hears; Ctrl-C ends the recording and keeps it."""
    from rfcompass.recordings import TraceMeta, record

    with answering(as_json):
        from rfcompass.recordings.sources import Backoff, InventorySettings, LlrpSource

        carriage = carriage_of(antenna_position, poses, carrier)
        meta = TraceMeta(frame, "monostatic", phase_sign, phase_modulus.value, dimensions)
        source = LlrpSource(
            host,
            port,
            antennas=integers(antennas, "--antennas"),
            duration_s=duration,
            max_reads=reads,
            settings=InventorySettings(tx_power_dbm=power, session=session, hop_table_id=hop_table),
            backoff=Backoff(patience_s=patience),
        )
        with _stopped_by_signals(source):
            done = record(
                source,
                out,
                meta=lambda: _described(meta, source),
                carriage=carriage,
                overwrite=overwrite,
                progress=_progress(),
            )
        if carriage is None:
            messages().print("where the antennas were is not known: they are put at the origin")
        _answer(done, as_json)


def _described(meta: "TraceMeta", source: "LlrpSource") -> "TraceMeta":
    reader = source.info.description if source.info is not None else "LLRP"
    return replace(meta, source=f"live recording from {source.host}", reader=reader)


@contextmanager
def _stopped_by_signals(source: "LlrpSource") -> Iterator[None]:
    """Let the first Ctrl-C end the recording politely; a second one interrupts, and the reads stay in the spool."""

    def stop(number: int, _: FrameType | None) -> None:
        source.stop()
        signal.signal(number, before[number])

    numbers = (signal.SIGINT, signal.SIGTERM)
    before: dict[int, Any] = {number: signal.getsignal(number) for number in numbers}
    for number in numbers:
        signal.signal(number, stop)
    try:
        yield
    finally:
        for known, handler in before.items():
            signal.signal(known, handler)


def _progress() -> Callable[[int], None]:
    """Say now and then how many reads there are."""
    next_s = time.monotonic() + 1.0

    def show(reads: int) -> None:
        nonlocal next_s
        if time.monotonic() >= next_s:
            next_s = time.monotonic() + 5.0
            messages().print(f"{reads} reads")

    return show


def _answer(done: "Recording", as_json: bool) -> None:
    counts = done.counts
    dropped = counts["dropped"]
    messages().print(f"{done.path}: {done.reads} reads of {len(done.epcs)} tags", markup=False)
    if isinstance(dropped, dict) and dropped:
        messages().print("dropped: " + ", ".join(f"{reason} {count}" for reason, count in dropped.items()))
    if counts.get("reconnects"):
        lost = f"the reader was lost {counts['gap_count']} times, for {counts['gap_s']} s in all"
        messages().print(lost)
    if counts.get("ended") not in ("duration", "reads", "stopped"):
        messages().print(f"the recording ended early: {counts.get('ended')}", markup=False)
    if as_json:
        print_json({"trace": str(done.path), "reads": done.reads, "epcs": done.epcs, **counts})
