"""A part laid through places, and what its covariance claims."""

import numpy as np
import pytest
from scipy import optimize, stats

from rfcompass.geometry import Pose2, polygon_area_m2, polygon_contains
from rfcompass.localization.rigid_fit import fit_rigid_part, normal_ellipse, spatial_median

LEG_M = np.array([[-0.2, 0.0], [-0.07, 0.0], [0.07, 0.0], [0.2, 0.0]])
SKEW_M = np.array([[0.0, 0.1], [0.3, 0.15], [0.35, -0.05]])  # its mean lies far from its centre
TRUTH = Pose2(0.4, -0.1, 2.2)


@pytest.mark.parametrize("points_m", [LEG_M, SKEW_M, LEG_M[[0, 3]]])
def test_exact_places_give_the_pose(points_m):
    fit = fit_rigid_part(points_m, TRUTH.apply(points_m))
    assert fit.centre_m == pytest.approx(TRUTH.translation_m)
    assert fit.theta_rad == pytest.approx(TRUTH.theta_rad)
    assert fit.sd_m == 0.01


def test_one_place_far_off_hardly_matters():
    places_m = TRUTH.apply(LEG_M) + np.array([[0, 0], [0, 0.3], [0, 0], [0, 0]])
    fit = fit_rigid_part(LEG_M, places_m)
    assert np.hypot(*(fit.centre_m - TRUTH.translation_m)) < 0.01  # 7.5 cm by plain least squares


@pytest.mark.parametrize("points_m", [LEG_M, SKEW_M])
def test_the_covariance_is_that_of_many_fits(points_m):
    rng = np.random.default_rng(0)
    found = []
    for _ in range(3000):
        places_m = TRUTH.apply(points_m) + 0.01 * rng.normal(size=points_m.shape)
        fit = fit_rigid_part(points_m, places_m, 0.05)  # with so large an sd all weights are alike
        found.append([*fit.centre_m, fit.theta_rad])
    expected = fit_rigid_part(points_m, TRUTH.apply(points_m), 0.01).covariance
    scatter = np.cov(np.array(found).T)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs(scatter - expected).max() < 0.1 * scale.max()
    assert np.abs((scatter - expected) / scale).max() < 0.1  # 3000 fits know a variance to 2.6 %


def test_one_tag_and_tags_in_one_place_tell_no_orientation():
    one = fit_rigid_part(np.array([[0.1, 0.0]]), np.array([[1.0, 2.0]]))
    assert one.theta_rad is None
    assert np.sqrt(one.covariance[0, 0]) == pytest.approx(np.hypot(0.01, 0.1 / np.sqrt(2.0)))
    assert np.isnan(one.covariance[2]).all()
    assert fit_rigid_part(LEG_M, np.tile([1.0, 2.0], (4, 1))).theta_rad is None


def test_the_ellipse_holds_its_share():
    covariance = np.array([[0.04, 0.015], [0.015, 0.01]])
    polygon = normal_ellipse(np.array([1.0, -2.0]), covariance, 0.9)
    samples = np.random.default_rng(1).multivariate_normal([1.0, -2.0], covariance, 20_000)
    assert polygon_contains(polygon, samples).mean() == pytest.approx(0.9, abs=0.01)
    area = np.pi * np.sqrt(np.linalg.det(covariance)) * stats.chi2(2).ppf(0.9)
    assert polygon_area_m2(polygon) == pytest.approx(area, rel=0.01)


def test_the_spatial_median_has_the_smallest_sum_of_distances():
    points_m = np.random.default_rng(2).normal(size=(7, 2))

    def total(place_m):
        return np.hypot(*(points_m - place_m).T).sum()

    least = optimize.minimize(total, np.zeros(2), method="Nelder-Mead").fun
    assert total(spatial_median(points_m)) == pytest.approx(least, rel=1e-4)
    assert spatial_median(points_m[:2]) == pytest.approx(points_m[:2].mean(axis=0))
