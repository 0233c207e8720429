"""Where the base must stand so that the arm can grasp a part whose pose is only estimated.

A grasp of the part is a tool pose over it: at an offset (u, v) in the part frame, straight down, the jaws closing along
the heading θ + β of the part's pose (x, y, θ). With the base at (R_b, t_b), the map of the arm is asked for the tool at

    p = R_bᵀ ((x, y) + R(θ)(u, v) - t_b),    closing heading θ + β - θ_b  (modulo π, as the jaws are alike)

and the share of the estimate's samples for which it says yes is the probability that the grasp is in reach. Candidates
for the base come from the map itself, one for each of its voxels and headings, set under the mean pose: inverse map.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numba
import numpy as np

from planners.task_map import TaskMap
from rfcompass.arrays import BoolArray, FloatArray, IntArray, read_only
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import QuickCollisions
from rfcompass.types.configuration import Configuration
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.grasps import Failure
from rfcompass.types.record import Record

# Ours. Samples that candidates are compared by; a probability that must be lost to save a metre of driving, and a
# radian of turning.
_SAMPLES = 200
_PER_M, _PER_RAD = 0.02, 0.01


@dataclass(frozen=True, slots=True)
class PartGrasp(Record):
    """A grasp from above, in the part frame.

    Attributes:
        offset_m: Tool over the part's centre, u and v [m], shape (2,).
        closing_rad: Heading β of the jaws against the part's x axis [rad]; π/2 closes across its long side.
        height_m: Height of the tool over the floor [m].
    """

    offset_m: FloatArray
    closing_rad: float
    height_m: float

    def __post_init__(self) -> None:
        """Freeze the offset."""
        object.__setattr__(self, "offset_m", read_only(self.offset_m, "PartGrasp.offset_m", (2,)))


@dataclass(frozen=True, slots=True)
class BasePlacement(Record):
    """Where to drive.

    Attributes:
        base: Pose to drive to, in the present base frame.
        probability: Share of the estimate for which the grasp is then in reach.
        grasp: Grasp that it is meant for.
        travel_m: Distance from the present base [m].
        looked_at: Candidates that were compared.
        blocked: Better candidates at which the robot would have touched something.
    """

    base: Pose2
    probability: float
    grasp: PartGrasp
    travel_m: float
    looked_at: int
    blocked: int


def inverse_map(task_map: TaskMap, grasp: PartGrasp) -> FloatArray:
    """Poses x, y, θ of the base in the part frame from which the arm can do a grasp [m, m, rad], shape (C, 3).

    One for each voxel of the map's layer at the grasp's height, for each heading, either way round.
    """
    layer = round(float((grasp.height_m - task_map.origin_m[2]) / task_map.spacing_m))
    if not 0 <= layer < task_map.reached.shape[2]:
        return np.zeros((0, 3))
    x, y, d = np.nonzero(task_map.reached[:, :, layer])
    points_m = task_map.centres_m(np.column_stack([x, y, np.full(len(x), layer)]))[:, :2]
    headings = headings_of(task_map)[d]
    turns = np.concatenate([grasp.closing_rad - headings, grasp.closing_rad - headings + np.pi])
    turns = (turns + np.pi) % (2 * np.pi) - np.pi
    c, s, both = np.cos(turns), np.sin(turns), np.tile(points_m, (2, 1))
    turned = np.column_stack([c * both[:, 0] - s * both[:, 1], s * both[:, 0] + c * both[:, 1]])
    return np.column_stack([grasp.offset_m - turned, turns])


def best_base_pose(
    estimate: PartEstimate,
    task_map: TaskMap,
    grasps: list[PartGrasp],
    *,
    rng: np.random.Generator,
    posture: Configuration | None = None,
    checker: QuickCollisions | None = None,
) -> BasePlacement | Failure:
    """Find where the base should stand: most likely in reach, not far away, touching nothing.

    Args:
        estimate: Where the part is, in the present base frame; its samples, or draws of its covariance, or the point.
        task_map: What the arm can do; its directions point straight down.
        grasps: Grasps to choose from.
        rng: Thins the samples, or draws them.
        posture: Joints while driving; needed with a checker.
        checker: Robot and obstacles in the present base frame.

    Raises:
        ValueError: If a direction of the map does not point straight down.

    Returns:
        A placement; or a failure: `"orientation_unknown"`, `"unreachable"` if no pose of the base reaches any sample,
        or `"scene_collision"` if the robot would touch something at every pose that does.
    """
    if (task_map.directions.approach[:, 2] > -1 + 1e-9).any():
        raise ValueError("a direction of the map does not point straight down")
    if estimate.theta_rad is None:
        return Failure("orientation_unknown", "the estimate has no orientation, so the jaws have no direction to close")
    samples, rows = _draws(estimate, rng), []
    x_m, y_m = estimate.centre_m
    mean = Pose2(x_m, y_m, estimate.theta_rad)
    for g, grasp in enumerate(grasps):
        bases = _in_front_of(mean, inverse_map(task_map, grasp))
        if len(bases):
            share = shares(task_map, grasp, samples, bases)
            rows.append(np.column_stack([bases, share, np.full(len(bases), g)]))
    found = np.concatenate(rows) if rows else np.zeros((0, 5))
    found = found[found[:, 3] > 0]
    if not len(found):
        message = f"no pose of the base brings any of {len(grasps)} grasps into reach"
        return Failure("unreachable", message, (("grasps", float(len(grasps))),))
    return _first_free(found, grasps, posture, checker)


def _first_free(
    found: FloatArray, grasps: list[PartGrasp], posture: Configuration | None, checker: QuickCollisions | None
) -> BasePlacement | Failure:
    """The best candidate at which the robot touches nothing; candidates x, y, θ, share, grasp (C, 5)."""
    for blocked, i in enumerate(_by_merit(found)):
        x, y, theta, share, g = found[i]
        base = Pose2(x, y, theta)
        if checker is None or posture is None or not checker.collides(Configuration(posture.joints, base)):
            return BasePlacement(base, float(share), grasps[int(g)], float(np.hypot(x, y)), len(found), blocked)
    message = f"the robot would touch something at each of {len(found)} places from which it could grasp"
    return Failure("scene_collision", message, (("places", float(len(found))),))


def _by_merit(found: FloatArray) -> Iterator[int]:
    merit = found[:, 3] - _PER_M * np.hypot(found[:, 0], found[:, 1]) - _PER_RAD * np.abs(found[:, 2])
    yield from (int(i) for i in np.argsort(-merit, kind="stable"))


def headings_of(task_map: TaskMap) -> FloatArray:
    """Headings of the jaws of a map's directions [rad], shape (D,)."""
    closing = task_map.directions.closing
    return np.asarray(np.arctan2(closing[:, 1], closing[:, 0]))


