"""What a stop that was not made would tell: weights are a posterior, and better meters tell more."""

import numpy as np
import pytest

from planners.hypothetical_stop import Hearing, posteriors
from rfcompass.localization import NoiseModel

ANCHORS_M = np.array([[0.3, 0.11, 0.06], [0.3, -0.11, 0.06], [0.42, 0.06, 0.19], [0.42, -0.06, 0.19], [0, 0.18, 0.06]])
TAGS_M = np.array([[-0.2, 0.0, 0.05], [0.2, 0.0, 0.05]])
HEARING = Hearing(ANCHORS_M, TAGS_M)


def poses(seed=0, count=400):
    rng = np.random.default_rng(seed)
    return rng.multivariate_normal([0.45, 0.0, 1.5], np.diag([0.03**2, 0.03**2, 0.2**2]), count)


def weigh(noise, outcomes=200, seed=1):
    rng = np.random.default_rng(seed)
    truths = rng.choice(400, outcomes)
    return truths, posteriors(poses(), truths, HEARING, noise, rng)


def spread(weights):
    """Mean standard deviation of x over the outcomes [m]."""
    x = poses()[:, 0]
    mean = weights @ x
    return float(np.sqrt(np.maximum(weights @ x**2 - mean**2, 0)).mean())


def test_offsets_are_those_of_the_tags_at_each_pose():
    z = poses(count=1)
    c, s = np.cos(z[0, 2]), np.sin(z[0, 2])
    tag = z[0, :2] + np.array([[c, -s], [s, c]]) @ TAGS_M[1, :2]
    assert HEARING.offsets_m(z)[0, 1, 2] == pytest.approx([*(tag - ANCHORS_M[2, :2]), 0.05 - 0.19])


def test_weights_are_probabilities_and_the_truth_is_a_draw_from_them():
    truths, weights = weigh(NoiseModel())
    assert weights.shape == (200, 400)
    assert weights.sum(axis=1) == pytest.approx(np.ones(200))
    # So the weight of all that are less likely than the truth is spread evenly between 0 and 1.
    below = [row[row < row[t]].sum() + row[t] / 2 for row, t in zip(weights, truths, strict=True)]
    assert np.mean(below) == pytest.approx(0.5, abs=0.06)
    assert np.std(below) == pytest.approx(np.sqrt(1 / 12), abs=0.04)


def test_on_average_the_posterior_is_the_prior():
    _, weights = weigh(NoiseModel(), outcomes=2000)
    assert (weights.mean(axis=0) @ poses()).tolist() == pytest.approx(poses().mean(axis=0).tolist(), abs=0.01)


def test_a_better_meter_tells_more_and_a_bias_less():
    plain = spread(weigh(NoiseModel(bias_m=1e-4))[1])
    assert spread(weigh(NoiseModel(alpha_m=0.005, bias_m=1e-4))[1]) < 0.8 * plain
    assert spread(weigh(NoiseModel(bias_m=0.05))[1]) > 1.1 * plain


def test_a_meter_that_only_compares_is_taken_by_its_comparisons():
    bad = NoiseModel(alpha_m=0.001, comparison_m=0.2, pairs=30, rank_correlation=0.1)
    good = NoiseModel(alpha_m=0.001, comparison_m=0.2, pairs=30, rank_correlation=0.9)
    assert spread(weigh(bad)[1]) > 2 * spread(weigh(good)[1])
