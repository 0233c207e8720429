import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from rfcompass.errors import InputError, ShapeError
from rfcompass.evaluation import statistics
from rfcompass.evaluation.statistics import (
    bootstrap_interval,
    exact_interval,
    paired_difference_interval,
    quantile_of,
    sample_statistic,
    wilson_interval,
)

NAMES = ("median", "mean", "p90", "p05")
samples = st.lists(st.floats(-100, 100), min_size=1, max_size=30).map(np.array)


@given(samples, st.sampled_from((*NAMES, "sd")), st.integers(0, 1000))
def test_a_resample_has_the_statistic_of_its_repeated_samples(x, name, seed):
    counts = np.random.default_rng(seed).integers(0, 3, size=(4, len(x)))
    counts[:, 0] += 1
    resampled = statistics._resampled(x, name, counts)
    assert np.allclose(resampled, [sample_statistic(np.repeat(x, c), name) for c in counts], atol=1e-9)


@given(samples, st.sampled_from(NAMES))
def test_an_interval_lies_within_the_samples_and_repeats(x, name):
    first, second = (bootstrap_interval(x, name, np.random.default_rng(1), resamples=50) for _ in range(2))
    assert first == second
    assert x.min() - 1e-9 <= first.low <= first.high <= x.max() + 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_an_interval_scales_and_shifts_with_the_samples(name):
    x = np.random.default_rng(0).normal(size=40)
    plain = bootstrap_interval(x, name, np.random.default_rng(3))
    moved = bootstrap_interval(100.0 * x + 7.0, name, np.random.default_rng(3))
    assert np.allclose([moved.low, moved.high], [100.0 * plain.low + 7.0, 100.0 * plain.high + 7.0])


def test_blocks_bound_the_memory_and_nothing_else(monkeypatch):
    x = np.random.default_rng(0).normal(size=50)
    whole = bootstrap_interval(x, "median", np.random.default_rng(3), resamples=1000)
    monkeypatch.setattr(statistics, "_BLOCK", 50 * 10)
    assert bootstrap_interval(x, "median", np.random.default_rng(3), resamples=1000) == whole


@pytest.mark.parametrize(("name", "truth"), [("mean", 1.0), ("median", np.log(2.0))])
def test_a_bootstrap_interval_covers_the_truth_about_as_often_as_it_says(name, truth):
    rng = np.random.default_rng(11)
    intervals = [bootstrap_interval(rng.exponential(size=80), name, rng, resamples=400) for _ in range(400)]
    covered = np.mean([interval.low <= truth <= interval.high for interval in intervals])
    assert 0.90 <= covered <= 0.98


def test_samples_that_repeat_within_a_cluster_add_no_knowledge():
    x = np.random.default_rng(5).normal(size=30)
    alone = bootstrap_interval(x, "mean", np.random.default_rng(2))
    tripled, cluster = np.repeat(x, 3), np.repeat(np.arange(30) * 7, 3)
    clustered = bootstrap_interval(tripled, "mean", np.random.default_rng(2), clusters=cluster)
    assert np.allclose([clustered.low, clustered.high], [alone.low, alone.high])
    independent = bootstrap_interval(tripled, "mean", np.random.default_rng(2))
    assert independent.high - independent.low < 0.7 * (clustered.high - clustered.low)


def test_pairs_cancel_what_both_methods_share():
    hard = np.random.default_rng(5).exponential(size=50)
    interval = paired_difference_interval(hard + 0.25, hard, "median", np.random.default_rng(0))
    assert np.allclose([interval.low, interval.high], 0.25)


@given(st.integers(1, 500), st.data())
def test_the_limits_of_wilson_solve_the_score_equation(n, data):
    s = data.draw(st.integers(0, n))
    interval, z = wilson_interval(s, n), 1.959963984540054
    for p in (interval.low, interval.high):
        assert np.isclose((s / n - p) ** 2, z * z * p * (1 - p) / n, atol=1e-12)
    assert interval.low <= s / n <= interval.high
    mirrored = wilson_interval(n - s, n)
    assert np.allclose([interval.low, interval.high], [1 - mirrored.high, 1 - mirrored.low])


def test_never_in_ten_trials_is_below_a_quarter_or_so():
    z2 = 1.959963984540054**2
    assert np.allclose([wilson_interval(0, 10).low, wilson_interval(0, 10).high], [0.0, z2 / (10 + z2)])


@given(st.integers(1, 200), st.data(), st.sampled_from((0.8, 0.95)))
def test_at_the_limits_of_the_exact_interval_so_many_successes_are_a_chance_of_the_tail(n, data, level):
    s = data.draw(st.integers(0, n))
    interval, tail = exact_interval(s, n, level), (1 - level) / 2
    if s:
        assert np.isclose(binom.sf(s - 1, n, interval.low), tail)
    if s < n:
        assert np.isclose(binom.cdf(s, n, interval.high), tail)
    assert interval.low <= s / n <= interval.high
    mirrored = exact_interval(n - s, n, level)
    assert np.allclose([interval.low, interval.high], [1 - mirrored.high, 1 - mirrored.low])


def test_all_or_nothing_has_an_exact_interval_on_one_side():
    assert np.isclose(exact_interval(60, 60).low, 0.025 ** (1 / 60))
    assert exact_interval(60, 60).high == 1.0
    assert exact_interval(0, 60).low == 0.0


def test_nothing_has_no_statistic():
    with pytest.raises(ShapeError):
        bootstrap_interval(np.zeros(0), "mean", np.random.default_rng(0))
    with pytest.raises(InputError):
        wilson_interval(0, 0)
    with pytest.raises(InputError):
        wilson_interval(4, 3)
    with pytest.raises(InputError):
        exact_interval(0, 0)
    with pytest.raises(InputError):
        exact_interval(-1, 3)
    with pytest.raises(ShapeError):
        paired_difference_interval(np.zeros(3), np.zeros(2), "mean", np.random.default_rng(0))


def test_the_interval_of_a_standard_deviation_scales_and_does_not_shift():
    x = np.random.default_rng(0).normal(size=40)
    plain = bootstrap_interval(x, "sd", np.random.default_rng(3))
    moved = bootstrap_interval(100.0 * x + 7.0, "sd", np.random.default_rng(3))
    assert np.allclose([moved.low, moved.high], [100.0 * plain.low, 100.0 * plain.high])
    assert 0 < plain.low < x.std() < plain.high


def test_statistics_have_names():
    assert [quantile_of(name) for name in (*NAMES, "sd")] == [0.5, None, 0.9, 0.05, None]
    for name in ("mode", "p", "p100", "p-1", "P90"):
        with pytest.raises(InputError, match="known: median"):
            quantile_of(name)


def test_the_largest_of_ten_is_as_often_above_its_median_as_below():
    rng = np.random.default_rng(0)
    x = rng.exponential(size=400)
    largest = rng.choice(x, (20_000, 10)).max(axis=1)
    assert (largest > sample_statistic(x, "max10")).mean() == pytest.approx(0.5, abs=0.02)
    assert sample_statistic(x, "max1") == sample_statistic(x, "median")
