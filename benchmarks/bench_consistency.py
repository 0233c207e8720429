"""The certified pose that meets the most comparisons: how long the answer takes, how often and when it is proven.

Nine anchors at mixed heights, three stops, one, two or four part tags: 108, 216 or 432 comparisons, with 10 % of
them flipped, or made from distances with 5 or 10 % of noise. All times are CPU times on one thread. "Answer" is the
whole of `ConsistencyLocalizer.fit`: rows, search, region and outliers. "Proof" is the search alone; it is proven when
no pose can meet more than the answer. The seeds start at 5000; those below were used while the search was made.

Beside it what a user would write: HiGHS through `scipy.optimize.milp` with one binary unknown for each comparison,
|(cos θ, sin θ)| <= 1 as a polygon of 64 sides, stopped after ten seconds; and numpy on a grid of 10 cm and 5 degrees.
"Differ" is the largest difference of the numbers of comparisons met, relative to ours.

Run `python -m benchmarks.bench_consistency`; about two minutes, or some seconds with `--fast`.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp

from benchmarks.bench_partition import PART_M
from benchmarks.timing import Timing, show, times_of
from rfcompass.arrays import FloatArray
from rfcompass.geometry import Pose2
from rfcompass.localization.best_cells import best_cells, signed_distances
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.comparing import compare_proximities
from rfcompass.localization.consistency import ConsistencyLocalizer
from rfcompass.localization.problem import PartitionProblem, build_partition
from rfcompass.types.comparisons import Comparisons

Problem = TypeVar("Problem")
Answer = TypeVar("Answer")

FIRST_SEED = 5000
MARGIN_M = 1e-3
LEAF = np.array([1.25e-6, 1.25e-6, 6.25e-6])
TAGS_M = {1: np.array([[0.0, 0.0, 0.05]]), 2: PART_M[[0, 3]], 4: PART_M}


@dataclass(frozen=True, slots=True)
class Certificate:
    """One line of the table of certificates; times in seconds.

    Attributes:
        name: Size and kind of the problems.
        answer_s: CPU time of each answer, shape (P,).
        proof_s: CPU time of each search, shape (P,).
        gap: Comparisons left unproven, shape (P,).
    """

    name: str
    answer_s: FloatArray
    proof_s: FloatArray
    gap: FloatArray

    def cells(self) -> tuple[str, ...]:
        """Name; median and 95 % of the answer and of the proof; shares answered, proven, and proven in time."""
        times = [f"{np.percentile(t, q) * 1e3:.1f}" for t in (self.answer_s, self.proof_s) for q in (50, 95)]
        proven = self.gap == 0
        shares = (self.answer_s <= 0.01, proven & (self.proof_s <= 0.1), proven)
        return self.name, *times, *(f"{share.mean():.1%}" for share in shares)


def certificates(fast: bool = False) -> list[Certificate]:
    """Answer and prove all problems."""
    kinds = [("10 % flipped", 0.1, 0.0), ("5 % noise", 0.0, 0.05), ("10 % noise", 0.0, 0.1)]
    return [
        _certify(f"K = {K}, {name}", scenes)
        for K in (1, 2, 4)
        for name, flips, noise in kinds
        for scenes in [[_random_stops(seed, K, flips, noise) for seed in _seeds(10 if fast else 200)]]
    ]


def budgets(fast: bool = False) -> list[tuple[str, ...]]:
    """What a budget of boxes buys on 432 comparisons of distances with 10 % of noise."""
    scenes = [_random_stops(seed, 4, 0.0, 0.1) for seed in _seeds(10 if fast else 200)]
    full = [ConsistencyLocalizer().fit(stops) for stops in scenes]
    lines = []
    for boxes in (250, 500, 1000, 2000):
        times, fits = times_of(ConsistencyLocalizer(max_boxes=boxes).fit, scenes)
        short = [int(a.diagnostics["best"]) - int(b.diagnostics["best"]) for a, b in zip(full, fits, strict=True)]
        gap, median, late = [fit.gap for fit in fits], np.median(times) * 1e3, np.percentile(times, 95) * 1e3
        lines.append((str(boxes), f"{median:.1f}", f"{late:.1f}", f"{np.mean(short):.2f}", f"{np.mean(gap):.2f}"))
    return lines


def run(fast: bool = False) -> list[Timing]:
    """Our search beside HiGHS and beside a grid."""
    few = 2 if fast else 20
    lines = [_beside(1, few, "HiGHS milp", _milp), _beside(1, few, "numpy grid", _grid)]
    lines += [_beside(2, 1 if fast else 5, "numpy grid", _grid), _beside(4, 1 if fast else 5, "numpy grid", _grid)]
    return (
        lines if fast else [*lines, _beside(2, 5, "HiGHS milp, 10 s", _milp), _beside(4, 3, "HiGHS milp, 10 s", _milp)]
    )


def _certify(name: str, scenes: Sequence[Sequence[ComparedStop]]) -> Certificate:
    answer_s, fits = times_of(ConsistencyLocalizer().fit, scenes)
    proof_s, _ = times_of(_search, [build_partition(stops, transitive_reduction=False) for stops in scenes])
    rows = sum(len(stop.comparisons) for stop in scenes[0])
    return Certificate(f"{rows} rows, {name}", answer_s, proof_s, np.array([float(fit.gap or 0) for fit in fits]))


def _beside(K: int, count: int, peer: str, solve: Callable[[PartitionProblem], int]) -> Timing:
    scenes = [_random_stops(seed, K, 0.1, 0.0) for seed in _seeds(count)]
    problems = [build_partition(stops, transitive_reduction=False) for stops in scenes]
    ours_s, ours = times_of(_search, problems)
    theirs_s, theirs = times_of(solve, problems)
    differ = np.abs(np.array(ours) - np.array(theirs)).max() / max(ours)
    rows = len(problems[0].rows.b)
    return Timing(
        f"consistency, proven, {rows} rows, 10 % flipped",
        float(np.median(ours_s)),
        f"{peer}, x {count}",
        float(np.median(theirs_s)),
        differ,
    )


def _search(problem: PartitionProblem) -> int:
    return best_cells(problem, MARGIN_M, LEAF, 400_000).met


def _milp(problem: PartitionProblem) -> int:
    """As many rows as possible, each switched off by a binary unknown."""
    n, G = problem.unknowns, signed_distances(problem, MARGIN_M)
    A, b, M = G[:, :n], G[:, 4], len(G)
    low = np.concatenate([problem.bounds_m[:, 0], np.full(n - 2, -1.0)])
    high = np.concatenate([problem.bounds_m[:, 1], np.ones(n - 2)])
    slack = np.maximum(np.maximum(A * low, A * high).sum(axis=1) - b, 0.0)
    constraints = [LinearConstraint(np.hstack([A, -np.diag(slack)]), ub=b)]
    if n == 4:
        side = np.arange(64) * (2.0 * np.pi / 64)
        sides = np.hstack([np.zeros((64, 2)), np.column_stack([np.cos(side), np.sin(side)]), np.zeros((64, M))])
        constraints.append(LinearConstraint(sides, ub=1.0))
    answer = milp(
        np.concatenate([np.zeros(n), np.ones(M)]), constraints=constraints,
        integrality=np.concatenate([np.zeros(n), np.ones(M)]),
        bounds=Bounds(np.concatenate([low, np.zeros(M)]), np.concatenate([high, np.ones(M)])),
        options={"time_limit": 10.0},
    )  # fmt: skip
    return 0 if answer.x is None else M - round(answer.fun)


def _grid(problem: PartitionProblem) -> int:
    """The most rows that a pose of a grid meets."""
    n, G = problem.unknowns, signed_distances(problem, MARGIN_M).astype(np.float32)
    x, y = (np.arange(low, high, 0.1, dtype=np.float32) for low, high in problem.bounds_m)
    places = np.array(np.meshgrid(x, y)).reshape(2, -1).T @ G[:, :2].T - G[:, 4]
    turns = np.radians(np.arange(0.0, 360.0, 5.0, dtype=np.float32)) if n == 4 else np.zeros(1, dtype=np.float32)
    return max(int((places <= -G[:, 2] * np.cos(t) - G[:, 3] * np.sin(t)).sum(axis=1).max()) for t in turns)


def _seeds(count: int) -> Iterator[int]:
    return iter(range(FIRST_SEED, FIRST_SEED + count))


def _random_stops(seed: int, K: int, flips: float, noise: float) -> list[ComparedStop]:
    """Anchors within 1 m and 0.4 m height, the part within 0.5 m, three stops some decimetres apart."""
    rng, tags_m = np.random.default_rng(seed), TAGS_M[K]
    truth = Pose2(*rng.uniform(-0.5, 0.5, 2), rng.uniform(-np.pi, np.pi))
    stops = []
    for pose in [*(Pose2(*rng.uniform(-0.3, 0.3, 2), rng.uniform(-0.6, 0.6)) for _ in range(2)), Pose2()]:
        anchors_m = np.column_stack([rng.uniform(-0.5, 0.5, (9, 2)), rng.uniform(0.0, 0.4, 9)])
        m = np.linalg.norm((pose.inverse() @ truth).apply(tags_m)[:, None] - anchors_m[None], axis=2)
        c = compare_proximities(m * np.exp(noise * rng.normal(size=m.shape)))
        wrong = rng.uniform(size=len(c)) < flips
        nearer, farther = np.where(wrong, c.farther, c.nearer), np.where(wrong, c.nearer, c.farther)
        stops.append(ComparedStop(anchors_m, tags_m, Comparisons(c.target, nearer, farther, c.margin), pose))
    return stops


def main(argv: Sequence[str] | None = None) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fast", action="store_true", help="few problems, to see that it works")
    fast = parser.parse_args(argv).fast
    head = ("problems", "answer ms", "95 %", "proof ms", "95 %", "<= 10 ms", "in 100 ms", "proven")
    for row in (head, *(line.cells() for line in certificates(fast))):
        print("{:34s} {:>9s} {:>6s} {:>9s} {:>6s} {:>9s} {:>9s} {:>7s}".format(*row))
    print()
    for row in (("boxes kept", "answer ms", "95 %", "short by", "gap"), *budgets(fast)):
        print("{:>10s} {:>9s} {:>6s} {:>9s} {:>6s}".format(*row))
    print()
    show(run(fast))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
