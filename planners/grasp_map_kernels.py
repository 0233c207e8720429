"""Compiled search for the best two-finger grasp at each pixel: all angles, all depths, the largest log-odds.

The log-odds of a grasp are a weighted sum of its numbers, see `grasp_number_kernels`, plus a constant.
"""

from typing import NamedTuple

import numba
import numpy as np

from planners.grasp_number_kernels import (
    CLOSING,
    LEAST_M,
    LINES,
    MIDDLE,
    PINCH_DEPTH_M,
    PINCH_WIDTH_M,
    STEPS,
    Claw,
    Grid,
    Spot,
    closing_numbers,
    is_even,
    may_close,
    pinching_numbers,
    take_lines,
)
from rfcompass.arrays import BoolArray, FloatArray, IntArray

CLOSES, PINCHES = 1, 2


class Tries(NamedTuple):
    """What to try at each pixel: angles [rad] and growing depths [m]; weights of the numbers, the constant last."""

    angles: FloatArray
    depths: FloatArray
    closing: FloatArray
    pinching: FloatArray


class Found(NamedTuple):
    """The best grasp at each pixel: log-odds, angle [rad], width [m], depth [m], kind, numbers; written in place."""

    log_odds: FloatArray
    angle: FloatArray
    width: FloatArray
    depth: FloatArray
    kind: IntArray
    numbers: FloatArray


@numba.njit(cache=True)
def rate_pixels(points: FloatArray, wanted: BoolArray, grid: Grid, claw: Claw, tries: Tries, found: Found) -> None:
    """Find the best grasp at each wanted pixel.

    Args:
        points: What each pixel shows, in the world [m], shape (H, W, 3).
        wanted: Pixels to look at, shape (H, W).
        grid: Heights.
        claw: The hand.
        tries: Angles, depths and weights.
        found: Where to write; log-odds begin at minus infinity, kinds at 0.
    """
    profile, around = np.empty((2, LINES, STEPS)), np.empty(4)
    numbers, falls = np.zeros(len(CLOSING)), np.empty((2, LINES), np.int64)
    for v in range(points.shape[0]):
        for u in range(points.shape[1]):
            if not wanted[v, u]:
                continue
            around[0] = np.nan  # the same at all angles
            for angle in tries.angles:
                around[3] = np.nan
                spot = Spot(points[v, u], np.cos(angle), np.sin(angle), profile, around, falls)
                _try_spot(grid, spot, claw, tries, found, (v, u, angle), numbers)


@numba.njit(cache=True, inline="always")
def _try_spot(
    grid: Grid,
    spot: Spot,
    claw: Claw,
    tries: Tries,
    found: Found,
    where: tuple[int, int, float],
    numbers: FloatArray,
) -> None:
    """Try everything at one place and angle; the middle line alone decides first whether that is worth while."""
    take_lines(grid, spot, MIDDLE, MIDDLE + 1)
    closes, pinches = may_close(spot, claw, tries.depths), is_even(spot, MIDDLE, MIDDLE + 1)
    if not (closes or pinches):
        return
    take_lines(grid, spot, 0, MIDDLE)
    take_lines(grid, spot, MIDDLE + 1, LINES)
    if pinches:
        _try_pinch(grid, spot, claw, tries, found, where, numbers)
    if closes:
        _try_depths(grid, spot, claw, tries, found, where, numbers)


@numba.njit(cache=True)
def _try_pinch(
    grid: Grid, spot: Spot, claw: Claw, tries: Tries, found: Found, where: tuple[int, int, float], numbers: FloatArray
) -> None:
    """Try to pinch at one place and angle; keep it if it is better than what was found before."""
    depth = min(PINCH_DEPTH_M, spot.point[2] - claw.lowest)
    if depth >= 0.0 and pinching_numbers(grid, spot, claw, numbers):
        _keep(found, where, (PINCH_WIDTH_M, depth, PINCHES), numbers, tries.pinching)


@numba.njit(cache=True)
def _try_depths(
    grid: Grid,
    spot: Spot,
    claw: Claw,
    tries: Tries,
    found: Found,
    where: tuple[int, int, float],
    numbers: FloatArray,
) -> None:
    """Try to close at all depths at one place and angle; keep what is better than what was found before."""
    spot.falls[:] = 0
    before = -1.0
    for wished in tries.depths:
        depth = min(wished, spot.point[2] - claw.lowest)
        if depth < LEAST_M or depth <= before:
            continue
        before = depth
        width = closing_numbers(grid, spot, depth, claw, numbers)
        if width > 0:
            _keep(found, where, (width, depth, CLOSES), numbers, tries.closing)


@numba.njit(cache=True)
def _keep(
    found: Found,
    where: tuple[int, int, float],
    what: tuple[float, float, int],
    numbers: FloatArray,
    weights: FloatArray,
) -> None:
    """Write a grasp down if it is better than what was found at its pixel so far."""
    v, u, angle = where
    log_odds = weights[-1]
    for n in range(len(weights) - 1):
        log_odds += weights[n] * numbers[n]
    if log_odds > found.log_odds[v, u]:
        found.log_odds[v, u], found.angle[v, u] = log_odds, angle
        found.width[v, u], found.depth[v, u], found.kind[v, u] = what
        found.numbers[v, u] = numbers
