"""Each step of an answer beside cvxpy, on the same noisy comparisons: rows built, and whole answers.

The problems are those of `bench_posterior` (nine robot tags, four part tags, three stops of a base that stands, tags
that seem 1.3 cm off): what a robot has after three scans. The peer is the program that one would write in cvxpy for
comparisons of which some are wrong, least total slack, built and solved by Clarabel:

    minimise Σ s   subject to   A [x, y, c, s]ᵀ <= b + s,  s >= 0,  c² + s² <= 1.

"Rows" are the half-planes of all stops in the newest frame, beside cvxpy's own preparation of the program. The whole
answers are those of `paper`, `consistency` and `posterior` from the same observations, with region and all. "Differ"
is the median distance of the centres [m]; the posterior also uses distances, so that it should differ.

Run `python -m benchmarks.bench_steps`; some seconds.
"""

import argparse
from collections.abc import Sequence
from typing import TypeVar

import cvxpy as cp
import numpy as np

from benchmarks.bench_posterior import FIRST_SEED, random_problem
from benchmarks.timing import Timing, median_of, show
from rfcompass.arrays import FloatArray
from rfcompass.interfaces import Localizer
from rfcompass.localization import ConsistencyLocalizer, PartitionLocalizer, PosteriorLocalizer
from rfcompass.localization.compared_stop import compared_stops
from rfcompass.localization.problem import PartitionProblem, build_partition
from rfcompass.types import Observation

STOPS = 3
PEER = f"cvxpy {cp.__version__} + Clarabel"

Problem = TypeVar("Problem")
Answer = TypeVar("Answer")


def run(fast: bool = False) -> list[Timing]:
    """Build the rows, then answer in each of three ways."""
    many, few = (5, 2) if fast else (200, 20)
    seen = [random_problem(seed, STOPS).stops for seed in range(FIRST_SEED, FIRST_SEED + many)]
    compared = [compared_stops(stops) for stops in seen]
    build_s, problems = median_of(lambda stops: build_partition(stops, transitive_reduction=False), compared)
    prepare_s, _ = median_of(_prepared, problems[:few])
    rows = len(problems[0].rows.b)
    lines = [Timing(f"rows of {STOPS} stops, {rows}", build_s, f"{PEER}, preparation", prepare_s, np.nan)]
    slack_s, slack_m = median_of(_least_slack, problems[:few])
    ways: dict[str, Localizer] = {
        "paper": PartitionLocalizer(),
        "consistency": ConsistencyLocalizer(),
        "posterior": PosteriorLocalizer(),
    }
    for name, localizer in ways.items():
        ours_s, ours_m = median_of(lambda stops, localizer=localizer: _centre(localizer, stops), seen)
        differ = float(np.median(np.linalg.norm(np.array(ours_m[:few]) - slack_m, axis=1)))
        what = f"whole answer, {name}, {rows} comparisons"
        lines.append(Timing(what, ours_s, f"{PEER}, least slack", slack_s, differ))
    return lines


def _program(problem: PartitionProblem) -> tuple[cp.Problem, cp.Variable]:
    A, b = problem.all_rows
    z, slack = cp.Variable(4), cp.Variable(len(b), nonneg=True)
    return cp.Problem(cp.Minimize(cp.sum(slack)), [A @ z <= b + slack, cp.sum_squares(z[2:]) <= 1]), z


def _prepared(problem: PartitionProblem) -> object:
    return _program(problem)[0].get_problem_data(cp.CLARABEL)


def _least_slack(problem: PartitionProblem) -> FloatArray:
    program, z = _program(problem)
    program.solve(solver=cp.CLARABEL)
    return np.asarray(z.value[:2])


def _centre(localizer: Localizer, stops: Sequence[Observation]) -> FloatArray:
    return localizer.estimate(stops).centre_m


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fast", action="store_true", help="few problems, to see that it works")
    show(run(parser.parse_args(argv).fast))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
