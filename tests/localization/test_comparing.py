"""The comparison predicate: one answer for each pair at most, and ε only ever takes answers away."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rfcompass.errors import ShapeError
from rfcompass.localization.comparing import compare_proximities

values = st.one_of(st.floats(0.0, 10.0), st.just(float("nan")), st.sampled_from([0.0, 1.0]))
matrices = arrays(np.float64, st.tuples(st.integers(1, 3), st.integers(2, 6)), elements=values)


@given(matrices)
def test_every_pair_is_answered_once_or_abstains(m):
    comparisons = compare_proximities(m)
    K, N = m.shape
    assert len(comparisons) + comparisons.abstained == K * N * (N - 1) // 2
    pairs = {(k, *sorted((i, j))) for k, i, j in zip(*_columns(comparisons), strict=True)}
    assert len(pairs) == len(comparisons)


@given(matrices, st.floats(0.0, 0.9))
def test_each_answer_passes_the_printed_test(m, epsilon):
    comparisons = compare_proximities(m, epsilon)
    k, i, j = _columns(comparisons)
    assert (m[k, i] <= (1.0 - epsilon) * m[k, j] + 1e-12).all()
    assert (m[k, i] < m[k, j]).all()


@given(matrices, st.floats(0.0, 0.9))
def test_a_larger_epsilon_keeps_those_with_the_larger_margin(m, epsilon):
    all_of_them = compare_proximities(m)
    kept = all_of_them.take(all_of_them.margin >= epsilon)
    direct = compare_proximities(m, epsilon)
    assert np.array_equal(_columns(kept), _columns(direct))
    assert np.array_equal(kept.margin, direct.margin)


@given(matrices, st.floats(0.1, 1000.0))
def test_the_unit_of_the_proximities_does_not_matter(m, unit):
    scaled = compare_proximities(m * 2.0 ** round(np.log2(unit)))
    assert np.array_equal(_columns(compare_proximities(m)), _columns(scaled))


def test_equal_and_missing_proximities_abstain():
    comparisons = compare_proximities(np.array([[1.0, 1.0, np.nan]]))
    assert len(comparisons) == 0
    assert comparisons.abstained == 3


@pytest.mark.parametrize("m", [np.array([[1.0, -1.0]]), np.array([[1.0, np.inf]]), np.zeros(3)])
def test_impossible_proximities_are_refused(m):
    with pytest.raises(ShapeError):
        compare_proximities(m)


@pytest.mark.parametrize("epsilon", [-0.1, 1.0])
def test_an_epsilon_outside_its_range_is_refused(epsilon):
    with pytest.raises(ShapeError, match="epsilon"):
        compare_proximities(np.ones((1, 2)), epsilon)


def _columns(comparisons):
    return np.array([comparisons.target, comparisons.nearer, comparisons.farther])
