"""What to measure next if a tag's confidence box is too large [Boroushaki2023], section 4.2.

The paper says that one may "take more RF measurements", not which. Each kind of aperture shrinks other axes: a longer
side the two across the line of sight, bandwidth and a second height the third. How much is tried out: reads of a tag
at the place of the fix are computed for free space, with and without the addition, and the ratio of the two boxes is
applied to the box that was measured, which holds what reflections add.
"""

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.localization.sar import SarSurveyor
from rfcompass.rf.waves import free_space_channel
from rfcompass.types.fixes import TagFix
from rfcompass.types.reads import ReadTrace
from rfcompass.types.record import Record
from rfcompass.types.volumes import SearchVolume

Aid: TypeAlias = Literal["second height", "longer side", "more bandwidth"]

# All ours: steps that a tabletop arm and a wide-band radio can take.
RISE_M = 0.25
SIDE_FACTOR = 1.5
BANDWIDTH_HZ = 200e6
CARRIERS = 17
AXES = ("x", "y", "z")


@dataclass(frozen=True, slots=True)
class MoreAperture(Record):
    """One way to measure more, and what it is expected to give.

    Attributes:
        aid: What to do: repeat the path higher up, make it larger, or use more bandwidth.
        amount: By how much: metres up, metres of the path's longer side, or hertz from first to last carrier.
        box_m: Expected box along x, y, z [m], shape (3,).
        enough: Whether that is below the threshold along every axis.
    """

    aid: Aid
    amount: float
    box_m: FloatArray
    enough: bool

    def __post_init__(self) -> None:
        """Freeze the box."""
        object.__setattr__(self, "box_m", read_only(self.box_m, "MoreAperture.box_m", (3,)))


@dataclass(frozen=True, slots=True)
class MeasureMore(Record):
    """Why a fix is not confident, and what would help.

    Attributes:
        epc: EPC of the tag.
        wide_axes: Axes along which the box is not below its threshold, of "x", "y", "z"; none if it is only clipped.
        clipped: Whether the box is cut off, so that its extent is a lower bound.
        box_m: Box of the fix [m], shape (3,).
        max_box_m: Thresholds [m], shape (3,).
        options: What could be measured, most helpful first.
    """

    epc: str
    wide_axes: tuple[str, ...]
    clipped: bool
    box_m: FloatArray
    max_box_m: FloatArray
    options: tuple[MoreAperture, ...]

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "box_m", read_only(self.box_m, "MeasureMore.box_m", (3,)))
        object.__setattr__(self, "max_box_m", read_only(self.max_box_m, "MeasureMore.max_box_m", (3,)))


def measure_more(trace: ReadTrace, fix: TagFix, volume: SearchVolume, surveyor: SarSurveyor) -> MeasureMore | None:
    """Advise what to measure; None if the fix is confident already.

    Height is z of the frame of the antenna path.

    Args:
        trace: Reads that the fix rests on.
        fix: Where the tag seems to be.
        volume: Where it was searched.
        surveyor: How it was located; holds the thresholds.
    """
    if fix.confident:
        return None
    limits_m = np.array(surveyor.max_box_m)
    heard = _heard(trace)
    excess = _ratio(fix.box_m, _free_box_m(heard, fix, volume, surveyor))
    options = [
        _option(aid, amount, excess * _free_box_m(more, fix, volume, surveyor), limits_m)
        for aid, amount, more in _larger(heard)
    ]
    options.sort(key=lambda option: float((option.box_m / limits_m).max()))
    wide = tuple(name for name, box, limit in zip(AXES, fix.box_m, limits_m, strict=True) if box >= limit)
    return MeasureMore(fix.epc, wide, fix.clipped, fix.box_m, limits_m, tuple(options))


def _free_box_m(places: ReadTrace, fix: TagFix, volume: SearchVolume, surveyor: SarSurveyor) -> FloatArray:
    """Box of a tag at the fix in free space, measured from the places and carriers of a trace [m], shape (3,)."""
    rx_m, tx_m = places.antenna_positions_m, places.tx_positions_m
    h = free_space_channel(fix.point_m, rx_m, places.frequencies_hz, tx_positions_m=tx_m)
    ideal = replace(places, channel=h, read_counts=np.ones(h.shape, dtype=np.int64))
    return surveyor.box_at(ideal, volume, fix.point_m).extent_m


def _ratio(measured_m: FloatArray, free_m: FloatArray) -> FloatArray:
    """By which factor the measured box exceeds free space's; 1 along an axis that is not searched."""
    return np.divide(measured_m, free_m, out=np.ones(3), where=free_m > 0)


def _option(aid: Aid, amount: float, box_m: FloatArray, limits_m: FloatArray) -> MoreAperture:
    return MoreAperture(aid, amount, box_m, bool((box_m < limits_m).all()))


def _heard(trace: ReadTrace) -> ReadTrace:
    """The positions and carriers at which the tag was heard."""
    rows, columns = trace.mask.any(axis=1), trace.mask.any(axis=0)
    return replace(
        trace,
        antenna_positions_m=trace.antenna_positions_m[rows],
        frequencies_hz=trace.frequencies_hz[columns],
        channel=trace.channel[np.ix_(rows, columns)],
        read_counts=trace.read_counts[np.ix_(rows, columns)],
        antenna_ports=trace.antenna_ports[rows],
        tx_positions_m=None if trace.tx_positions_m is None else trace.tx_positions_m[rows],
    )


def _larger(now: ReadTrace) -> list[tuple[Aid, float, ReadTrace]]:
    """The same places and carriers with one thing added; the channel has no meaning yet."""
    rx_m, f_hz = now.antenna_positions_m, now.frequencies_hz
    raised_m = np.concatenate([rx_m, rx_m + np.array([0.0, 0.0, RISE_M])])
    centre_m = rx_m.mean(axis=0)
    spread_m = centre_m + (rx_m - centre_m) * [SIDE_FACTOR, SIDE_FACTOR, 1.0]
    band_hz = float(np.ptp(f_hz))
    wide_hz = BANDWIDTH_HZ if band_hz < BANDWIDTH_HZ else 2.0 * band_hz
    carriers_hz = float(f_hz.mean()) + wide_hz * np.linspace(-0.5, 0.5, CARRIERS)
    side_m = float(np.ptp(spread_m[:, :2], axis=0).max())
    return [
        ("second height", RISE_M, _measured_from(now, raised_m, f_hz)),
        ("longer side", side_m, _measured_from(now, spread_m, f_hz)),
        ("more bandwidth", wide_hz, _measured_from(now, rx_m, carriers_hz[carriers_hz > 0])),
    ]


def _measured_from(now: ReadTrace, rx_m: FloatArray, frequencies_hz: FloatArray) -> ReadTrace:
    """Places for the receiver, gone through once or several times; the transmitter keeps its distance from it."""
    times = len(rx_m) // len(now.antenna_positions_m)
    moved_m = rx_m - np.tile(now.antenna_positions_m, (times, 1))
    tx_m = None if now.tx_positions_m is None else np.tile(now.tx_positions_m, (times, 1)) + moved_m
    shape = (len(rx_m), frequencies_hz.size)
    return ReadTrace(
        epc=now.epc,
        antenna_positions_m=rx_m,
        frequencies_hz=frequencies_hz,
        channel=np.zeros(shape, dtype=np.complex128),
        read_counts=np.zeros(shape, dtype=np.int64),
        antenna_ports=np.tile(now.antenna_ports, times),
        tx_positions_m=tx_m,
        phase_modulus_rad=now.phase_modulus_rad,
    )
