"""The grasp map of a depth image of 320 x 180 pixels, beside what one would write with numpy.

The peer knows the same rules and gives the same answer. It takes all pixels at once: for each angle the heights on all
lines as one array, for each depth the sides by `argmax` along it. It fills the height map with the same compiled code.

    OMP_NUM_THREADS=1 python -m benchmarks.bench_grasp_map [--fast]
"""

import sys
from dataclasses import replace

import numpy as np

from benchmarks.bench_mapping import camera
from benchmarks.timing import Timing, best_of, show
from planners.grasp_quality import AntipodalQuality
from planners.height_map import HeightMap, height_map
from rfcompass.arrays import FloatArray
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView

STEP_M, LINES_M, STEPS = 0.0025, np.array([-0.010, -0.005, 0.0, 0.005, 0.010]), 25
SHAPE = (180, 320)


def boxes(count: int, seed: int) -> list[tuple[float, float, float, float, float, float]]:
    """Upright boxes: x, y, yaw, half edges, height [m, rad]."""
    rng = np.random.default_rng(seed)
    low, high = [-0.25, -0.12, 0.0, 0.015, 0.015, 0.02], [0.25, 0.12, np.pi, 0.055, 0.035, 0.10]
    return [tuple(rng.uniform(low, high)) for _ in range(count)]


def tops_m(things: list[tuple[float, float, float, float, float, float]], x: FloatArray, y: FloatArray) -> FloatArray:
    """Height of the highest box over each point, 0 for the table."""
    top_m = np.zeros(x.shape)
    for a, b, yaw, long, wide, height in things:
        c, s = np.cos(yaw), np.sin(yaw)
        inside = (np.abs(c * (x - a) + s * (y - b)) < long) & (np.abs(c * (y - b) - s * (x - a)) < wide)
        top_m = np.where(inside, np.maximum(top_m, height), top_m)
    return top_m


def depth_view(count: int = 30, seed: int = 0) -> DepthView:
    """A heap of boxes that stand in each other, from 0.7 m straight above; each ray in steps of 1 mm."""
    T, focal = camera(0.0, 0.0), SHAPE[1] / 2 / np.tan(np.radians(32.5))
    K = np.array([[focal, 0, (SHAPE[1] - 1) / 2], [0, focal, (SHAPE[0] - 1) / 2], [0, 0, 1]])
    v, u = np.indices(SHAPE)
    depth, things = np.full(SHAPE, T[2, 3]), boxes(count, seed)
    for z in np.arange(0.0, 0.1, 0.001):  # upwards: what is higher overwrites
        t = T[2, 3] - z
        met = tops_m(things, (u - K[0, 2]) / focal * t, -(v - K[1, 2]) / focal * t) >= z
        depth = np.where(met, t, depth)
    return DepthView(depth, K, T)


def over(heights: HeightMap, x: FloatArray, y: FloatArray) -> FloatArray:
    """Heights over many points."""
    i = np.floor((x - heights.corner_m[0]) / heights.cell_m + 0.5).astype(int)
    j = np.floor((y - heights.corner_m[1]) / heights.cell_m + 0.5).astype(int)
    X, Y = heights.heights_m.shape
    inside = (i >= 0) & (j >= 0) & (i < X) & (j < Y)
    return np.where(inside, heights.heights_m[np.clip(i, 0, X - 1), np.clip(j, 0, Y - 1)], np.inf)


def jaw_heights(heights: HeightMap, p: FloatArray, angle: float, along: FloatArray, across: FloatArray) -> FloatArray:
    """Heights at places in the axes of the jaws about each point (N, 3); (N, *places)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = c * along - s * across, s * along + c * across
    shape = (len(p), *[1] * x.ndim)
    return over(heights, p[:, 0].reshape(shape) + x, p[:, 1].reshape(shape) + y)


def surroundings(heights: HeightMap, p: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Length of the surface in 16 directions, and whether it ends in a rise, (N, 16) each."""
    turns, way = np.arange(16) * np.pi / 8, np.arange(1, 31) * 0.004
    seen = jaw_heights(heights, p, 0.0, np.outer(np.cos(turns), way), np.outer(np.sin(turns), way))
    seen = np.concatenate([np.broadcast_to(p[:, 2, None, None], (len(p), 16, 1)), seen], axis=2)
    with np.errstate(invalid="ignore"):
        jumps = ~(np.abs(np.diff(seen)) <= 0.008)
    first, ends = jumps.argmax(axis=2), jumps.any(axis=2)
    before, after = (np.take_along_axis(seen, (first + n)[..., None], axis=2)[..., 0] for n in (0, 1))
    return np.where(ends, (first + 0.5) * 0.004, 0.120), ends & (after > before)


