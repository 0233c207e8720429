"""Two solvers, one answer; and an answer that is what it claims to be."""

import numpy as np
import pytest
from compared_scenes import random_stops

from rfcompass.errors import InputError, SolverFailed
from rfcompass.geometry import Pose2
from rfcompass.localization import fast_solver
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.partition_solver import SMALLEST_RADIUS_M, solve_partition
from rfcompass.localization.problem import PartitionProblem, build_partition
from rfcompass.types import Comparisons, HalfSpaces

SIZES = [{"K": 1}, {"K": 1, "S": 1}, {"K": 2, "S": 1}, {"K": 2}, {"K": 4}, {"K": 3, "N": 6}]


def problems(seeds, **size):
    for seed in seeds:
        stops, truth = random_stops(np.random.default_rng(seed), **size)
        for reduced in (True, False):
            yield build_partition(stops, transitive_reduction=reduced), truth


def agree(problem):
    fast, slow = (solve_partition(problem, solver=solver) for solver in ("fast", "cvxpy"))
    assert fast.feasible
    assert slow.feasible
    assert np.abs(fast.z - slow.z).max() < 1e-6
    assert abs(fast.radius_m - slow.radius_m) < 1e-6


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_both_solvers_find_the_same_centre_and_radius(size):
    for problem, _ in problems(range(3), **size):
        agree(problem)


@pytest.mark.slow
@pytest.mark.parametrize("size", SIZES, ids=str)
def test_both_solvers_find_the_same_centre_and_radius_in_many_problems(size):
    for problem, _ in problems(range(100, 140), **size):
        agree(problem)


@pytest.mark.parametrize("solver", ["fast", "cvxpy"])
def test_both_solvers_find_contradictions(solver):
    for seed in range(5):
        stops, _ = random_stops(np.random.default_rng(seed), flips=0.1)
        solution = solve_partition(build_partition(stops), solver=solver)
        assert not solution.feasible
        assert solution.radius_m < 0.0


def test_the_radii_of_contradictions_agree_too():
    stops, _ = random_stops(np.random.default_rng(0), flips=0.1)
    problem = build_partition(stops)
    fast, slow = (solve_partition(problem, centre="chebyshev", solver=solver) for solver in ("fast", "cvxpy"))
    assert abs(fast.radius_m - slow.radius_m) < 1e-6


def test_exact_comparisons_are_never_called_infeasible():
    """The true pose lies on the border of the unit disc, where a primal method stalls."""
    for problem, _ in problems(range(200)):
        solution = solve_partition(problem)
        assert solution.feasible
        assert solution.orientation_norm < 1.0


@pytest.mark.parametrize("centre", ["analytic", "chebyshev", "centroid"])
def test_every_centre_meets_every_row(centre):
    for problem, _ in problems(range(30)):
        z = solve_partition(problem, centre=centre).z
        A, b = problem.all_rows
        assert (A @ z <= b + 1e-9).all()
        assert np.hypot(*z[2:]) <= (1.001205 if centre == "chebyshev" else 1.0)  # corner of the 64-gon


def test_the_chebyshev_ball_fits_in_the_scaled_cell():
    for problem, _ in problems(range(5)):
        solution = solve_partition(problem, centre="chebyshev")
        A, b = problem.all_rows
        distance = (b - A @ solution.z) / np.linalg.norm(A / [1.0, 1.0, 0.2, 0.2], axis=1)
        assert distance.min() > solution.radius_m - 1e-8


