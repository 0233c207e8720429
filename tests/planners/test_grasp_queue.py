"""The most likely grasp comes first, and most of the others are never computed to the end."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from planners.grasp_queue import highest, most_likely_first
from planners.success import GraspChance


def ask(chances, scores=None, count=1000, seed=0):
    """Order grasps of given chances; also how many judgements that took."""
    rng = np.random.default_rng(seed)
    holds = rng.uniform(size=(len(chances), count)) < np.array(chances)[:, None]
    asked = [0]

    def weigh(i, some):
        asked[0] += some
        return GraspChance(float(holds[i, :some].mean()), 0.0, (), some)

    scores = np.zeros(len(chances)) if scores is None else scores
    return list(most_likely_first(scores, count, weigh)), holds.mean(axis=1), asked[0]


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12), st.integers(0, 1000))
def test_each_grasp_comes_once_with_its_chance_and_the_likeliest_first(chances, seed):
    order, exact, _ = ask(chances, seed=seed)
    assert sorted(i for i, _ in order) == list(range(len(chances)))
    assert all(chance.probability == exact[i] and chance.samples == 1000 for i, chance in order)
    found = [chance.probability for _, chance in order]
    # A grasp may come out of order only if its first few samples were three standard errors off.
    assert found[0] >= max(found) - 0.05


def test_grasps_that_hold_always_come_by_their_scores_and_the_first_costs_little():
    asked = []

    def weigh(i, some):
        asked.append(some)
        return GraspChance(1.0, 0.0, (), some)

    scores = [0.2, 0.9, 0.5]
    rows = most_likely_first(scores, 1000, weigh)
    assert next(rows)[0] == 1
    assert sum(asked) == 3 * 100 + 400 + 1000
    assert [i for i, _ in rows] == [2, 0]


def test_unlikely_grasps_are_given_up_early():
    chances = [0.95, *[0.5] * 30]
    rng = np.random.default_rng(0)
    holds = rng.uniform(size=(len(chances), 1000)) < np.array(chances)[:, None]
    asked = []

    def weigh(i, some):
        asked.append(some)
        return GraspChance(float(holds[i, :some].mean()), 0.0, (), some)

    assert next(most_likely_first([0.0] * 31, 1000, weigh))[0] == 0
    assert sum(asked) == 31 * 100 + 400 + 1000


@given(st.integers(0, 100))
def test_the_bound_is_above_the_share_and_never_above_one(held):
    assert held / 100 < highest(held / 100, 100) <= 1.0 or held == 100
    assert highest(held / 100, 100) >= highest(held / 100, 1000)


def test_one_pose_is_enough():
    order, _, asked = ask([1.0, 0.0], count=1)
    assert [i for i, _ in order] == [0, 1]
    assert asked == 2
