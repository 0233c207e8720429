"""The partition solver beside cvxpy with Clarabel, in one run on one thread, on problems of 432 comparisons.

Nine anchors, four part tags, three stops, exact comparisons. Ours is timed on 1000 problems; cvxpy, which takes
tens of milliseconds for each, on the first few of them. All times are CPU times of one solve: the median. Rows
are built before the clock starts. The programs for cvxpy are written as a user would write them, with its default
tolerances; ours finds the largest ball on the way. "Differ" is the largest difference of [x0, y0, c, s] to the
centre that cvxpy finds; the program as printed, which minimises 0, has no centre to agree with.

Run `python -m benchmarks.bench_partition`; about half a minute, or a few seconds with `--fast`.
"""

import argparse
from collections.abc import Sequence

import cvxpy as cp
import numpy as np

from benchmarks.timing import Timing, median_of, show
from rfcompass.arrays import FloatArray
from rfcompass.geometry import Pose2
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.comparing import compare_proximities
from rfcompass.localization.partition_solver import solve_partition
from rfcompass.localization.problem import PartitionProblem, build_partition

PEER = f"cvxpy {cp.__version__} + Clarabel"
PART_M = np.array([[-0.2, 0.0, 0.05], [-0.2 / 3, 0.0, 0.05], [0.2 / 3, 0.0, 0.05], [0.2, 0.0, 0.05]])


def run(fast: bool = False) -> list[Timing]:
    """Solve all problems with all rows, and with those that others imply left out."""
    ours, theirs = (50, 2) if fast else (1000, 40)
    scenes = [_random_stops(np.random.default_rng(seed)) for seed in range(ours)]
    full = [build_partition(stops, transitive_reduction=False) for stops in scenes]
    reduced = [build_partition(stops) for stops in scenes]
    return [*_compare(full, theirs, "432 rows"), *_compare(reduced, theirs, "432 reduced to 96 rows")]


def _compare(problems: Sequence[PartitionProblem], theirs: int, size: str) -> list[Timing]:
    solve_partition(problems[0])  # compile
    ours_s, ours = median_of(lambda problem: solve_partition(problem).z, problems)
    few = problems[:theirs]
    slow_s, slow = median_of(_analytic_centre, few)
    printed_s, _ = median_of(_as_printed, few)
    differ = float(np.nanmax(np.abs(np.array(ours[:theirs]) - slow)))
    return [
        Timing(
            f"analytic centre, {size}, x {len(problems)}",
            ours_s,
            f"{PEER}, same centre, x {theirs}{_failed(slow)}",
            slow_s,
            differ,
        ),
        Timing(f"the same, {size}", ours_s, f"{PEER}, minimise 0, x {theirs}", printed_s, np.nan),
    ]


def _analytic_centre(problem: PartitionProblem) -> FloatArray:
    """Minimise -Σ log(b - A z) - log(1 - c² - s²); NaN where the solver gives up."""
    A, b = problem.all_rows
    z = cp.Variable(4)
    room = cp.hstack([1 - cp.sum_squares(z[2:])])
    try:
        cp.Problem(cp.Minimize(-cp.sum(cp.log(b - A @ z)) - cp.sum(cp.log(room)))).solve(solver=cp.CLARABEL)
    except cp.SolverError:
        return np.full(4, np.nan)
    return np.asarray(z.value)


def _as_printed(problem: PartitionProblem) -> FloatArray:
    """Minimise 0 subject to A z <= b and c² + s² <= 1, as [Wang2013], Eq. 8."""
    A, b = problem.all_rows
    z = cp.Variable(4)
    cp.Problem(cp.Minimize(0), [A @ z <= b, cp.sum_squares(z[2:]) <= 1]).solve(solver=cp.CLARABEL)
    return np.asarray(z.value)


def _failed(answers: Sequence[FloatArray]) -> str:
    count = int(np.isnan(answers).any(axis=1).sum())
    return f", {count} failed" if count else ""


def _random_stops(rng: np.random.Generator) -> list[ComparedStop]:
    """Anchors within 1 m and 0.4 m height, the part within 0.5 m, three stops some decimetres apart."""
    truth = Pose2(*rng.uniform(-0.5, 0.5, 2), rng.uniform(-np.pi, np.pi))
    stops = []
    for pose in [*(Pose2(*rng.uniform(-0.3, 0.3, 2), rng.uniform(-0.6, 0.6)) for _ in range(2)), Pose2()]:
        anchors_m = np.column_stack([rng.uniform(-0.5, 0.5, (9, 2)), rng.uniform(0.0, 0.4, 9)])
        tags_m = (pose.inverse() @ truth).apply(PART_M)
        m = np.linalg.norm(tags_m[:, None] - anchors_m[None], axis=2)
        stops.append(ComparedStop(anchors_m, PART_M, compare_proximities(m), pose))
    return stops


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fast", action="store_true", help="few problems, to see that it works")
    show(run(parser.parse_args(argv).fast))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
