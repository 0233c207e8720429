"""Rows that others imply: a full order keeps its neighbours, a cycle keeps everything."""

import numpy as np
from compared_scenes import random_stops

from rfcompass.localization.comparing import compare_proximities
from rfcompass.localization.fast_solver import largest_ball
from rfcompass.localization.problem import build_partition
from rfcompass.localization.scaled_rows import scale_rows
from rfcompass.localization.transitive_reduction import implied_by_others
from rfcompass.types import Comparisons


def reachable(edges, i, j):
    """Slow reference: is there a chain from i to j?"""
    seen, open_ = set(), {i}
    while open_:
        at = open_.pop()
        for a, b in edges:
            if a == at and b not in seen:
                seen.add(b)
                open_.add(b)
    return j in seen


def test_a_total_order_keeps_its_neighbours():
    comparisons = compare_proximities(np.random.default_rng(0).uniform(size=(4, 9)))
    assert (~implied_by_others(comparisons)).sum() == 4 * 8


def test_a_comparison_is_implied_iff_a_chain_of_others_says_the_same():
    rng = np.random.default_rng(1)
    for _ in range(30):
        order, drawn = rng.permutation(6), rng.uniform(size=(6, 6)) < 0.5
        edges = [(order[a], order[b]) for a in range(6) for b in range(a + 1, 6) if drawn[a, b]]
        i, j = np.array(edges).T
        implied = implied_by_others(Comparisons(np.zeros(len(i), int), i, j, np.full(len(i), np.nan)))
        for m, (a, b) in enumerate(edges):
            others = edges[:m] + edges[m + 1 :]
            assert implied[m] == reachable(others, a, b)


def test_a_cycle_stays_as_it_is_beside_an_order_that_is_reduced():
    cycle, order = [(0, 1), (1, 2), (2, 0)], [(0, 1), (1, 2), (0, 2)]
    i, j = np.array(cycle + order).T
    implied = implied_by_others(Comparisons([0, 0, 0, 1, 1, 1], i, j, np.full(6, np.nan)))
    assert implied.tolist() == [False, False, False, False, False, True]


def test_a_repeated_comparison_counts_once():
    comparisons = Comparisons([0, 0, 0], [1, 1, 1], [2, 2, 3], np.full(3, np.nan))
    assert implied_by_others(comparisons).tolist() == [False, True, False]


def test_what_epsilon_drops_implies_nothing():
    m = np.array([[1.0, 1.01, 2.0]])
    comparisons = compare_proximities(m)
    assert implied_by_others(comparisons, 0.0).tolist() == [False, True, False]
    assert not implied_by_others(comparisons, 0.1).any()


def test_the_reduction_does_not_change_the_cell():
    for seed in range(20):
        stops, _ = random_stops(np.random.default_rng(seed), margins=True)
        for epsilon in (0.0, 0.1):
            full, reduced = (
                build_partition(stops, epsilon=epsilon, transitive_reduction=flag) for flag in (False, True)
            )
            assert len(reduced.rows) < len(full.rows)
            assert abs(largest_ball(scale_rows(full))[1] - largest_ball(scale_rows(reduced))[1]) < 1e-8
