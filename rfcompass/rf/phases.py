"""Unwrapped phases along the antenna path, as lengths of the round trip up to a constant.

Along one run the channel is h(m, f) ≈ a exp(-j k_f d(m)) times an unknown constant. The product of neighbouring
positions, h(m+1, f) h*(m, f), is free of the constant and holds the step d(m+1) - d(m). Near a fade, where reflections
cancel the direct path, single steps are worthless; they are also weak. So steps are averaged over channels and over a
short window of the path, weighted by |h(m+1)| |h(m)|, and their sum is the path profile d(m):

    v(s) = Σ w Δd / Σ w Δs,      d(s) = ∫ v ds.

Steps longer than λ/4 (λ/8 if the phase is known modulo π) are ambiguous and not used; v is interpolated across them.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from rfcompass.rf.runs import legs, runs
from rfcompass.rf.waves import wavenumber
from rfcompass.types.reads import ReadTrace

SMOOTHING_M = 0.12  # ours: about a third of a wavelength; 0.06 to 0.18 m do equally well on measured sweeps
BLOCK = 512  # intervals treated together: bounds the memory for long paths
SAME_DIRECTION = np.cos(np.pi / 4)  # ours: steps around a corner of the path are not averaged


@dataclass(frozen=True, slots=True)
class PathProfile:
    """Round trip antenna → tag → antenna along the antenna path, less one constant for each run.

    Attributes:
        path_m: d(m), shape (M,); NaN in runs where no step could be measured. Mean 0 over the heard part of a run.
        heard: True at positions with at least one read, shape (M,).
        runs: Row indices of each run.
    """

    path_m: FloatArray
    heard: BoolArray
    runs: tuple[IntArray, ...]


def path_profile(trace: ReadTrace, smoothing_m: float = SMOOTHING_M) -> PathProfile:
    """Integrate the phase steps of all channels along each run.

    Args:
        trace: Reads of one tag.
        smoothing_m: Length of the path over which steps are averaged [m]; 0 averages over channels only.
    """
    path_m = np.full(len(trace.antenna_positions_m), np.nan)
    heard = np.asarray(trace.mask.any(axis=1))
    found = tuple(runs(trace))
    k = float(wavenumber(trace.frequencies_hz).mean())
    for rows in found:
        steps = _phase_steps(trace, rows, k)
        if steps.phasor.size:
            path_m[rows] = _integrate(steps, trace.antenna_positions_m[rows], k, smoothing_m)
            path_m[rows] -= path_m[rows][heard[rows]].mean()
    return PathProfile(path_m, heard, found)


def unwrapped_phase(trace: ReadTrace, smoothing_m: float = SMOOTHING_M) -> FloatArray:
    """Phase lag φ = k d of each channel along the path, unwrapped.

    The path profile tells which turn a phase belongs to, also after a gap or a fade. Missing cells are interpolated.
    The unknown constant of each (run, channel) is removed with the median over its heard cells.

    Args:
        trace: Reads of one tag.
        smoothing_m: See `path_profile`.

    Returns:
        φ [rad], shape (M, F); NaN where a run and channel holds fewer than two reads, or no step could be measured.
    """
    profile = path_profile(trace, smoothing_m)
    expected = np.outer(profile.path_m, wavenumber(trace.frequencies_hz))
    phase = np.full(trace.channel.shape, np.nan)
    for rows in profile.runs:
        for f in range(trace.frequencies_hz.size):
            heard = np.flatnonzero(trace.mask[rows, f])
            if heard.size >= 2 and np.isfinite(expected[rows, f]).all():
                rest = -np.angle(trace.channel[rows[heard], f]) - expected[rows[heard], f]
                rest = np.unwrap(rest, period=trace.phase_modulus_rad)
                rest -= np.median(rest + expected[rows[heard], f])
                phase[rows, f] = expected[rows, f] + np.interp(np.arange(rows.size), heard, rest)
    return phase


@dataclass(frozen=True, slots=True)
class _Steps:
    """All usable steps from position `start` to position `end` of a run, channels summed; each of shape (E,).

    Attributes:
        phasor: Σ_f |h' h| exp(-j k Δd_f), with one wavenumber k for all channels.
        length_m: Δs, motion of the antenna [m].
    """

    start: IntArray
    end: IntArray
    phasor: ComplexArray
    length_m: FloatArray

    def only(self, keep: BoolArray) -> "_Steps":
        return _Steps(self.start[keep], self.end[keep], self.phasor[keep], self.length_m[keep])


def _phase_steps(trace: ReadTrace, rows: IntArray, k: float) -> _Steps:
    h, mask, positions_m = trace.channel[rows], trace.mask[rows], trace.antenna_positions_m[rows]
    turns, reach = 2 * np.pi / trace.phase_modulus_rad, legs(trace)
    starts, ends, phasors = [], [], []
    for f, k_f in enumerate(wavenumber(trace.frequencies_hz)):
        heard = np.flatnonzero(mask[:, f])
        start, end = heard[:-1], heard[1:]
        length_m = np.linalg.norm(positions_m[end] - positions_m[start], axis=1)
        clear = (length_m > 0) & (length_m * reach * k_f * turns < np.pi)
        start, end = start[clear], end[clear]
        product = h[end, f] * h[start, f].conj()
        lag = -np.angle(product**turns) / turns
        starts.append(start)
        ends.append(end)
        phasors.append(np.abs(product) * np.exp(-1j * k / k_f * lag))
    return _sum_channels(np.concatenate(starts), np.concatenate(ends), np.concatenate(phasors), positions_m)


def _sum_channels(start: IntArray, end: IntArray, phasor: ComplexArray, positions_m: FloatArray) -> _Steps:
    L = len(positions_m)
    pair, place = np.unique(start * L + end, return_inverse=True)
    total = np.zeros(pair.size, dtype=np.complex128)
    np.add.at(total, place, phasor)
    arc_m = _arc_m(positions_m)
    return _Steps(pair // L, pair % L, total, arc_m[pair % L] - arc_m[pair // L])


def _integrate(steps: _Steps, positions_m: FloatArray, k: float, smoothing_m: float) -> FloatArray:
    """d(m) along one run, shape (L,)."""
    arc_m = _arc_m(positions_m)
    middle_m = (arc_m[1:] + arc_m[:-1]) / 2
    blocks = np.array_split(np.arange(arc_m.size - 1), arc_m.size // BLOCK + 1)
    slope = np.concatenate([_slope(*_nearby(steps, positions_m, block, smoothing_m), k) for block in blocks])
    known = np.isfinite(slope)
    if not known.any():
        return np.full(arc_m.size, np.nan)
    slope = np.interp(middle_m, middle_m[known], slope[known])
    return np.concatenate([[0.0], np.cumsum(slope * np.diff(arc_m))])


def _slope(steps: _Steps, near: FloatArray, k: float) -> FloatArray:
    """Slope v at the middle of each interval of the path, shape (L-1,); NaN where no step is near.

    First the mean of the steps, then the phase of their sum after that mean is taken out of each.
    """
    weight = near * np.abs(steps.phasor)
    length_m = weight @ steps.length_m
    with np.errstate(invalid="ignore", divide="ignore"):
        slope = -(weight @ np.angle(steps.phasor)) / (k * length_m)
        rest = (near * steps.phasor * np.exp(1j * k * np.outer(slope, steps.length_m))).sum(axis=1)
        return np.asarray(slope - np.angle(rest) / k * weight.sum(axis=1) / length_m)


def _nearby(steps: _Steps, positions_m: FloatArray, block: IntArray, smoothing_m: float) -> tuple[_Steps, FloatArray]:
    """Steps around some intervals (I) between neighbouring positions, and the taper weight of each, shape (I, E').

    Steps that skip a position, as in a fade or between the channels of a hopping reader, count only where there are
    no others.
    """
    arc_m = _arc_m(positions_m)
    interval_m, step_m = (arc_m[block] + arc_m[block + 1]) / 2, (arc_m[steps.start] + arc_m[steps.end]) / 2
    half_m = np.maximum(smoothing_m, steps.length_m) / 2
    steps_here = (step_m > interval_m[0] - half_m) & (step_m < interval_m[-1] + half_m)
    steps, step_m, half_m = steps.only(steps_here), step_m[steps_here], half_m[steps_here]
    distance = np.minimum(np.abs(interval_m[:, None] - step_m) / half_m, 1.0)
    here = _directions(positions_m[block + 1] - positions_m[block])
    there = _directions(positions_m[steps.end] - positions_m[steps.start])
    near = np.where(here @ there.T > SAME_DIRECTION, np.cos(np.pi / 2 * distance) ** 2 * (distance < 1), 0.0)
    neighbours = near * (steps.end - steps.start == 1)
    return steps, np.where(neighbours.any(axis=1, keepdims=True), neighbours, near)


def _arc_m(positions_m: FloatArray) -> FloatArray:
    """Length of the path up to each position [m], shape (L,)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions_m, axis=0), axis=1))])


def _directions(steps_m: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(steps_m, axis=1, keepdims=True)
    return np.asarray(steps_m / np.where(lengths > 0, lengths, 1.0))
