"""The largest sets of comparisons: against HiGHS, against slices of θ, and one search against the other."""

import numpy as np
import pytest
from compared_scenes import random_stops
from milp_oracle import most_rows_in_plane, most_rows_of_poses

from rfcompass.geometry import polygon_contains
from rfcompass.localization.arrangement import deepest_cells
from rfcompass.localization.best_cells import best_cells, cell_of, fingerprints, rows_met, signed_distances
from rfcompass.localization.consistency_kernels import search
from rfcompass.localization.problem import build_partition

BOUNDS_M = np.array([[-1.0, 1.0], [-1.0, 1.0]])
LEAF = np.array([1.25e-6, 1.25e-6, 6.25e-6])
MARGIN_M = 1e-3
SLACK_M = 1e-5  # HiGHS lets a binary be 1e-6 off, times up to 3 m of slack; cells thinner than this may go either way


def a_problem(seed, flips=0.1, **size):
    stops, _ = random_stops(np.random.default_rng(seed), flips=flips, **size)
    return build_partition(stops, transitive_reduction=False, bounds_m=BOUNDS_M)


def best(problem, margin_m=MARGIN_M, max_boxes=400_000):
    return best_cells(problem, margin_m, LEAF, max_boxes)


@pytest.mark.parametrize("flips", [0.1, 0.4])
def test_for_one_tag_no_milp_does_better_or_worse(flips):
    for seed in range(6):
        problem = a_problem(seed, flips, K=1, S=2, N=6)
        found = best(problem)
        stricter, laxer = (signed_distances(problem, MARGIN_M + sign * SLACK_M) for sign in (1, -1))
        assert most_rows_in_plane(stricter, BOUNDS_M) <= found.met == found.bound
        assert found.met <= most_rows_in_plane(laxer, BOUNDS_M)


def test_for_two_tags_the_count_lies_between_slices_and_milp():
    """From below the exact answer at single θ, from above that of a MILP with a little more than the circle."""
    equal = 0
    for seed in range(4):
        problem = a_problem(seed, 0.2, K=2, S=1, N=5)
        found = best(problem)
        laxer = signed_distances(problem, MARGIN_M - SLACK_M)
        assert found.met == found.bound
        most = most_rows_of_poses(laxer, BOUNDS_M)
        assert best_of_slices(problem) <= found.met <= most
        equal += found.met == most
    assert equal > 0  # or else the bound from above would tell nothing


def best_of_slices(problem):
    """The most rows that a pose meets whose θ is one of a few."""
    return max(cells.met for cells in slices_of(problem))


def slices_of(problem, count=180):
    """The deepest cells at each of a few θ, exactly."""
    G = signed_distances(problem, MARGIN_M)
    for theta in np.linspace(-np.pi, np.pi, count, endpoint=False):
        beta = G[:, 4] - G[:, 2] * np.cos(theta) - G[:, 3] * np.sin(theta)
        yield deepest_cells(G[:, :2], beta, BOUNDS_M)


def test_no_cell_that_ties_for_the_best_is_missing():
    several = 0
    for seed in range(10, 20):  # half of the comparisons wrong: many cells tie, and some are found last
        problem = a_problem(seed, 0.5, K=2, S=2, N=5)
        found = best(problem)
        known = {tuple(one) for one in found.sets.tolist()}
        slices = [cells for cells in slices_of(problem, 360) if cells.met == found.met]
        ties = {tuple(one) for cells in slices for one in cells.sets.tolist()}
        assert found.complete
        assert ties <= known
        several += len(ties) > 1
    assert several > 3


@pytest.mark.parametrize("size", [{"K": 2}, {"K": 4}], ids=str)
def test_no_slice_of_a_large_problem_beats_the_proof(size):
    for seed in range(2):
        problem = a_problem(seed, **size)
        found = best(problem)
        assert best_of_slices(problem) <= found.met == found.bound


def test_walking_along_borders_and_halving_boxes_find_the_same_cells():
    for seed in range(10):
        problem = a_problem(seed, K=1)
        G, poses = signed_distances(problem, MARGIN_M), np.zeros((64, 3))
        halved = search(G, fingerprints(len(G)), BOUNDS_M, LEAF, 400_000, poses)
        walked = best(problem)
        assert walked.met == halved.met == halved.bound
        assert walked.complete
        sets = rows_met(G, poses[: halved.found])
        assert np.array_equal(np.unique(walked.sets, axis=0), np.unique(sets, axis=0))


def test_a_stricter_margin_never_lets_more_rows_hold():
    for seed in range(5):
        problem = a_problem(seed, K=2, S=2, N=6)
        met = [best(problem, margin_m).met for margin_m in (1e-4, 1e-3, 1e-2)]
        assert met == sorted(met, reverse=True)


def test_more_room_finds_no_less_and_proves_no_more():
    problem = a_problem(1)
    found = [best(problem, max_boxes=boxes) for boxes in (64, 200, 500, 400_000)]
    assert [one.met for one in found] == sorted(one.met for one in found)
    assert [one.bound for one in found] == sorted((one.bound for one in found), reverse=True)
    assert not found[0].complete
    assert found[-1].complete
    assert found[-1].met == found[-1].bound


def test_the_order_of_the_rows_does_not_matter():
    problem = a_problem(2, K=2)
    G, rng = signed_distances(problem, MARGIN_M), np.random.default_rng(0)
    sets = []
    for order in (np.arange(len(G)), rng.permutation(len(G))):
        poses = np.zeros((64, 3))
        found = search(G[order], fingerprints(len(G)), BOUNDS_M, LEAF, 400_000, poses)
        sets.append(np.unique(rows_met(G, poses[: found.found]), axis=0))
    assert np.array_equal(*sets)


def test_the_cell_of_a_set_holds_the_poses_that_meet_it():
    for seed in range(10):
        problem, poses = a_problem(seed), np.zeros((64, 3))
        G = signed_distances(problem, MARGIN_M)
        found = search(G, fingerprints(len(G)), BOUNDS_M, LEAF, 400_000, poses)
        for pose, met in zip(poses, rows_met(G, poses[: found.found]), strict=False):
            cell = cell_of(problem, met)
            low, high = cell.theta_interval_rad
            assert (pose[2] - low) % (2 * np.pi) <= high - low
            assert polygon_contains(cell.region_m, pose[None, :2], 1e-4).all()
