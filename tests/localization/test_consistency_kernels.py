"""Branch and bound against a plain grid, and its bound against what is really possible."""

import numpy as np
import pytest
from compared_scenes import random_stops

from rfcompass.localization.consistency import rows_met, signed_distances
from rfcompass.localization.consistency_kernels import search
from rfcompass.localization.problem import build_partition

LEAF = np.array([1.25e-3, 1.25e-3, np.radians(0.375)])
BOUNDS_M = np.array([[-1.0, 1.0], [-1.0, 1.0]])


def rows_of(seed, flips=0.1, margin_m=1e-3, **size):
    stops, truth = random_stops(np.random.default_rng(seed), flips=flips, **size)
    problem = build_partition(stops, transitive_reduction=False, bounds_m=BOUNDS_M)
    return signed_distances(problem, margin_m), np.array([[truth.x_m, truth.y_m, truth.theta_rad]])


def best_of(G, max_nodes=400_000, best=0):
    poses = np.zeros((4096, 3))
    met, bound, found, nodes = search(G, BOUNDS_M, LEAF, best, max_nodes, poses)
    return met, bound, poses[:found], nodes


def on_a_grid(G):
    """Slow reference: the most rows that any pose of a grid meets."""
    x = np.linspace(-1, 1, 41)
    theta = np.linspace(-np.pi, np.pi, 72, endpoint=False)
    poses = np.array(np.meshgrid(x, x, theta)).reshape(3, -1).T
    return int(rows_met(G, poses).sum(axis=1).max())


@pytest.mark.parametrize("size", [{"K": 1}, {"K": 2, "S": 2, "N": 6}], ids=str)
def test_no_grid_pose_does_better(size):
    for seed in range(5):
        G, truth = rows_of(seed, **size)
        met, bound, _, _ = best_of(G)
        assert met >= on_a_grid(G)
        assert bound >= met
        assert bound >= rows_met(G, truth).sum()


def test_every_pose_that_is_returned_meets_as_many_as_is_said():
    for seed in range(5):
        G, _ = rows_of(seed)
        met, bound, _, _ = best_of(G)
        again, _, poses, _ = best_of(G, best=met)
        assert met == again <= bound
        assert len(poses) > 0
        assert (rows_met(G, poses).sum(axis=1) == met).all()


def test_exact_comparisons_can_all_be_met():
    for seed in range(5):
        G, _ = rows_of(seed, flips=0.0, margin_m=0.0, K=2, S=2)
        met, bound, _, _ = best_of(G)
        assert met == bound == len(G)


def test_giving_up_early_keeps_the_bound_honest():
    G, _ = rows_of(0)
    met, bound, _, nodes = best_of(G)
    hasty, loose, _, few = best_of(G, max_nodes=200)
    assert few <= 202 < nodes
    assert hasty <= met <= bound <= loose


def test_a_box_without_open_rows_is_not_cut_up():
    G = np.array([[1.0, 0.0, 0.0, 0.0, 5.0, 0.0]])
    met, bound, poses, nodes = best_of(G, best=0)
    assert (met, bound, len(poses), nodes) == (1, 1, 1, 0)
