"""A local fit finds the place that its loss says; a pull moves it along what the phases leave open."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from survey_scenes import reads_of

from rfcompass.localization.phase_fit import Fit, PhaseFitter, Pull, distinct
from rfcompass.localization.phase_model import build_phase_model
from rfcompass.localization.tag_strength import tag_strength
from rfcompass.types import SearchVolume

PLANE = SearchVolume([-0.2, 0.3, 0.0], [1.2, 1.2, 0.0])
TAG_M = np.array([0.55, 0.7, 0.0])
TRACE = reads_of(TAG_M)
NEAR_M = TAG_M + np.array([0.03, -0.05, 0.0])
few = settings(max_examples=15, deadline=None)


def fitted(weight, pull=None):
    model = build_phase_model(TRACE)
    return PhaseFitter(model, PLANE, 0.3, weight).fit(NEAR_M, model.lags(NEAR_M), pull)


def pull_to(deviation_db, spread_db=1.5):
    """A common strength that is so far above the one that the tag has at its place."""
    strength = tag_strength(TRACE)
    return Pull(strength, strength.at(TAG_M) + deviation_db, spread_db)


def loss_by_hand(point_m, weight, pull):
    model = build_phase_model(TRACE)
    r = model.residuals(point_m, model.lags(NEAR_M)) / 0.3
    z = (pull.strength.at(point_m) - pull.common_db) / pull.spread_db
    return weight * np.sum(np.sqrt(1 + r**2) - 1) + np.sqrt(1 + z**2) - 1


def test_without_a_pull_the_tag_is_found_whatever_the_weight():
    for weight in (0.01, 1.0, 100.0):
        assert np.linalg.norm(fitted(weight).point_m - TAG_M) < 1e-3


def test_a_pull_to_the_strength_that_the_tag_has_changes_nothing():
    assert np.linalg.norm(fitted(0.01, pull_to(0.0)).point_m - TAG_M) < 1e-3


@given(st.floats(-8, 8), st.floats(0.001, 1.0))
@few
def test_the_loss_is_the_one_that_is_documented(deviation_db, weight):
    fit = fitted(weight, pull_to(deviation_db))
    assert fit.loss == pytest.approx(loss_by_hand(fit.point_m, weight, pull_to(deviation_db)), rel=1e-9)


@given(st.floats(-6, 6), st.floats(0.001, 0.1), st.integers(0, 3))
@few
def test_no_place_nearby_is_better(deviation_db, weight, quarter):
    fit = fitted(weight, pull_to(deviation_db))
    step_m = 0.005 * np.array([np.cos(quarter * np.pi / 2), np.sin(quarter * np.pi / 2), 0.0])
    assert loss_by_hand(fit.point_m + step_m, weight, pull_to(deviation_db)) >= fit.loss - 1e-9


@given(st.floats(0.5, 8.0))
@few
def test_a_tag_that_should_be_stronger_is_farther_off_and_a_heavy_phase_holds_it(deviation_db):
    loose, held = (fitted(weight, pull_to(deviation_db)).point_m[1] for weight in (0.002, 0.2))
    assert loose > held > TAG_M[1]


def test_a_fit_that_ran_into_the_border_loses_to_one_that_did_not():
    inside, border = Fit(TAG_M, (), 2.0), Fit(np.array([0.5, 1.2, 0.0]), (), 1.0)
    fitter = PhaseFitter(build_phase_model(TRACE), PLANE, 0.3, 1.0)
    assert fitter.best([border, inside]) is inside
    assert fitter.best([border]) is border


def test_fits_that_end_at_one_place_are_one_and_the_best_of_them_stays():
    here, same, there = Fit(TAG_M, (), 2.0), Fit(TAG_M + 1e-4, (), 1.0), Fit(TAG_M + 0.1, (), 1.5)
    assert distinct([here, same, there]) == [same, there]
