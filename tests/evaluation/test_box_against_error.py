"""A box that knows the error is told from one that does not."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import spearmanr

from rfcompass.errors import ShapeError
from rfcompass.evaluation.box_against_error import box_against_error, rank_correlation


def judged(boxes, errors_m, seed=0):
    return box_against_error(boxes, errors_m, np.random.default_rng(seed), resamples=300)


@given(seed=st.integers(0, 2**31), power=st.floats(0.1, 3.0))
@settings(max_examples=15)
def test_a_box_that_grows_with_the_error_is_perfect_whatever_its_unit(seed, power):
    errors_m = np.random.default_rng(seed).uniform(0.001, 0.2, 30)
    found = judged(7.0 * errors_m**power, errors_m)
    assert found.rank_correlation == pytest.approx(1.0)
    assert found.interval.low == pytest.approx(1.0)
    assert found.smaller_m < found.larger_m
    assert found.trials == 30


def test_a_box_that_knows_nothing_has_an_interval_about_zero():
    rng = np.random.default_rng(1)
    found = judged(rng.uniform(size=200), rng.uniform(size=200))
    assert found.interval.low < 0 < found.interval.high


def test_halves_are_those_of_a_plain_sort():
    found = judged([5, 1, 4, 2, 3], [0.5, 0.1, 0.4, 0.2, 0.3])
    assert found.smaller_m == pytest.approx(0.15)
    assert found.larger_m == pytest.approx(0.4)


@given(seed=st.integers(0, 2**31))
@settings(max_examples=20)
def test_the_rank_correlation_is_spearmans_with_ties(seed):
    a, b = np.random.default_rng(seed).integers(0, 5, (2, 20)).astype(float)
    assert rank_correlation(a, b) == pytest.approx(spearmanr(a, b).statistic)


def test_equal_boxes_tell_nothing():
    assert judged(np.ones(10), np.arange(10.0)).rank_correlation == 0.0


def test_too_few_trials_and_ill_shaped_ones_are_refused():
    with pytest.raises(ShapeError, match="halve"):
        judged([1, 2, 3], [1, 2, 3])
    with pytest.raises(ShapeError):
        judged([1, 2, 3, 4], [1, 2, 3])
