"""Near-field image of one tag over an antenna path with corners: the product of its legs' matched filters.

Each straight leg l of the path gives its share of the power that perfect agreement would give,

    B_l(p) = Σ_looks | Σ_k h_k exp(+j k_f d(p, a_k)) |² / Σ_looks ( Σ_k |h_k| )²,        0 <= B_l <= 1,

with looks as in `rfcompass.rf.hologram`. One leg sees a tag sharply across its line of sight and hardly along it; where
the ridges of two legs at an angle cross is the tag, and the image is the product Π_l B_l(p).

The feeds of an antenna that takes several polarisations are further looks: their powers are added within a leg.

Legs are not added as complex numbers. Along a leg a robot knows its own path to millimetres, but after a turn by a
degree it is centimetres off: a good part of a wavelength, which would ruin a coherent sum. The product only shifts.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.errors import UnsuitablePath
from rfcompass.rf.aperture import STRAIGHT_WITHIN_WAVELENGTHS
from rfcompass.rf.hologram import Hologram, Matching, build_hologram, matched_phasors
from rfcompass.rf.image_slopes import LegSlopes, Slopes, product_slopes
from rfcompass.rf.path_legs import straight_legs
from rfcompass.rf.runs import legs, runs
from rfcompass.rf.waves import wavelength, wavenumber
from rfcompass.types.reads import ReadTrace
from rfcompass.types.volumes import SearchVolume


@dataclass(frozen=True)
class NearFieldImage:
    """Image of one trace over one volume; make it with `near_field_image`.

    Attributes:
        volume: Where it can be evaluated.
        fringe_m: How far a point moves, at least, from one crest of the image to the next.
        legs: Matched filter of each leg.
        norms: Power of each leg if all cells agreed.
        slopes: The same in double precision, with derivatives.
    """

    volume: SearchVolume
    fringe_m: float
    legs: tuple[Hologram, ...]
    norms: tuple[float, ...]
    slopes: tuple[LegSlopes, ...]

    def power(self, points_m: FloatArray) -> FloatArray:
        """Π_l B_l(p) at each point [m], shape (P, 3), inside the volume; shape (P,)."""
        power = self.legs[0].power(points_m) / self.norms[0]
        for leg, norm in zip(self.legs[1:], self.norms[1:], strict=True):
            power *= leg.power_inside(points_m)
            power /= norm
        return power

    def log_slopes(self, point_m: FloatArray) -> Slopes:
        """Σ_l log B_l at one point [m], shape (3,), with gradient and Hessian, in double precision."""
        return product_slopes(self.slopes, point_m)


def near_field_image(
    trace: ReadTrace,
    volume: SearchVolume,
    *,
    split_legs: bool = True,
    sub_apertures: int = 1,
    coherent: bool = False,
    amplitude: bool = True,
) -> NearFieldImage:
    """Prepare the image of one tag.

    Args:
        trace: Reads of one tag, heard at least once.
        volume: Where the tag may be, in the frame of the antenna path.
        split_legs: Treat each straight leg of the path as a factor of its own; otherwise each antenna's whole path.
        sub_apertures: Cut each leg into as many factors.
        coherent: Add the channels of a leg as complex numbers, see `Matching`.
        amplitude: Weigh every cell by |h|, so that fades, where the phase slips, hardly count.
    """
    matching = Matching(coherent=coherent, amplitude=amplitude)
    parts = [_part(trace, rows) for rows in image_legs(trace, split_legs=split_legs, sub_apertures=sub_apertures)]
    parts = [part for part in parts if part.mask.any()]
    slopes = tuple(_leg_slopes(part, matching) for part in parts)
    k = max(leg.k.max() for leg in slopes)
    return NearFieldImage(
        volume=volume,
        fringe_m=float(2.0 * np.pi / (legs(trace) * k)),
        legs=tuple(build_hologram(part, volume, matching) for part in parts),
        norms=tuple(leg.norm for leg in slopes),
        slopes=slopes,
    )


def image_legs(trace: ReadTrace, *, split_legs: bool, sub_apertures: int) -> list[IntArray]:
    """Antenna positions of each factor of the image: per antenna, leg and sub-aperture.

    A path that is neither line nor polygon is one leg: an image, unlike an angular profile, takes any path.
    """
    found: list[IntArray] = []
    for feeds in antenna_feeds(trace):
        legs_of_path = _legs_of(trace, feeds[0]) if split_legs else [np.arange(feeds.shape[1])]
        for leg in legs_of_path:
            found += [feeds[:, part].ravel() for part in np.array_split(leg, sub_apertures) if part.size]
    return found


def antenna_feeds(trace: ReadTrace) -> list[IntArray]:
    """Rows of each antenna, one line for each of its feeds, shape (feeds, L).

    Two ports that hear from the same places are two feeds of one antenna, which takes two polarisations. They see the
    tag from one side: their powers are added, so that the feed that hears the tag better counts for more.
    """
    found: list[IntArray] = []
    for port in np.unique(trace.antenna_ports):
        rows = np.flatnonzero(trace.antenna_ports == port)
        for index, feeds in enumerate(found):
            if _same_places(trace, feeds[0], rows):
                found[index] = np.vstack([feeds, rows])
                break
        else:
            found.append(rows[None, :])
    return found


def _same_places(trace: ReadTrace, one: IntArray, other: IntArray) -> bool:
    if len(one) != len(other):
        return False
    apart_m = np.linalg.norm(trace.antenna_positions_m[one] - trace.antenna_positions_m[other], axis=1)
    return bool(apart_m.max() <= _tolerance_m(trace))


def _tolerance_m(trace: ReadTrace) -> float:
    return STRAIGHT_WITHIN_WAVELENGTHS * float(wavelength(trace.frequencies_hz).min())


def _legs_of(trace: ReadTrace, rows: IntArray) -> Sequence[IntArray]:
    """Places in `rows` of each straight leg."""
    try:
        return straight_legs(trace.antenna_positions_m[rows], _tolerance_m(trace))
    except UnsuitablePath:
        return [np.arange(len(rows))]


def _part(trace: ReadTrace, rows: IntArray) -> ReadTrace:
    return replace(
        trace,
        antenna_positions_m=trace.antenna_positions_m[rows],
        channel=trace.channel[rows],
        read_counts=trace.read_counts[rows],
        antenna_ports=trace.antenna_ports[rows],
        tx_positions_m=None if trace.tx_positions_m is None else trace.tx_positions_m[rows],
    )


def _leg_slopes(part: ReadTrace, matching: Matching) -> LegSlopes:
    turns = round(2.0 * np.pi / part.phase_modulus_rad)
    h = matched_phasors(part, turns, amplitude=matching.amplitude)
    sums = [np.abs(h[rows]).sum(axis=0) for rows in runs(part)]
    norm = sum(float(s.sum() ** 2 if matching.coherent else (s**2).sum()) for s in sums)
    k = turns * wavenumber(part.frequencies_hz)
    return LegSlopes(
        part.antenna_positions_m, part.tx_positions_m, h, k, tuple(runs(part)), matching.coherent, norm
    )  # fmt: skip