def _draws(estimate: PartEstimate, rng: np.random.Generator) -> FloatArray:
    """Poses x, y, θ of the part, (S, 3)."""
    mean = np.array([*estimate.centre_m, estimate.theta_rad])
    if len(estimate.samples):
        chosen = rng.choice(len(estimate.samples), min(_SAMPLES, len(estimate.samples)), replace=False)
        return np.asarray(estimate.samples[chosen])
    if estimate.covariance is not None:
        return np.asarray(rng.multivariate_normal(mean, estimate.covariance, _SAMPLES))
    return mean[None]


def _in_front_of(part: Pose2, bases: FloatArray) -> FloatArray:
    """Poses given in the part frame, in the frame of the part's pose, (C, 3)."""
    turns = (bases[:, 2] + part.theta_rad + np.pi) % (2 * np.pi) - np.pi
    return np.column_stack([part.apply(bases[:, :2]), turns])


def shares(task_map: TaskMap, grasp: PartGrasp, samples: FloatArray, bases: FloatArray) -> FloatArray:
    """Share of the samples for which a grasp is in reach, for each base pose.

    Args:
        task_map: What the arm can do.
        grasp: The grasp.
        samples: Poses x, y, θ of the part [m, m, rad], shape (S, 3).
        bases: Poses x, y, θ of the base in the same frame, shape (C, 3).

    Returns:
        Shares, shape (C,).
    """
    c, s = np.cos(samples[:, 2]), np.sin(samples[:, 2])
    u, v = grasp.offset_m
    tools = np.column_stack([samples[:, 0] + c * u - s * v, samples[:, 1] + s * u + c * v, samples[:, 2]])
    layer = (grasp.height_m - task_map.origin_m[2]) / task_map.spacing_m
    low, high = floor_and_ceil(layer)
    if low < 0 or high >= task_map.reached.shape[2]:
        return np.zeros(len(bases))
    both = task_map.reached[:, :, low] & task_map.reached[:, :, high]
    tools[:, 2] += grasp.closing_rad
    grid = np.array([task_map.origin_m[0], task_map.origin_m[1], task_map.spacing_m])
    return np.asarray(_count(both, grid, headings_of(task_map), tools, bases) / len(samples))


@numba.njit(cache=True)
def floor_and_ceil(place: float) -> tuple[int, int]:
    """Voxels on either side of a place; the same one twice on a voxel's centre."""
    return int(np.floor(place + 1e-9)), int(np.ceil(place - 1e-9))


@numba.njit(cache=True)
def _count(
    reached: BoolArray, grid: FloatArray, headings: FloatArray, tools: FloatArray, bases: FloatArray
) -> IntArray:
    """How many tools x, y, heading (S, 3) are in reach of each base (C, 3), by one layer of a map (X, Y, D)."""
    X, Y, _ = reached.shape
    counts = np.zeros(len(bases), dtype=np.int64)
    for i in range(len(bases)):
        c, s = np.cos(bases[i, 2]), np.sin(bases[i, 2])
        for k in range(len(tools)):
            dx, dy = tools[k, 0] - bases[i, 0], tools[k, 1] - bases[i, 1]
            x0, x1 = floor_and_ceil((c * dx + s * dy - grid[0]) / grid[2])
            y0, y1 = floor_and_ceil((c * dy - s * dx - grid[1]) / grid[2])
            if x0 < 0 or y0 < 0 or x1 >= X or y1 >= Y:
                continue
            d = _nearest(headings, tools[k, 2] - bases[i, 2])
            if reached[x0, y0, d] and reached[x0, y1, d] and reached[x1, y0, d] and reached[x1, y1, d]:
                counts[i] += 1
    return counts


@numba.njit(cache=True)
def _nearest(headings: FloatArray, heading: float) -> int:
    """Index of the heading nearest to one, modulo half a turn."""
    best, least = 0, np.inf
    for d in range(len(headings)):
        off = (heading - headings[d]) / np.pi
        off = abs(off - np.round(off))
        if off < least:
            best, least = d, off
    return best
