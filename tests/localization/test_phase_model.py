"""The phase model is exact in free space, and knows how far correlated errors move a fit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from survey_scenes import RAIL_M, reads_of

from rfcompass.localization.phase_model import PathCovariance, build_phase_model
from rfcompass.types import SearchVolume

PLANE = SearchVolume([-0.5, 0.2, 0.0], [1.5, 1.5, 0.0])
points = st.tuples(st.floats(0.0, 1.0), st.floats(0.4, 1.2), st.just(0.0)).map(np.array)


@given(points, points)
def test_at_the_tag_nothing_is_left_wherever_the_phases_were_unwrapped(tag_m, near_m):
    model = build_phase_model(reads_of(tag_m))
    assert np.abs(model.residuals(tag_m, model.lags(near_m))).max() < 1e-6


def test_half_turns_are_unwrapped_away_if_the_phase_is_known_modulo_pi():
    model = build_phase_model(reads_of([0.4, 0.7, 0.0], modulus_rad=np.pi))
    tag_m = np.array([0.4, 0.7, 0.0])
    assert np.abs(model.residuals(tag_m, model.lags(tag_m + 0.01))).max() < 1e-6


@given(points, st.integers(0, 2))
def test_the_jacobian_is_the_derivative(point_m, axis):
    model = build_phase_model(reads_of([0.4, 0.7, 0.0]))
    lags, step = model.lags(point_m), 1e-5 * np.eye(3)[axis]
    slope = (model.residuals(point_m + step, lags) - model.residuals(point_m - step, lags)) / 2e-5
    assert np.allclose(model.jacobian(point_m)[:, axis], slope, atol=1e-3)


@given(st.floats(0.1, 2.0), st.floats(0.0, 1.0))
def test_a_correlation_is_one_at_home_and_never_negative(length, noise):
    R = PathCovariance(length_wavelengths=length, noise=noise).correlation(RAIL_M, 0.33)
    assert np.allclose(np.diag(R), 1.0)
    assert np.linalg.eigvalsh(R).min() > -1e-9
    assert (np.diff(R[0, 1:]) <= 0).all()


def test_the_covariance_is_that_of_fits_to_correlated_errors():
    """Linear fits to many drawn errors scatter as predicted; taken for independent, they would scatter far less."""
    tag_m, sigma_rad = np.array([0.5, 0.7, 0.0]), 0.02
    model, shape = build_phase_model(reads_of(tag_m)), PathCovariance()
    predicted_m2 = model.fit_covariance(tag_m, sigma_rad**2, shape, PLANE)
    R = shape.correlation(RAIL_M, 299_792_458.0 / model.trace.frequencies_hz.mean())
    errors = np.random.default_rng(0).multivariate_normal(np.zeros(len(R)), sigma_rad**2 * R, 4000)
    jacobian = model.jacobian(tag_m)[: len(R), :2]  # of the first channel
    fits_m = errors @ np.linalg.pinv(jacobian).T
    assert np.allclose(np.sqrt(np.diag(np.cov(fits_m.T))), np.sqrt(np.diag(predicted_m2)), rtol=0.1)
    independent_m2 = sigma_rad**2 * np.linalg.inv(jacobian.T @ jacobian)
    assert (np.diag(predicted_m2) > 4 * np.diag(independent_m2)).all()


def test_channels_do_not_count_as_independent_witnesses():
    tag_m = np.array([0.5, 0.7, 0.0])
    all_of_them = reads_of(tag_m)
    one = type(all_of_them)(
        "tag", RAIL_M, all_of_them.frequencies_hz[1:2], all_of_them.channel[:, 1:2],
        all_of_them.read_counts[:, 1:2], all_of_them.antenna_ports,
    )  # fmt: skip
    many, single = (
        build_phase_model(t).fit_covariance(tag_m, 0.1, PathCovariance(), PLANE) for t in (all_of_them, one)
    )
    assert many == pytest.approx(single, rel=0.05)


@given(st.floats(0.05, 2.0))
def test_phases_are_worth_no_more_than_their_number_and_less_if_reflections_change_slowly(length):
    model = build_phase_model(reads_of([0.4, 0.7, 0.0]))
    shares = [model.independent_share(PathCovariance(length_wavelengths=scale * length)) for scale in (1.0, 2.0)]
    assert 0.0 < shares[1] < shares[0] <= 1.0


def test_channels_see_the_same_reflections_and_so_count_as_one():
    """With next to no correlation along the path, 41 positions in 3 channels are worth 41."""
    model = build_phase_model(reads_of([0.4, 0.7, 0.0]))
    share = model.independent_share(PathCovariance(length_wavelengths=1e-3))
    assert share == pytest.approx(1 / 3, rel=1e-6)
