"""Phases that all tags of a rail have in common, learnt from references: a pattern in bearing and one along the slide.

What the line of sight leaves of a reference's phases at its true place is fitted with cosines of the bearing and of the
position on the slide, six of each, by least squares with a ridge; taken out of the phases of the tags that are sought,
these are located anew. Tried for measured sweeps, see docs/posterior.md; not part of the library.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.localization import survey
from rfcompass.localization.phase_model import build_phase_model
from rfcompass.types.reads import ReadTrace, Scan

TERMS, RIDGE, LARGEST_RAD = 6, 300.0, 2.0
Placed = tuple[ReadTrace, FloatArray]


def corrected_fixes(sought: Sequence[Placed], references: Sequence[Placed]) -> FloatArray:
    """Places of the sought tags once the common phases at their first places are taken out [m], shape (T, 2)."""
    weights = _learnt(references)
    traces = {}
    for trace, place_m in sought:
        common_rad = _patterns(trace, place_m) @ weights
        traces[trace.epc] = replace(trace, channel=trace.channel * np.exp(1j * common_rad)[:, None])
    fixes = {fix.epc: fix.point_m[:2] for fix in survey(Scan(traces=traces, dimensions=2))}
    return np.array([fixes[trace.epc] for trace, _ in sought])


def _learnt(references: Sequence[Placed]) -> FloatArray:
    patterns, phases = [], []
    for trace, place_m in references:
        left_rad = _left_over(trace, place_m)
        heard = np.isfinite(left_rad)
        own = _patterns(trace, place_m)[heard]
        patterns.append(own - own.mean(axis=0))
        phases.append(np.clip(left_rad[heard] - left_rad[heard].mean(), -LARGEST_RAD, LARGEST_RAD))
    X, y = np.vstack(patterns), np.concatenate(phases)
    return np.asarray(np.linalg.solve(X.T @ X + RIDGE * np.eye(X.shape[1]), X.T @ y))


def _left_over(trace: ReadTrace, place_m: FloatArray) -> FloatArray:
    """What the line of sight leaves of the phase, mean over channels, NaN where unheard [rad], shape (M,)."""
    point_m, model = np.array([*place_m, 0.0]), build_phase_model(trace)
    way_m = trace.round_trip_m(point_m[None])[0]
    total, count = np.zeros(len(way_m)), np.zeros(len(way_m))
    for stretch, lag in zip(model.stretches, model.lags(point_m), strict=True):
        left = lag - stretch.k * way_m[stretch.rows]
        total[stretch.rows] += left - np.median(left)
        count[stretch.rows] += 1
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _patterns(trace: ReadTrace, place_m: FloatArray) -> FloatArray:
    x_m = trace.antenna_positions_m[:, 0]
    bearing_rad = np.arctan2(place_m[1], x_m - place_m[0])
    along = (x_m - x_m.min()) / max(float(np.ptp(x_m)), 1e-9)
    return np.column_stack(
        [np.cos(n * bearing_rad) for n in range(1, TERMS + 1)]
        + [np.cos(n * np.pi * along) for n in range(1, TERMS + 1)]
    )
