"""What a meter's numbers are worth, by the robot's own tags."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated_scenes import FAR, NEAR, Errors, biased_stops
from scipy import optimize, stats

from rfcompass.localization.noise_kernels import comparison_fits, distance_noise, own_fix_errors
from rfcompass.localization.noise_model import LEAST_BIAS_M, fit_noise, noise_of, rank_correlation
from rfcompass.localization.placed_stop import place_stops
from rfcompass.localization.posterior import PosteriorLocalizer
from rfcompass.types import PartEstimate

ALPHAS_M = np.geomspace(0.005, 0.2, 9)
BETAS = np.array([0.01, 0.05, 0.2])


def placed(seed=0, **scene):
    return place_stops(biased_stops(np.random.default_rng(seed), **scene)[0])


def test_scale_and_noise_come_back():
    rng = np.random.default_rng(0)
    d = rng.uniform(0.1, 1.0, 4000)
    m = 7.0 * (d + 0.02 * rng.standard_t(4, d.size))
    scale, alpha_m, beta = distance_noise(d, m, ALPHAS_M, BETAS)
    assert scale == pytest.approx(7.0, rel=0.005)
    assert alpha_m == pytest.approx(0.02, rel=0.3)  # steps of the grid: a factor of 1.6
    assert beta == 0.01


def test_noise_that_grows_with_distance_is_told_from_noise_that_does_not():
    rng = np.random.default_rng(1)
    d = rng.uniform(0.1, 1.0, 4000)
    _, alpha_m, beta = distance_noise(d, d * (1.0 + 0.2 * rng.standard_t(4, d.size)), ALPHAS_M, BETAS)
    assert beta == 0.2
    assert alpha_m <= 0.01


def test_the_fit_is_the_likeliest_of_the_grid():
    rng = np.random.default_rng(2)
    d = rng.uniform(0.1, 1.0, 60)
    m = 2.0 * (d + 0.03 * rng.standard_t(4, d.size))

    def fit(c, alpha, beta):
        s = np.hypot(alpha, beta * d)
        return stats.t.logpdf((m / c - d) / s, 4).sum() - np.log(c * s).sum()

    found = distance_noise(d, m, ALPHAS_M, BETAS)
    best = max(
        -optimize.minimize_scalar(lambda c, a=a, b=b: -fit(c, a, b), bounds=(1.5, 2.5), method="bounded").fun
        for a in ALPHAS_M
        for b in BETAS
    )
    assert fit(*found) == pytest.approx(best, abs=0.05)


def test_comparisons_are_scored_as_a_slow_loop_scores_them():
    rng = np.random.default_rng(3)
    points_m = rng.uniform(-0.5, 0.5, (6, 3))
    d = np.linalg.norm(points_m[:, None] - points_m[None], axis=2)
    m = d * np.exp(0.2 * rng.normal(size=d.shape))
    m = (m + m.T) / 2.0
    m[0, 3] = m[3, 0] = np.nan
    scales, lapses = np.array([0.02, 0.1]), np.array([0.05, 0.5])
    fit, count, right = comparison_fits(d, m, scales, lapses)
    slow, asked, met = np.zeros((2, 2)), 0, 0
    for k in range(6):
        for i in range(6):
            for j in range(i):
                if k in (i, j) or np.isnan(m[k, i] + m[k, j]):
                    continue
                near, far = (i, j) if m[k, i] < m[k, j] else (j, i)
                lead, asked = d[k, far] - d[k, near], asked + 1
                met += lead > 0.0
                for a, s in enumerate(scales):
                    for b, lapse in enumerate(lapses):
                        slow[a, b] += np.log(lapse / 2 + (1 - lapse) / (1 + np.exp(-lead / s)))
    assert fit == pytest.approx(slow, abs=1e-9)
    assert (count, right) == (asked, met)


def test_an_anchor_seems_to_be_where_the_likelihood_of_its_distances_is_largest():
    rng = np.random.default_rng(4)
    anchors_m = np.column_stack([rng.uniform(-0.4, 0.4, (8, 2)), rng.uniform(0.0, 0.3, 8)])
    seem_m = anchors_m + np.pad(0.02 * rng.normal(size=(8, 2)), ((0, 0), (0, 1)))
    r_m = np.linalg.norm(seem_m[:, None] - seem_m[None], axis=2)
    np.fill_diagonal(r_m, np.nan)
    found = own_fix_errors(anchors_m, r_m, np.array([0.02, 0.0]), 0.1)
    for i in range(8):
        others = np.arange(8) != i

        def cost(shift, i=i, others=others):
            at = anchors_m[i] + np.array([*shift, 0.0])
            d = np.linalg.norm(at - anchors_m[others], axis=1)
            return (2.5 * np.log1p((r_m[i, others] - d) ** 2 / 0.02**2 / 4.0)).sum() + (shift @ shift) / (2 * 0.1**2)

        best = optimize.minimize(cost, np.zeros(2), method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-9}).x
        assert found[i] == pytest.approx(best, abs=2e-3)  # after five steps: a tenth of the noise


def test_an_anchor_with_two_distances_says_nothing():
    anchors_m = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    r_m = np.full((3, 3), 1.0)
    np.fill_diagonal(r_m, np.nan)
    assert np.isnan(own_fix_errors(anchors_m, r_m, np.array([0.02, 0.0]), 0.1)).all()


@pytest.mark.parametrize("scale", [0.01, 1.0, 40.0])
def test_the_units_of_the_meter_do_not_matter(scale):
    one, other = fit_noise(placed()), fit_noise(placed(scale=scale))
    assert other.scale == pytest.approx(scale * one.scale, rel=1e-6)
    for name in ("alpha_m", "beta", "bias_m", "comparison_m", "lapse", "rank_correlation", "right_share"):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-6)


def test_a_scan_that_is_heard_twice_from_one_place_counts_once():
    (stop,) = placed(M=1)
    once, twice = fit_noise([stop]), fit_noise([stop, stop])
    assert twice.pairs == once.pairs == 36
    for name in ("alpha_m", "bias_m", "scale"):
        assert getattr(twice, name) == pytest.approx(getattr(once, name), rel=1e-12)


def test_larger_biases_give_a_larger_bias_and_none_the_floor():
    def mean_bias_m(errors):
        return np.mean([fit_noise(placed(seed, M=3, errors=errors)).bias_m for seed in range(15)])

    near_m, far_m = mean_bias_m(NEAR), mean_bias_m(FAR)
    # The others are biased too, by which a fix is off a little more; 15 scenes tell σ to about 10 %.
    assert 0.9 * NEAR.bias_m < near_m < 1.35 * NEAR.bias_m
    assert 0.9 * FAR.bias_m < far_m < 1.35 * FAR.bias_m
    assert mean_bias_m(Errors(0.0, 0.001)) == LEAST_BIAS_M


def test_a_lower_floor_is_reached_where_nothing_is_biased_and_changes_nothing_elsewhere():
    exact, biased = placed(0, M=3, errors=Errors(0.0, 0.001)), placed(0, M=3, errors=FAR)
    assert fit_noise(exact, 0.003).bias_m < fit_noise(exact).bias_m == LEAST_BIAS_M
    assert fit_noise(biased, 0.003) == fit_noise(biased)


def test_five_pairs_tell_nothing():
    (stop,) = placed(M=1)
    few = np.full((9, 9), np.nan)
    few[0, 1:6] = few[1:6, 0] = stop.anchor_m[0, 1:6]
    model = fit_noise([replace(stop, anchor_m=few)])
    assert model.pairs == 5
    assert not model.measures_distance
    assert np.isnan(model.right_share)


def test_pure_guesses_do_not_measure_distance():
    (stop,) = placed(M=1)
    rng = np.random.default_rng(5)
    guesses = np.triu(rng.uniform(0.1, 1.0, (9, 9)), 1)
    guesses = guesses + guesses.T
    np.fill_diagonal(guesses, np.nan)
    assert not fit_noise([replace(stop, anchor_m=guesses)]).measures_distance


def test_rank_correlation_is_spearmans():
    rng = np.random.default_rng(6)
    a = rng.normal(size=40)
    b = a + rng.normal(size=40)
    assert rank_correlation(a, b) == pytest.approx(stats.spearmanr(a, b).statistic)
    assert rank_correlation(a, np.exp(a)) == pytest.approx(1.0)
    assert rank_correlation(a, np.zeros(40)) == 0.0


def test_the_noise_of_an_estimate_is_that_which_was_fitted():
    stops, _ = biased_stops(np.random.default_rng(0))
    inference = PosteriorLocalizer().infer(stops)
    told, fitted = noise_of(PosteriorLocalizer().estimate(stops)), inference.noise
    factor = inference.trusted.noise_factor
    assert told.alpha_m == factor * fitted.alpha_m
    assert told.beta == factor * fitted.beta
    assert told.measures_distance == fitted.measures_distance
    assert (told.comparison_m, told.pairs) == (fitted.comparison_m, fitted.pairs)
    assert told.bias_m >= fitted.bias_m


@pytest.mark.parametrize("diagnostics", [{}, {"alpha_m": 0.01}, {"alpha_m": None, "beta": 0.1, "bias_m": 0.01}])
def test_an_estimate_that_does_not_tell_its_noise_has_none(diagnostics):
    assert noise_of(PartEstimate("leg", [0.4, 0.0], 0.0, "told", 1, 0.025, diagnostics=diagnostics)) is None