def numpy_map(view: DepthView, quality: AntipodalQuality) -> FloatArray:
    """Log-odds of the best grasp at each pixel."""
    image_m = points_image(view)
    standing = image_m[..., 2] > quality.standing_m
    p, heights = image_m[standing], height_map(view, standing, quality.cell_m)
    best = np.full(len(p), -np.inf)
    shown = replace(heights, heights_m=np.where(heights.seen, 0.0, np.inf))
    rays, rises = surroundings(heights, p)
    chords, steps = rays[:, :8] + rays[:, 8:], np.arange(STEPS) * STEP_M
    along = np.array([steps, -steps])[:, None, :] + np.zeros((2, 5, STEPS))
    for angle in np.arange(quality.angles) * np.pi / quality.angles:
        lines = jaw_heights(heights, p, angle, along, LINES_M[:, None] + np.zeros((2, 5, STEPS)))
        palm = jaw_heights(heights, p, angle, *np.meshgrid(np.arange(-5, 6) * 0.0125, np.arange(-2, 3) * 0.0125))
        top = np.where(np.isfinite(palm), palm, -np.inf).max(axis=(1, 2))
        around = np.stack([rises.mean(axis=1), chords.max(axis=1), chords.min(axis=1), top])
        hidden = np.isinf(jaw_heights(shown, p, angle, along, LINES_M[:, None] + np.zeros((2, 5, STEPS))))
        best = np.maximum(best, pinches(p, lines, around, quality))
        for wished in quality.depths_m:
            best = np.maximum(best, closings(p, lines, hidden, around, wished, quality))
    log_odds = np.full(standing.shape, -np.inf)
    log_odds[standing] = best
    return log_odds


def pinches(p: FloatArray, lines: FloatArray, around: FloatArray, quality: AntipodalQuality) -> FloatArray:
    """Log-odds of pinches at one angle, (N,)."""
    part = lines[..., :12]
    with np.errstate(invalid="ignore"):
        uneven = part.max(axis=(1, 2, 3)) - part.min(axis=(1, 2, 3))
        tops = part[..., 6:].max(axis=(2, 3))
        tilt = np.abs(tops[:, 0] - tops[:, 1])
    palm = np.clip((p[:, 2] - 0.006 + quality.jaws.palm_m - around[3]) / 0.01, -1, 1)
    numbers = [uneven / 0.01, tilt / 0.01, around[1] / 0.2, around[2] / 0.15, around[0], palm]
    with np.errstate(invalid="ignore"):
        log_odds = np.stack(numbers, axis=-1) @ quality.pinching[:-1] + quality.pinching[-1]
        return np.where((uneven < 0.012) & (palm > -0.5), log_odds, -np.inf)


