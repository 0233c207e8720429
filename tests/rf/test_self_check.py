"""The robot's own tags tell how far a meter can be trusted."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.stats import spearmanr

from rfcompass.errors import InputError, TooFewPairs
from rfcompass.rf.self_check import DistanceCalibration, calibrate_distances, check_comparator
from rfcompass.types import ProximityMatrix, TagPositions

NINE_M = np.random.default_rng(7).uniform(-0.4, 0.4, (9, 3))
seeds = st.integers(0, 2**31)


def anchors_at(points_m):
    return TagPositions("base", tuple(f"a{i}" for i in range(len(points_m))), points_m)


def matrix_of(anchors, m_of_distance, missing=()):
    """A matrix whose anchor block is a function of the distances [m], some pairs missing."""
    d = np.linalg.norm(anchors.points_m[:, None] - anchors.points_m[None], axis=2)
    upper = np.triu(m_of_distance(d), 1)
    m = upper + upper.T
    np.fill_diagonal(m, np.nan)
    for i, j in missing:
        m[i, j] = m[j, i] = np.nan
    N = len(anchors.epcs)
    return ProximityMatrix((), anchors.epcs, np.zeros((0, N)), m, "toy")


@given(power=st.floats(0.2, 3.0), scale=st.floats(0.01, 100.0))
def test_a_meter_that_is_a_power_of_the_distance_is_without_noise(power, scale):
    quality = check_comparator(matrix_of(anchors_at(NINE_M), lambda d: scale * d**power), anchors_at(NINE_M))
    assert quality.pairs == 36
    assert quality.rank_correlation == pytest.approx(1.0)
    assert quality.slope == pytest.approx(power, rel=1e-6)
    assert np.exp(quality.intercept) == pytest.approx(scale, rel=1e-6)
    assert quality.log_distance_noise == pytest.approx(0.0, abs=1e-9)
    assert quality.wrong_share == 0.0
    assert quality.verdict == "good"


@given(power=st.floats(0.2, 3.0), scale=st.floats(0.01, 100.0), seed=seeds)
@settings(max_examples=20)
def test_units_and_powers_of_the_meter_do_not_change_the_noise(power, scale, seed):
    """σ belongs to log d: m' = s m^p has the same order, b' = p b and residuals p e."""
    draw = np.random.default_rng(seed).normal(0, 0.2, (9, 9))
    plain = check_comparator(matrix_of(anchors_at(NINE_M), lambda d: d * np.exp(draw)), anchors_at(NINE_M))
    other = matrix_of(anchors_at(NINE_M), lambda d: scale * (d * np.exp(draw)) ** power)
    found = check_comparator(other, anchors_at(NINE_M))
    assume(plain.slope > 0)
    assert found.log_distance_noise == pytest.approx(plain.log_distance_noise, rel=1e-6)
    assert found.rank_correlation == pytest.approx(plain.rank_correlation)
    assert found.wrong_share == plain.wrong_share


def test_the_noise_that_was_put_in_comes_out():
    """Mean over 60 scans of 36 pairs: the estimator's own spread, about 15 % a scan, is 2 % of the mean."""
    rng = np.random.default_rng(0)
    for sigma in (0.05, 0.2):
        found = [
            check_comparator(
                matrix_of(anchors_at(NINE_M), lambda d, s=sigma: d * np.exp(rng.normal(0, s, d.shape))),
                anchors_at(NINE_M),
            ).log_distance_noise
            for _ in range(60)
        ]
        assert np.mean(found) == pytest.approx(sigma, rel=0.15)


def test_a_few_wild_pairs_do_not_move_the_fit():
    anchors, wild = anchors_at(NINE_M), np.zeros((9, 9))
    wild[0, 3] = wild[2, 5] = wild[4, 8] = 3.0
    quality = check_comparator(matrix_of(anchors, lambda d: d * np.exp(wild)), anchors)
    assert quality.slope == pytest.approx(1.0, abs=0.05)
    assert quality.log_distance_noise < 0.05
    assert quality.wrong_share > 0


def test_a_meter_that_knows_nothing_is_useless_and_wrong_half_of_the_time():
    rng = np.random.default_rng(1)
    qualities = [
        check_comparator(matrix_of(anchors_at(NINE_M), lambda d: rng.uniform(1, 2, d.shape)), anchors_at(NINE_M))
        for _ in range(20)
    ]
    assert np.mean([q.wrong_share for q in qualities]) == pytest.approx(0.5, abs=0.1)
    falling = check_comparator(matrix_of(anchors_at(NINE_M), lambda d: 1 / (d + 0.1)), anchors_at(NINE_M))
    assert falling.log_distance_noise == float("inf")
    assert falling.verdict == "useless"
    assert falling.wrong_share == 1.0
    assert falling.rank_correlation == pytest.approx(-1.0)


