"""Branch and bound against a plain grid, and its bound against what is really possible."""

import numpy as np
import pytest
from compared_scenes import random_stops

from rfcompass.localization.best_cells import rows_met, signed_distances
from rfcompass.localization.consistency_kernels import search
from rfcompass.localization.problem import build_partition

LEAF = np.array([1.25e-3, 1.25e-3, np.radians(0.375)])
BOUNDS_M = np.array([[-1.0, 1.0], [-1.0, 1.0]])


def rows_of(seed, flips=0.1, margin_m=1e-3, **size):
    stops, truth = random_stops(np.random.default_rng(seed), flips=flips, **size)
    problem = build_partition(stops, transitive_reduction=False, bounds_m=BOUNDS_M)
    return signed_distances(problem, margin_m), np.array([[truth.x_m, truth.y_m, truth.theta_rad]])


def best_of(G, max_boxes=400_000):
    poses = np.zeros((64, 3))
    prints = np.random.default_rng(0).integers(-(2**62), 2**62, len(G))
    met, bound, found, _, boxes = search(G, prints, BOUNDS_M, LEAF, max_boxes, poses)
    return met, bound, poses[:found], boxes


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


def test_every_pose_that_is_returned_meets_as_many_as_is_said_but_others():
    for seed in range(5):
        G, _ = rows_of(seed)
        met, bound, poses, _ = best_of(G)
        sets = rows_met(G, poses)
        assert met <= bound
        assert len(poses) > 0
        assert (sets.sum(axis=1) == met).all()
        assert len(np.unique(sets, axis=0)) == len(sets)


def test_all_cells_of_a_tie_are_found():
    """Two stripes where both rows of a pair hold, one in between where neither does."""
    G = np.array([[1.0, 0, 0, 0, -0.5, 0], [-1.0, 0, 0, 0, -0.5, 0], [0, 1.0, 0, 0, 0.3, 0]])
    met, bound, poses, _ = best_of(G)
    assert met == bound == 2
    assert sorted(np.sign(poses[:, 0])) == [-1.0, 1.0]
    assert (poses[:, 1] <= 0.3).all()


def test_exact_comparisons_can_all_be_met():
    for seed in range(5):
        G, _ = rows_of(seed, flips=0.0, margin_m=0.0, K=2, S=2)
        met, bound, _, _ = best_of(G)
        assert met == bound == len(G)


def test_giving_up_early_keeps_the_bound_honest():
    G, _ = rows_of(0)
    met, bound, _, boxes = best_of(G)
    hasty, loose, _, few = best_of(G, max_boxes=100)
    assert few <= 100 < boxes
    assert hasty <= met <= bound <= loose


def test_a_box_without_open_rows_is_not_cut_up():
    met, bound, poses, boxes = best_of(np.array([[1.0, 0.0, 0.0, 0.0, 5.0, 0.0]]))
    assert (met, bound, len(poses), boxes) == (1, 1, 1, 0)


def test_poses_far_from_the_start_are_found_despite_many_static_anchors():
    """The same anchors at all stops: a depth-first search loses itself here."""
    for seed in range(10):
        stops, truth = random_stops(np.random.default_rng(seed), S=1)
        rng = np.random.default_rng(seed)
        G = signed_distances(build_partition(stops * 3, transitive_reduction=False), 1e-3)
        wrong = rng.uniform(size=len(G)) < 0.1
        G[wrong, :5] *= -1.0
        truth_met = rows_met(G, np.array([[truth.x_m, truth.y_m, truth.theta_rad]])).sum()
        assert best_of(G)[1] >= truth_met
        assert best_of(G)[0] >= truth_met - 3
