"""Measuring ends when the samples say so."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError
from rfcompass.localization import StopRule
from rfcompass.types.estimate import PartEstimate


def estimate(samples, theta_rad=0.0):
    return PartEstimate("leg", np.zeros(2), theta_rad, "posterior", 1, samples=np.array(samples))


@given(share=st.integers(0, 100))
def test_the_share_is_that_of_the_samples_within_distance_and_angle(share):
    samples = np.zeros((100, 3))
    samples[share:, 0] = 0.02
    rule = StopRule()
    assert rule.share(estimate(samples)) == share / 100
    assert rule.met_by(estimate(samples)) == (share >= 90)


def test_half_a_turn_is_a_difference_unless_the_part_looks_the_same():
    samples = np.column_stack([np.zeros((10, 2)), np.full(10, np.pi)])
    assert StopRule().share(estimate(samples)) == 0.0
    assert StopRule(symmetry=2).share(estimate(samples)) == 1.0


def test_an_unknown_orientation_is_not_settled_unless_any_will_do():
    samples = np.zeros((10, 3))
    assert StopRule().share(estimate(samples, None)) == 0.0
    assert StopRule(within_rad=None).share(estimate(samples, None)) == 1.0


def test_an_estimate_without_samples_is_refused():
    with pytest.raises(InputError):
        StopRule().share(estimate(np.zeros((0, 3))))


@pytest.mark.parametrize("rule", [{"within_m": 0.0}, {"within_rad": -1.0}, {"probability": 1.0}, {"symmetry": 0}])
def test_rules_that_nothing_or_everything_meets_are_refused(rule):
    with pytest.raises(InputError):
        StopRule(**rule)
