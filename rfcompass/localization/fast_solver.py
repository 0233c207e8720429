"""The partition problem on compiled kernels: the same answers as the reference, two orders of magnitude sooner."""

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import SolverFailed
from rfcompass.localization import partition_kernels as kernels
from rfcompass.localization.scaled_rows import ScaledRows

_TOLERANCE_M = 1e-9
_INSIDE = 1.0 - 1e-9  # of the disc's radius: where Newton's method may start
_MAX_CUTS = 20


def largest_ball(scaled: ScaledRows) -> tuple[FloatArray, float]:
    """Chebyshev centre: maximise r, subject to G y + r <= h and the 64-gon.

    Returns:
        The centre in scaled unknowns, shape (n,), and the radius [m], negative if the rows contradict each other.

    Raises:
        SolverFailed: If the solver stops without a verdict; never mistaken for contradicting rows.
    """
    return _ball(*scaled.with_polygon())


def analytic_centre(scaled: ScaledRows, near: FloatArray) -> FloatArray | None:
    """Minimise -Σ log(b - A z) - log(1 - c² - s²), in scaled unknowns.

    Args:
        scaled: Rows and bounds.
        near: Centre of the largest ball in the cell, scaled, shape (n,).

    Returns:
        The centre in scaled unknowns, shape (n,); None if the cell lies wholly between the 64-gon and the disc.

    Raises:
        SolverFailed: If the solver stops without a verdict.
    """
    start = _start_in_disc(scaled, near)
    if start is None:
        return None
    y, status = kernels.analytic_centre(np.ascontiguousarray(scaled.G.T), scaled.h, start, scaled.disc)
    if status != kernels.SOLVED:
        raise SolverFailed(f"Newton's method stalled on {scaled.h.size} rows", status="stalled")
    return np.asarray(y)


def _start_in_disc(scaled: ScaledRows, near: FloatArray) -> FloatArray | None:
    """Move a point of the 64-gon into the disc, by cutting off the corner it lies in until it is inside."""
    G, h = scaled.G, scaled.h
    for _ in range(_MAX_CUTS):
        distance = float(np.hypot(*near[2:])) if scaled.disc else 0.0
        if distance <= _INSIDE * scaled.disc:
            return near
        if G is scaled.G:
            G, h = scaled.with_polygon()
        tangent = np.concatenate([[0.0, 0.0], near[2:] / distance])
        G, h = np.vstack([G, tangent]), np.append(h, scaled.disc)
        near, radius_m = _ball(G, h)
        if radius_m <= _TOLERANCE_M:
            return None
    return None


def _ball(G: FloatArray, h: FloatArray) -> tuple[FloatArray, float]:
    y, radius_m, status = kernels.chebyshev(np.ascontiguousarray(G.T), h, _TOLERANCE_M)
    if status != kernels.SOLVED:
        raise SolverFailed(f"the linear program stalled on {h.size} rows", status="stalled")
    return y, radius_m