def test_symmetric_anchors_whose_bisectors_coincide_do_no_harm():
    """Two pairs of a rectangle share each bisector, and four anchors their middle."""
    anchors_m = np.array([[0.3, 0.2, 0.1], [0.3, -0.2, 0.1], [-0.3, 0.2, 0.1], [-0.3, -0.2, 0.1]])
    points_m = np.array([[0.1, 0, 0], [-0.1, 0, 0]])
    tags_m = Pose2(0.25, 0.13, 0.4).apply(points_m)
    distance = np.linalg.norm(tags_m[:, None] - anchors_m[None], axis=2)
    pairs = np.array(
        [(k, i, j) for k in range(2) for i in range(4) for j in range(4) if distance[k, i] < distance[k, j]]
    )
    stop = ComparedStop(anchors_m, points_m, Comparisons(*pairs.T, np.full(len(pairs), np.nan)))
    for reduced in (True, False):
        agree(build_partition([stop], transitive_reduction=reduced))


def test_a_comparison_and_its_opposite_leave_a_line_that_counts_as_nothing():
    stop = ComparedStop(np.eye(3), np.zeros((1, 3)), Comparisons([0, 0], [0, 1], [1, 0], [np.nan, np.nan]))
    solution = solve_partition(build_partition([stop]))
    assert not solution.feasible
    assert abs(solution.radius_m) < SMALLEST_RADIUS_M


def test_anchors_above_each_other_with_a_false_order_contradict_all_poses():
    stop = ComparedStop(
        [[0.0, 0, 0.1], [0, 0, 0.4], [0.3, 0, 0]], np.zeros((1, 3)), Comparisons([0], [1], [0], [np.nan])
    )
    for solver in ("fast", "cvxpy"):
        assert not solve_partition(build_partition([stop]), solver=solver).feasible


def corner_problem(slack):
    """All that is left lies at |(c, s)| >= 1 - slack in direction θ = π/64, a corner of the 64-gon."""
    corner = np.array([0.0, 0.0, np.cos(np.pi / 64), np.sin(np.pi / 64)])
    return PartitionProblem(HalfSpaces([-corner], [-(1.0 - slack)], [0]), np.array([[-1.0, 1.0], [-1.0, 1.0]]))


def test_a_cell_between_the_disc_and_the_polygon_holds_no_analytic_centre():
    solution = solve_partition(corner_problem(-1e-4))
    assert solution.radius_m > SMALLEST_RADIUS_M
    assert not solution.feasible


def test_a_sliver_inside_the_disc_is_found():
    for slack in (1e-3, 1e-5):
        solution = solve_partition(corner_problem(slack))
        assert solution.feasible
        assert 1.0 - slack < solution.orientation_norm < 1.0


def test_a_solver_that_stalls_is_not_taken_for_a_contradiction(monkeypatch):
    stops, _ = random_stops(np.random.default_rng(0))
    problem = build_partition(stops)
    monkeypatch.setattr(fast_solver.kernels, "chebyshev", lambda G, h, tolerance: (np.zeros(4), -1.0, 1))
    with pytest.raises(SolverFailed, match="stalled"):
        solve_partition(problem)


def test_extra_constraints_hold_and_need_cvxpy():
    for problem, _ in problems(range(3)):
        free = solve_partition(problem)

        def wall(z, limit=float(free.z[0]) - 1e-4):
            return [z[0] <= limit]

        for centre in ("analytic", "chebyshev"):
            held = solve_partition(problem, centre=centre, solver="cvxpy", extra_constraints=wall)
            assert held.z[0] <= free.z[0] - 1e-4 + 1e-7
        with pytest.raises(InputError, match="cvxpy"):
            solve_partition(problem, extra_constraints=wall)


def test_extra_constraints_that_leave_nothing_are_infeasible():
    stops, _ = random_stops(np.random.default_rng(0))
    far = lambda z: [z[0] >= 50.0]  # noqa: E731
    assert not solve_partition(build_partition(stops), solver="cvxpy", extra_constraints=far).feasible


@pytest.mark.parametrize("wrong", [{"centre": "middle"}, {"solver": "simplex"}])
def test_unknown_names_are_refused(wrong):
    stops, _ = random_stops(np.random.default_rng(0))
    with pytest.raises(InputError):
        solve_partition(build_partition(stops), **wrong)
