"""Straight synthetic apertures: what is left of a run once its positions are laid on a line.

A far-field profile asks from which angle to the track a wave comes; that angle exists only if the track is a line.
A path with corners has several straight apertures, one for each leg.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from rfcompass.errors import UnsuitablePath
from rfcompass.rf.path_legs import straight_legs
from rfcompass.rf.runs import legs, runs
from rfcompass.rf.waves import wavelength
from rfcompass.types.reads import ReadTrace

STRAIGHT_WITHIN_WAVELENGTHS = 1 / 16  # ours: bends the phase of a monostatic echo by at most π/4


@dataclass(frozen=True, slots=True)
class Aperture:
    """Channel of one tag along one straight leg of a run.

    Attributes:
        offsets_m: Place of each position along the line, in path direction, shape (L,).
        channel: h, 0 where nothing was heard, shape (L, F).
        mask: True where the tag was heard, shape (L, F).
        frequencies_hz: Carrier frequencies, shape (F,).
        legs: Change of the round trip per metre towards the tag: 2 monostatic, 1 with a fixed transmitter; twice that
            where the phase is known modulo π and h is squared.
    """

    offsets_m: FloatArray
    channel: ComplexArray
    mask: BoolArray
    frequencies_hz: FloatArray
    legs: float

    def split(self, parts: int) -> list["Aperture"]:
        """Cut into equally long sub-apertures; a position on a cut belongs to the later one."""
        share = (self.offsets_m - self.offsets_m.min()) / np.ptp(self.offsets_m)
        part = np.minimum((share * parts + 1e-9).astype(int), parts - 1)  # rounding must not choose the side of a cut
        return [self._only(part == p) for p in range(parts)]

    def _only(self, keep: BoolArray) -> "Aperture":
        return Aperture(self.offsets_m[keep], self.channel[keep], self.mask[keep], self.frequencies_hz, self.legs)


def straight_apertures(trace: ReadTrace) -> list[Aperture]:
    """Lay each straight leg of each run on the line fitted through its positions.

    Raises:
        UnsuitablePath: If a run is no polygon of legs that are straight within λ/16, if the antenna does not move
            along a leg, or if the transmitter of a bistatic rig moves otherwise than the receiver.
    """
    shortest_m = float(wavelength(trace.frequencies_hz).min())
    apertures = []
    for rows in runs(trace):
        bent = straight_legs(trace.antenna_positions_m[rows], STRAIGHT_WITHIN_WAVELENGTHS * shortest_m)
        apertures += [_aperture(trace, rows[leg], shortest_m) for leg in bent]
    return apertures


def _aperture(trace: ReadTrace, rows: IntArray, wavelength_m: float) -> Aperture:
    offsets_m = _offsets_along_line(trace.antenna_positions_m[rows], wavelength_m)
    if trace.tx_positions_m is not None and legs(trace) == 2.0:
        _check_moving_together(trace.antenna_positions_m[rows], trace.tx_positions_m[rows])
    h, g = trace.channel[rows], legs(trace)
    if trace.phase_modulus_rad < 2 * np.pi:  # h and -h are one and the same: square the phase, and with it the path
        h, g = h**2 / np.where(h != 0, np.abs(h), 1.0), 2 * g
    return Aperture(offsets_m, h, trace.mask[rows], trace.frequencies_hz, g)


def _offsets_along_line(positions_m: FloatArray, wavelength_m: float) -> FloatArray:
    centred = positions_m - positions_m.mean(axis=0)
    direction = np.linalg.svd(centred, full_matrices=False)[2][0]
    offsets_m = centred @ direction
    length_m = float(np.ptp(offsets_m))
    if length_m < wavelength_m / 16:
        raise UnsuitablePath(f"the antenna moves {length_m:.3f} m only: no aperture", length_m=length_m)
    return np.asarray(offsets_m if offsets_m[-1] >= offsets_m[0] else -offsets_m)


def _check_moving_together(rx_m: FloatArray, tx_m: FloatArray) -> None:
    drift_m = float(np.ptp(rx_m - tx_m, axis=0).max())
    if drift_m > 1e-3:
        message = f"transmitter and receiver move apart by {drift_m:.3f} m: no angular profile"
        raise UnsuitablePath(message, drift_m=drift_m)