@given(seed=seeds)
@settings(max_examples=20)
def test_the_wrong_triplets_are_those_that_a_plain_loop_counts(seed):
    rng = np.random.default_rng(seed)
    anchors = anchors_at(np.round(rng.uniform(-1, 1, (6, 3)), 1))
    matrix = matrix_of(anchors, lambda d: np.abs(d + rng.normal(0, 0.2, d.shape)), missing=[(0, 1), (2, 4)])
    asked, wrong = 0, 0
    for a in range(6):
        for i in range(6):
            for j in range(i):
                m_i, m_j = matrix.anchor_m[a, i], matrix.anchor_m[a, j]
                gap = np.linalg.norm(anchors.points_m[a] - anchors.points_m[i])
                gap -= np.linalg.norm(anchors.points_m[a] - anchors.points_m[j])
                if a in (i, j) or np.isnan(m_i - m_j) or abs(gap) < 1e-6:
                    continue
                asked += 1
                wrong += (m_i < m_j) != (gap < 0)
    quality = check_comparator(matrix, anchors)
    assert quality.triplets == asked
    assert quality.wrong_share == pytest.approx(wrong / asked)
    assert quality.pairs == 13


@given(seed=seeds)
@settings(max_examples=20)
def test_the_rank_correlation_is_spearmans_with_ties(seed):
    rng = np.random.default_rng(seed)
    anchors = anchors_at(np.round(rng.uniform(-1, 1, (6, 3)), 1))
    matrix = matrix_of(anchors, lambda d: np.round(np.abs(d + rng.normal(0, 0.3, d.shape)), 1))
    upper = np.triu_indices(6, 1)
    d = np.linalg.norm(anchors.points_m[upper[0]] - anchors.points_m[upper[1]], axis=1)
    expected = spearmanr(matrix.anchor_m[upper], d).statistic
    assert check_comparator(matrix, anchors).rank_correlation == pytest.approx(expected)


def test_two_tags_that_seem_to_be_in_one_place_do_not_break_the_fit():
    anchors = anchors_at(NINE_M)
    quality = check_comparator(matrix_of(anchors, lambda d: np.where(d < 0.3, 0.0, d)), anchors)
    assert quality.pairs == 36
    assert np.isfinite(quality.log_distance_noise)


def test_too_few_pairs_are_no_answer():
    three = anchors_at(NINE_M[:3])
    for check in (check_comparator, calibrate_distances):
        with pytest.raises(TooFewPairs) as caught:
            check(matrix_of(three, lambda d: d), three)
        assert caught.value.numbers["pairs"] == 3
        with pytest.raises(TooFewPairs):
            check(matrix_of(anchors_at(NINE_M[:0]), lambda d: d), anchors_at(NINE_M[:0]))


def test_distances_that_are_all_equal_tell_nothing():
    tetrahedron = anchors_at(np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]]))
    with pytest.raises(TooFewPairs, match="different"):
        check_comparator(matrix_of(tetrahedron, lambda d: d), tetrahedron)


def test_an_anchor_without_a_place_is_an_error():
    with pytest.raises(InputError, match="a8"):
        check_comparator(matrix_of(anchors_at(NINE_M), lambda d: d), anchors_at(NINE_M[:8]))


@given(seed=seeds)
@settings(max_examples=20)
def test_calibrated_distances_grow_with_m_and_recover_any_growing_meter(seed):
    rng = np.random.default_rng(seed)
    anchors = anchors_at(NINE_M)
    exact = matrix_of(anchors, np.tanh)
    d = np.linalg.norm(NINE_M[0] - NINE_M[1])
    assert calibrate_distances(exact, anchors).distance_m(np.tanh(d)) == pytest.approx(d, rel=1e-9)
    noisy = calibrate_distances(matrix_of(anchors, lambda d: d * np.exp(rng.normal(0, 0.3, d.shape))), anchors)
    at = noisy.distance_m(np.linspace(0, 3, 50))
    assert (np.diff(at) >= 0).all()
    assert np.isnan(noisy.distance_m([np.nan])).all()


def test_a_calibration_that_falls_is_refused():
    with pytest.raises(InputError):
        DistanceCalibration([0.0, 1.0], [2.0, 1.0])
