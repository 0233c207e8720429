"""What the defaults of the command line reach on measured sweeps; needs the public data, see the README."""

import functools

import numpy as np
import pytest

from rfcompass.studies.measured import FAMILIES, proximity_trial, survey_trial, sweeps

pytestmark = pytest.mark.slow

# Largest median error along the path and in the plane [m], smallest share of tag pairs in the right order.
SURVEY_LIMITS = {"D1test": (0.04, 0.12, 0.98), "D2": (0.05, 0.16, 0.88), "D4": (0.05, 0.16, 0.92)}
# Smallest share of right comparisons, of all and of those with gaps of 20 cm and more.
PROXIMITY_LIMITS = {"D1train": (0.95, 0.95), "D1test": (0.95, 0.95), "D2": (0.90, 0.95), "D4": (0.90, 0.95)}


@pytest.fixture(autouse=True)
def _data(measured_data, monkeypatch):
    monkeypatch.setenv("RFCOMPASS_MEASURED_DATA", str(measured_data))


@functools.cache
def rows(trial, family, factor, value):
    cell, rng = {"family": family, factor: value}, np.random.default_rng(0)
    return [trial(cell, seed, rng) for seed in range(len(sweeps(family)))]


def pooled(trial, family, metric, factor, value):
    return np.concatenate([row[metric] for row in rows(trial, family, factor, value) if row[metric]])


def survey_of(family, metric):
    return pooled(survey_trial, family, metric, "method", "hyperbolic")


def comparisons_of(family, metric, kind):
    return pooled(proximity_trial, family, metric, "meter", kind)


@pytest.mark.parametrize("family", SURVEY_LIMITS)
def test_survey_locates_measured_tags(family):
    x_m, plane_m, order = SURVEY_LIMITS[family]
    assert np.median(survey_of(family, "x_error_m")) <= x_m
    assert np.median(survey_of(family, "plane_error_m")) <= plane_m
    assert np.mean(survey_of(family, "x_order")) >= order


def test_survey_finds_the_cross_range_of_the_other_campaign():
    assert (survey_of("UAB", "x_error_m") <= 0.12).all()
    assert np.median(survey_of("UAB", "x_error_m")) <= 0.04


@pytest.mark.parametrize("family", PROXIMITY_LIMITS)
def test_comparisons_of_the_default_meter_are_right(family):
    every, far = PROXIMITY_LIMITS[family]
    assert np.mean(comparisons_of(family, "correct", "auto")) >= every
    assert np.mean(comparisons_of(family, "correct_far", "auto")) >= far


def test_literal_pinit_is_no_better_than_a_coin_and_the_default_is():
    literal = np.concatenate([comparisons_of(f, "correct", "pinit_dtw") for f in ("D2", "D4")])
    default = np.concatenate([comparisons_of(f, "correct", "auto") for f in ("D2", "D4")])
    assert 0.4 < np.mean(literal) < 0.6
    assert np.mean(default) > np.mean(literal) + 0.3


def test_every_family_is_there():
    assert all(sweeps(family) for family in FAMILIES)