def closings(
    p: FloatArray,
    lines: FloatArray,
    hidden: FloatArray,
    around: FloatArray,
    wished: float,
    quality: AntipodalQuality,
) -> FloatArray:
    """Log-odds of closings at one angle and depth, (N,)."""
    jaws, cone = quality.jaws, np.arctan(quality.friction)
    depth = np.minimum(wished, p[:, 2] - jaws.above_table_m)
    tip = p[:, 2] - depth
    below = lines < tip[:, None, None, None] + 0.002
    falls = np.where(below.any(axis=3), below.argmax(axis=3), STEPS)
    middle, ends = falls[:, :, 2], (falls - 0.5) * STEP_M
    reach = ends.max(axis=2)
    width = reach.sum(axis=1)
    half = np.minimum(width + jaws.room_m, jaws.opening_m) / 2
    of_middle = np.minimum((middle.sum(axis=1) - 1) * STEP_M + jaws.room_m, jaws.opening_m) / 2
    under, under_middle = (
        under_fingers(lines, half, jaws.thickness_m),
        under_fingers(lines[:, :, 2:3], of_middle, 0.012),
    )
    skew = np.maximum(skewness(falls[:, 0]), skewness(falls[:, 1]))
    fine = (depth >= 0.006) & (middle.min(axis=1) >= 1) & (middle.max(axis=1) * STEP_M <= jaws.opening_m / 2)
    fine &= (np.abs(np.diff(middle)[:, 0]) * STEP_M <= jaws.room_m) & (reach.max(axis=1) <= half) & (skew <= cone)
    palm = np.clip((tip + jaws.palm_m - around[3]) / 0.01, -1, 1)
    fine &= (palm > -0.5) & (tip - under > -0.015) & (tip - under_middle > -0.015)
    rim, edge, foot = (
        np.take_along_axis(lines[:, :, 2], np.clip(middle - n, 0, STEPS - 1)[..., None], axis=2)[..., 0]
        for n in (2, 1, 0)
    )
    numbers = [
        np.minimum((tip - under) / 0.005, 1.0),
        skew / cone,
        (ends > reach[:, :, None] - 0.005).mean(axis=2).min(axis=1),
        np.minimum((np.maximum(rim, edge) - tip[:, None]).min(axis=1), 0.01) / 0.01,
        np.minimum((rim - foot).min(axis=1), 0.01) / 0.01,
        width / jaws.opening_m,
        np.abs(reach[:, 0] - reach[:, 1]) / 2 / 0.01,
        unseen(hidden, half, jaws.thickness_m),
        around[0],
        palm,
    ]
    with np.errstate(invalid="ignore"):
        log_odds = np.stack(numbers, axis=-1) @ quality.closing[:-1] + quality.closing[-1]
        return np.where(fine, log_odds, -np.inf)


def under_fingers(lines: FloatArray, half: FloatArray, thickness_m: float) -> FloatArray:
    """Highest thing where the fingers come down, (N,)."""
    there = finger_steps(half, thickness_m)
    return np.where(there[:, None, None], lines, -np.inf).max(axis=(1, 2, 3))


def unseen(hidden: FloatArray, half: FloatArray, thickness_m: float) -> FloatArray:
    """Share of the ground under a finger that no pixel showed, of the side with more, (N,)."""
    there = finger_steps(half, thickness_m)
    counts = (hidden & there[:, None, None]).sum(axis=(2, 3))
    return counts.max(axis=1) / np.maximum(5 * there.sum(axis=1), 1)


def finger_steps(half: FloatArray, thickness_m: float) -> FloatArray:
    """Which steps a finger covers, (N, 25)."""
    first, last = np.ceil(half / STEP_M - 1e-6), np.ceil((half + thickness_m) / STEP_M - 1e-6)
    k = np.arange(STEPS)
    return (k >= first[:, None]) & (k <= np.minimum(last, STEPS - 1)[:, None])


def skewness(falls: FloatArray) -> FloatArray:
    """Angle of one side on each pixel's lines (N, 5), between the last ones that it is on."""
    on = falls > 0
    first = np.where(on[:, 1], np.where(on[:, 0], 0, 1), 2)
    last = np.where(on[:, 3], np.where(on[:, 4], 4, 3), 2)
    rows = np.arange(len(falls))
    run, apart = (falls[rows, last] - falls[rows, first]) * STEP_M, (last - first) * 0.005
    return np.where(apart > 0, np.abs(np.arctan(run / np.maximum(apart, 1e-9))), 0.0)


def run(fast: bool = False) -> list[Timing]:
    """Time both on one image."""
    view, quality = depth_view(), AntipodalQuality()
    repeats = 1 if fast else 5
    ours = quality.evidence(view)  # compiles
    ours_s, ours = best_of(repeats, lambda: quality.evidence(view))
    peer_s, theirs = best_of(min(repeats, 2), lambda: numpy_map(view, quality))
    same = np.isfinite(theirs) == np.isfinite(ours.log_odds)
    both = np.isfinite(theirs) & np.isfinite(ours.log_odds)
    differ = np.abs(theirs[both] - ours.log_odds[both]).max()
    standing = int((points_image(view)[..., 2] > quality.standing_m).sum())
    print(f"{standing} of {view.depth_m.size} pixels stand above the table; the same pixels have a grasp: {same.all()}")
    return [
        Timing("grasp map, 8 angles, 4 depths, 320 x 180", ours_s, "numpy, all pixels at once", peer_s, float(differ))
    ]


if __name__ == "__main__":
    show(run("--fast" in sys.argv))
