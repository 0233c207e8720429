"""The posterior over the part's pose, whole, beside what a user would write with numpy and scipy.

Nine robot tags, four part tags, distances whose errors are biases of 1.3 cm for every tag and 4 mm of noise; one stop
(36 distances) and three stops (68 of anchors in different places). Ours is the whole of `PosteriorLocalizer.estimate`:
noise from the robot's own tags, map of every tag, search over (x, y, θ), region, 500 samples. The peers are given the
noise and where to look, a square of 40 cm, and find a mean or a best pose only:

- numpy grid: Student-4 likelihood of all distances on a grid of 1 cm and 3 degrees; the bias added to the noise;
- Metropolis: 32 walkers of 400 steps with the same likelihood, all walkers at once, first half thrown away;
- scipy: `least_squares` with a soft loss from eight orientations; no uncertainty at all.

CPU times on one thread, median over problems. "Differ" is the median distance of the centres [m].
Run `python -m benchmarks.bench_posterior`; about a minute, or some seconds with `--fast`.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from benchmarks.bench_partition import PART_M
from benchmarks.timing import Timing, median_of, show, times_of
from rfcompass.arrays import FloatArray
from rfcompass.geometry import Pose2
from rfcompass.localization import PosteriorLocalizer, measure_proximities
from rfcompass.types import Observation, ProximityMatrix, TagLayout, TagPositions

FIRST_SEED = 5000
BIAS_M, NOISE_M = 0.013, 0.004
ALPHA_M = 0.022  # what the fit finds on the robot's tags, and the bias, together
HALF_SQUARE_M = 0.2
HAND_M = np.array([[0.0, 0.06, 0.194], [0.0, -0.06, 0.194], [0.075, 0.0, 0.194], [-0.075, 0.0, 0.194]])
BASE_M = np.array([[0.3, 0.11, 0.062], [0.3, -0.11, 0.062], [0.1, 0.18, 0.1], [0.1, -0.18, 0.1], [-0.1, 0.0, 0.209]])
SWEEP = (Pose2(0.42, 0.0, 0.0), Pose2(0.34, -0.14, 1.0), Pose2(0.49, 0.14, 2.1))


@dataclass(frozen=True, slots=True)
class Problem:
    """Stops of a base that stands, and about where the part lies [m]."""

    stops: tuple[Observation, ...]
    near_m: FloatArray

    @property
    def anchors_m(self) -> FloatArray:
        """Anchors of all stops, shape (S N, 3)."""
        return np.vstack([stop.anchors.points_m for stop in self.stops])

    @property
    def distances_m(self) -> FloatArray:
        """Distances of all part tags to them, shape (K, S N)."""
        return np.hstack([measure_proximities(stop).m for stop in self.stops])


def run(fast: bool = False) -> list[Timing]:
    """Time one update, and three stops."""
    many, few = (10, 2) if fast else (200, 10)
    lines = []
    for M in (1, 3):
        problems = [random_problem(seed, M) for seed in range(FIRST_SEED, FIRST_SEED + many)]
        ours_s, ours = median_of(_ours, problems)
        for name, solve in (
            ("numpy grid", _grid),
            ("Metropolis", _metropolis),
            ("scipy least_squares", _least_squares),
        ):
            theirs_s, theirs = median_of(solve, problems[:few])
            differ = float(np.median(np.hypot(*(np.array(ours[:few]) - np.array(theirs)).T)))
            lines.append(
                Timing(f"posterior, {M} stop{'s' * (M > 1)}, x {many}", ours_s, f"{name}, x {few}", theirs_s, differ)
            )
    return lines


def late(fast: bool = False) -> list[str]:
    """How long the slowest tenth of our answers takes, for one, two and four part tags."""
    lines = []
    for K in (1, 2, 4):
        for M in (1, 3, 5):
            problems = [random_problem(seed, M, K) for seed in range(FIRST_SEED, FIRST_SEED + (10 if fast else 200))]
            times = times_of(_ours, problems)[0] * 1e3
            lines.append(
                f"K = {K}, {M} stops: median {np.median(times):5.1f} ms, 90 % {np.percentile(times, 90):5.1f} ms"
            )
    return lines


def _ours(problem: Problem) -> FloatArray:
    return PosteriorLocalizer().estimate(problem.stops).centre_m


def _log_likelihood(problem: Problem, poses: FloatArray) -> FloatArray:
    """Student-4 log likelihood of all distances at poses (x, y, θ), shape (P,)."""
    anchors_m, r_m, total = problem.anchors_m, problem.distances_m, np.zeros(len(poses))
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    for k, (px, py, pz) in enumerate(_points(len(r_m))):
        x, y = poses[:, 0] + c * px - s * py, poses[:, 1] + s * px + c * py
        for i, (ax, ay, az) in enumerate(anchors_m):
            d = np.sqrt((x - ax) ** 2 + (y - ay) ** 2 + (pz - az) ** 2)
            total -= 2.5 * np.log1p((r_m[k, i] - d) ** 2 / (4.0 * ALPHA_M**2))
    return total


def _grid(problem: Problem) -> FloatArray:
    off = np.arange(-HALF_SQUARE_M, HALF_SQUARE_M, 0.01)
    grids = np.meshgrid(problem.near_m[0] + off, problem.near_m[1] + off, np.radians(np.arange(0.0, 360.0, 3.0)))
    poses = np.column_stack([axis.ravel() for axis in grids])
    value = _log_likelihood(problem, poses)
    weight = np.exp(value - value.max())
    return np.asarray(weight @ poses[:, :2] / weight.sum())


def _metropolis(problem: Problem) -> FloatArray:
    rng = np.random.default_rng(0)
    walkers = np.column_stack([problem.near_m + 0.1 * rng.normal(size=(32, 2)), rng.uniform(-np.pi, np.pi, 32)])
    value, kept = _log_likelihood(problem, walkers), []
    for step in range(400):
        tried = walkers + rng.normal(size=walkers.shape) * [0.01, 0.01, 0.1]
        new = _log_likelihood(problem, tried)
        better = np.log(rng.uniform(size=32)) < new - value
        walkers, value = np.where(better[:, None], tried, walkers), np.where(better, new, value)
        if step >= 200:
            kept.append(walkers[value > value.max() - 12.0, :2])  # walkers that are stuck elsewhere do not count
    return np.asarray(np.vstack(kept).mean(axis=0))


def _least_squares(problem: Problem) -> FloatArray:
    points_m, anchors_m, r_m = _points(len(problem.distances_m)), problem.anchors_m, problem.distances_m

    def misses(pose: FloatArray) -> FloatArray:
        tags_m = Pose2(*pose).apply(points_m)
        return np.asarray((np.linalg.norm(tags_m[:, None] - anchors_m[None], axis=2) - r_m).ravel() / ALPHA_M)

    starts = [np.array([*problem.near_m, turn]) for turn in np.arange(8) * np.pi / 4]
    fits = [least_squares(misses, start, loss="soft_l1") for start in starts]
    return np.asarray(min(fits, key=lambda fit: fit.cost).x[:2])


def _points(K: int) -> FloatArray:
    return {1: np.array([[0.0, 0.0, 0.05]]), 2: PART_M[[0, 3]], 4: PART_M}[K]


def random_problem(seed: int, M: int, K: int = 4) -> Problem:
    """Every tag seems to be off its place, the part's always alike."""
    rng, points_m = np.random.default_rng(seed), _points(K)
    turn, radius = rng.uniform(-np.pi, np.pi), 0.25 * np.sqrt(rng.uniform())
    truth = Pose2(0.42 + radius * np.cos(turn), radius * np.sin(turn), rng.uniform(-np.pi, np.pi))
    flat = ((0, 0), (0, 1))
    tags_m = truth.apply(points_m) + np.pad(BIAS_M * rng.normal(size=(K, 2)), flat)
    base_m = BASE_M + np.pad(BIAS_M * rng.normal(size=(5, 2)), flat)
    epcs, names = tuple(f"p{k}" for k in range(K)), tuple(f"r{i}" for i in range(9))
    upright = np.tile([0.0, 0.0, 1.0], (K, 1))
    part = TagLayout("leg", epcs, ("part",) * K, points_m * [1.0, 1.0, 0.0], upright, ("part",) * K)
    stops = []
    for s, hand in enumerate(SWEEP[:M]):
        hand_m = hand.apply(HAND_M)
        seem_m = np.vstack([hand_m + np.pad(BIAS_M * rng.normal(size=(4, 2)), flat), base_m])
        m = np.linalg.norm(tags_m[:, None] - seem_m[None], axis=2) + NOISE_M * rng.normal(size=(K, 9))
        own = np.triu(np.linalg.norm(seem_m[:, None] - seem_m[None], axis=2) + NOISE_M * rng.normal(size=(9, 9)), 1)
        own = np.where(np.eye(9, dtype=bool), np.nan, np.abs(own + own.T))
        anchors = TagPositions("base", names, np.vstack([hand_m, BASE_M]))
        matrix = ProximityMatrix(epcs, names, np.abs(m), own, "sar_nearfield")
        stops.append(Observation(s, anchors, part, points_m[:, 2], proximity=matrix))
    return Problem(tuple(stops), truth.translation_m + 0.03 * rng.normal(size=2))


def main(argv: Sequence[str] | None = None) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fast", action="store_true", help="few problems, to see that it works")
    fast = parser.parse_args(argv).fast
    show(run(fast))
    print("\n".join(["", *late(fast)]))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
