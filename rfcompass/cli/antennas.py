"""Options of the commands that make traces: where the antennas were, and how to read the phase."""

from collections.abc import Callable, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from rfcompass.errors import InputError

if TYPE_CHECKING:
    from rfcompass.recordings import Carriage


class PhaseModulus(StrEnum):
    """What a reader's phase is known modulo."""

    FULL = "2pi"
    HALF = "pi"


PositionOption = Annotated[
    list[str] | None,
    typer.Option(help="Still antenna, PORT=x,y,z in metres, for example 1=0,0,1.5; once for each port in use."),
]
PosesOption = Annotated[Path | None, typer.Option(help="Still antennas: an antenna_poses.csv, one row for each port.")]
CarrierOption = Annotated[
    Path | None,
    typer.Option(help="Moving antennas: CSV log of the carrier: t_ns, antenna, x_m, y_m, z_m[, qx, qy, qz, qw]."),
]
FrameOption = Annotated[str, typer.Option(help="Name of the frame of the antenna positions.")]
DimensionsOption = Annotated[int, typer.Option(help="2 if tags and antennas share one plane, else 3.")]
SignOption = Annotated[int, typer.Option(help="+1 if the reader's phase grows with distance, else -1.")]
ModulusOption = Annotated[PhaseModulus, typer.Option(help="pi for readers that mix up half turns, as Impinj's do.")]


def carriage_of(
    positions: Sequence[str] | None, poses: Path | None, carrier: Path | None
) -> "Callable[[], Carriage] | None":
    """Where the antennas were, as the options say; None if they say nothing. A carrier log is read when it is needed.

    Raises:
        InputError: If an option is malformed, or if they contradict each other.
    """
    from rfcompass.recordings import CarrierLog, StillAntennas

    if sum(bool(option) for option in (positions, poses, carrier)) > 1:
        raise InputError("of --antenna-position, --poses and --carrier only one can say where the antennas were")
    if carrier is not None:
        return lambda: CarrierLog.read(carrier)
    if poses is not None:
        still = StillAntennas.read(poses)
        return lambda: still
    if positions:
        places = [_position(text) for text in positions]
        placed = StillAntennas(dict(places))
        if len(placed.positions_m) < len(places):
            raise InputError("--antenna-position: a port stands twice", value=list(positions))
        return lambda: placed
    return None


def integers(text: str | None, option: str) -> tuple[int, ...]:
    """Numbers separated by commas.

    Raises:
        InputError: If one is none.
    """
    try:
        return tuple(int(part) for part in text.split(",")) if text else ()
    except ValueError as cause:
        raise InputError(f"{option}: {text!r} is no list of integers such as 1,2", option=option, value=text) from cause


def table_hz(text: str | None) -> tuple[float, ...] | None:
    """Frequencies in MHz, separated by commas or in a text file, one for each channel index from 1 [Hz].

    Raises:
        InputError: If one is no UHF carrier in MHz, or the file cannot be read.
    """
    from rfcompass.recordings.foreign_log import UHF_HZ

    if text is None:
        return None
    try:
        content = Path(text).read_text(encoding="utf-8") if Path(text).is_file() else text
        table = tuple(round(float(part) * 1e6) for part in content.replace(",", " ").split())
    except (OSError, ValueError, OverflowError) as cause:
        raise InputError(f"--frequencies: {text!r} is no list of MHz: {cause}", value=text) from cause
    if not table or min(table) < UHF_HZ[0] or max(table) > UHF_HZ[1]:
        message = f"--frequencies: {text!r} is no list of carriers in MHz between 300 and 3000, such as 902.75,903.25"
        raise InputError(message, value=text)
    return tuple(float(freq_hz) for freq_hz in table)


def _position(text: str) -> "tuple[int, np.ndarray[tuple[int, ...], np.dtype[np.float64]]]":
    port, _, coordinates = text.partition("=")
    try:
        place_m = np.array([float(part) for part in coordinates.split(",")])
        number = int(port)
    except ValueError:
        place_m, number = np.zeros(0), 0
    if place_m.shape != (3,) or not np.isfinite(place_m).all():
        raise InputError(f"--antenna-position: {text!r} is not PORT=x,y,z, for example 1=0,0,1.5", value=text)
    return number, place_m
