"""The numbers of `grasp_number_kernels`, written again in numpy as plainly as they are defined."""

import numpy as np

from planners.height_map import HeightMap

STEP, LINES = 0.0025, np.array([-0.010, -0.005, 0.0, 0.005, 0.010])
OPENING, ROOM, THICK, PALM, CONE, LOWEST = 0.085, 0.020, 0.012, 0.058, np.arctan(0.6), 0.004


def over(heights, x, y):
    """Heights of a `HeightMap` over points."""
    i = np.floor((x - heights.corner_m[0]) / heights.cell_m + 0.5).astype(int)
    j = np.floor((y - heights.corner_m[1]) / heights.cell_m + 0.5).astype(int)
    X, Y = heights.heights_m.shape
    inside = (i >= 0) & (j >= 0) & (i < X) & (j < Y)
    found = np.full(np.shape(x), np.inf)
    found[inside] = heights.heights_m[i[inside], j[inside]]
    return found


def in_jaws(heights, point, angle, along, across):
    """Heights at places in the axes of the jaws about a point."""
    c, s = np.cos(angle), np.sin(angle)
    return over(heights, point[0] + c * along - s * across, point[1] + s * along + c * across)


def surroundings(heights, point):
    """Share of rises, longest and shortest chord."""
    turns = np.arange(16) * np.pi / 8
    reach, rises = np.full(16, 0.120), np.zeros(16)
    for n, turn in enumerate(turns):
        way = np.arange(1, 31) * 0.004
        seen = np.append(point[2], over(heights, point[0] + way * np.cos(turn), point[1] + way * np.sin(turn)))
        with np.errstate(invalid="ignore"):
            jumps = np.flatnonzero(~(np.abs(np.diff(seen)) <= 0.008))
        if len(jumps):
            reach[n], rises[n] = (jumps[0] + 0.5) * 0.004, seen[jumps[0] + 1] > seen[jumps[0]]
    chords = reach[:8] + reach[8:]
    return rises.mean(), chords.max(), chords.min()


def palm_top(heights, point, angle):
    """Highest thing known under the palm."""
    along, across = np.meshgrid(np.arange(-5, 6) * 0.0125, np.arange(-2, 3) * 0.0125)
    seen = in_jaws(heights, point, angle, along, across)
    return seen[np.isfinite(seen)].max()


def closing(heights, point, angle, depth):
    """Width and the ten numbers; None where there is no such grasp."""
    tip, steps = point[2] - depth, np.arange(25) * STEP
    lines = np.array([[in_jaws(heights, point, angle, sign * steps, t) for t in LINES] for sign in (1, -1)])
    falls = np.where((below := lines < tip + 0.002).any(axis=2), below.argmax(axis=2), 25)
    ends, middle = (falls - 0.5) * STEP, falls[:, 2]
    reach = ends.max(axis=1)
    width = reach.sum()
    if middle.min() < 1 or middle.max() * STEP > OPENING / 2 or abs(np.diff(middle)[0]) * STEP > ROOM + 1e-12:
        return None

    def under(half, rows):
        first, last = int(np.ceil(half / STEP - 1e-6)), int(np.ceil((half + THICK) / STEP - 1e-6))
        return lines[:, rows, first : min(last, 24) + 1].max()

    if tip - under(min((middle.sum() - 1) * STEP + ROOM, OPENING) / 2, [2]) <= -0.015:
        return None
    half = min(width + ROOM, OPENING) / 2
    skew = max(skewness(side) for side in falls)
    palm = np.clip((tip + PALM - palm_top(heights, point, angle)) / 0.01, -1, 1)
    if reach.max() > half or skew > CONE or tip - under(half, range(5)) <= -0.015 or palm <= -0.5:
        return None
    rim = [lines[side, 2, max(middle[side] - 2, 0)] for side in (0, 1)]
    edge = [lines[side, 2, middle[side] - 1] for side in (0, 1)]
    foot = [lines[side, 2, middle[side]] for side in (0, 1)]
    rises, _, _ = surroundings(heights, point)
    numbers = [
        min((tip - under(half, range(5))) / 0.005, 1.0),
        skew / CONE,
        min((ends[side] > reach[side] - 0.005).mean() for side in (0, 1)),
        min(*(max(r, e) - tip for r, e in zip(rim, edge, strict=True)), 0.01) / 0.01,
        min(*(r - f for r, f in zip(rim, foot, strict=True)), 0.01) / 0.01,
        width / OPENING,
        abs(reach[0] - reach[1]) / 2 / 0.01,
        max(unseen(heights, point, angle, half)),
        rises,
        palm,
    ]
    return width, np.array(numbers)


def unseen(heights, point, angle, half):
    """Share of the ground under the left and under the right finger that no pixel showed."""
    first, last = int(np.ceil(half / STEP - 1e-6)), int(np.ceil((half + THICK) / STEP - 1e-6))
    steps = np.arange(first, min(last, 24) + 1) * STEP
    shown = HeightMap(heights.corner_m, heights.cell_m, np.where(heights.seen, 0.0, np.inf), heights.seen)
    return [np.isinf([in_jaws(shown, point, angle, sign * steps, t) for t in LINES]).mean() for sign in (1, -1)]


def skewness(falls):
    """Angle of one side between the outermost lines that it is on."""
    on = falls > 0
    first = 2 if not on[1] else (1 if not on[0] else 0)
    last = 2 if not on[3] else (3 if not on[4] else 4)
    return abs(np.arctan2((falls[last] - falls[first]) * STEP, (last - first) * 0.005)) if last > first else 0.0


def pinching(heights, point, angle):
    """The six numbers, or None where the surface is uneven."""
    steps = np.arange(12) * STEP
    part = np.array([[in_jaws(heights, point, angle, sign * steps, t) for t in LINES] for sign in (1, -1)])
    palm = np.clip((point[2] - 0.006 + PALM - palm_top(heights, point, angle)) / 0.01, -1, 1)
    if not np.ptp(part) < 0.012 or palm <= -0.5:
        return None
    tops = part[:, :, 6:].max(axis=(1, 2))
    rises, longest, shortest = surroundings(heights, point)
    return np.array([np.ptp(part) / 0.01, abs(tops[0] - tops[1]) / 0.01, longest / 0.2, shortest / 0.15, rises, palm])


def best(heights, point, quality):
    """Log-odds, angle, width, depth and kind of the best grasps at a point, more than one where equally good."""
    found = []
    for angle in np.arange(quality.angles) * np.pi / quality.angles:
        numbers = pinching(heights, point, angle)
        if numbers is not None:
            log_odds = numbers @ quality.pinching[:-1] + quality.pinching[-1]
            found.append((log_odds, angle, 0.010, min(0.006, point[2] - LOWEST), 2))
        for depth in dict.fromkeys(min(wished, point[2] - LOWEST) for wished in quality.depths_m):
            closed = closing(heights, point, angle, depth) if depth >= 0.006 else None
            if closed is not None:
                log_odds = closed[1] @ quality.closing[:-1] + quality.closing[-1]
                found.append((log_odds, angle, closed[0], depth, 1))
    return [grasp for grasp in found if grasp[0] > max(row[0] for row in found) - 1e-9]
