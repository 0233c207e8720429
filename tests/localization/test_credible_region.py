"""Regions that hold what they say, no more than needed."""

import numpy as np
import pytest
from scipy import ndimage, stats

from rfcompass.geometry import polygon_area_m2, polygon_contains
from rfcompass.localization.credible_region import component_weights, credible_polygon, spread_on_grid

NOWHERE = np.array([30.0, 30.0])


def bell(sx=6.0, sy=3.0, size=61):
    x, y = np.meshgrid(np.arange(size) - 30.0, np.arange(size) - 30.0, indexing="ij")
    grid = np.exp(-(x**2) / (2 * sx**2) - y**2 / (2 * sy**2))
    return grid / grid.sum()


def held(grid, polygon):
    points = np.argwhere(grid > 0).astype(float)
    return grid[grid > 0][polygon_contains(polygon, points, -1e-9)].sum()


def test_spreading_keeps_weight_and_mean():
    rng = np.random.default_rng(0)
    points_m, weight = rng.normal(size=(50, 2)), rng.uniform(size=50)
    grid, first_m = spread_on_grid(points_m, weight, 0.07)
    x, y = (first + 0.07 * np.arange(n) for first, n in zip(first_m, grid.shape, strict=True))
    assert grid.sum() == pytest.approx(weight.sum())
    assert [grid.sum(axis=1) @ x, grid.sum(axis=0) @ y] == pytest.approx((weight @ points_m).tolist())
    assert grid[0].max() == grid[-1].max() == grid[:, 0].max() == grid[:, -1].max() == 0.0


@pytest.mark.parametrize("share", [0.3, 0.5, 0.9])
def test_the_region_of_a_bell_is_its_ellipse(share):
    grid = bell()
    polygon = credible_polygon(grid, share, NOWHERE)
    assert held(grid, polygon) >= share
    ellipse = np.pi * 6.0 * 3.0 * stats.chi2(2).ppf(share)
    assert ellipse < polygon_area_m2(polygon) < 1.3 * ellipse  # squares of the grid stick out


def test_more_probability_needs_more_room():
    grid = bell() + 0.3 * np.roll(bell(), 12, axis=1)
    areas = [polygon_area_m2(credible_polygon(grid, share, NOWHERE)) for share in (0.1, 0.5, 0.9, 0.99)]
    assert areas == sorted(areas)


def test_the_region_is_convex_counter_clockwise_and_holds_the_extra_point():
    polygon = credible_polygon(bell(), 0.5, np.array([55.0, 30.0]))
    edges = np.roll(polygon, -1, axis=0) - polygon
    turns = edges[:, 0] * np.roll(edges[:, 1], -1) - edges[:, 1] * np.roll(edges[:, 0], -1)
    assert (turns > 0).all()
    assert polygon_contains(polygon, np.array([[55.0, 30.0]]), 1e-9).all()


def test_sets_that_hang_together_are_those_of_an_independent_labelling():
    rng = np.random.default_rng(1)
    grid = rng.uniform(size=(20, 25)) ** 4
    label, count = ndimage.label(grid >= 0.3, structure=np.ones((3, 3)))
    expected = sorted(ndimage.sum_labels(grid, label, range(1, count + 1)), reverse=True)
    assert component_weights(grid, 0.3) == pytest.approx(expected)
