"""A tag's true place, once its bias is allowed for."""

import numpy as np
import pytest

from rfcompass.localization.tag_maps import WIDE_FACTOR, WIDE_SHARE, smeared_map

SD_M, PITCH_M = 0.02, 0.01


def scattered_cells(rng):
    """Some squares of 1 cm, and log likelihoods in them."""
    taken = np.argwhere(rng.uniform(size=(9, 6)) < 0.5)
    return 0.3 + PITCH_M * taken.astype(float), rng.normal(size=len(taken))


def slow_density(cells, log_weight, place_m):
    weight = np.exp(log_weight) / np.exp(log_weight).sum()
    total = 0.0
    for cell, w in zip(cells, weight, strict=True):
        off2 = np.sum((place_m - cell) ** 2)
        for share, sd in ((1 - WIDE_SHARE, SD_M), (WIDE_SHARE, WIDE_FACTOR * SD_M)):
            total += w * share * np.exp(-off2 / (2 * sd**2)) / (2 * np.pi * sd**2)
    return total


def grid_of(values, first_m, pitch_m):
    return np.stack(np.meshgrid(*(f + pitch_m * np.arange(n) for f, n in zip(first_m, values.shape, strict=True)),
                                indexing="ij"), axis=-1)  # fmt: skip


def test_the_map_is_a_mixture_of_normals_about_every_cell():
    cells, log_weight = scattered_cells(np.random.default_rng(0))
    values, first_m = smeared_map(cells, log_weight, PITCH_M, SD_M)
    places = grid_of(values, first_m, PITCH_M)
    middle = np.array(values.shape) // 2
    for off in [(0, 0), (3, -2), (-6, 5), (8, 8)]:
        i, j = middle + off
        assert np.exp(values[i, j]) == pytest.approx(slow_density(cells, log_weight, places[i, j]), rel=0.02)


def test_it_integrates_to_one_and_keeps_the_mean():
    cells, log_weight = scattered_cells(np.random.default_rng(1))
    values, first_m = smeared_map(cells, log_weight, PITCH_M, SD_M)
    mass = np.exp(values) * PITCH_M**2
    assert mass.sum() == pytest.approx(1.0, abs=2e-3)  # the tail of the wide part is cut at 3 σ of it
    mean = (mass[..., None] * grid_of(values, first_m, PITCH_M)).sum(axis=(0, 1)) / mass.sum()
    weight = np.exp(log_weight)
    assert mean == pytest.approx(weight @ cells / weight.sum(), abs=2e-4)


def test_the_variance_is_that_of_the_cells_and_of_the_bias():
    values, first_m = smeared_map(np.zeros((1, 2)), np.zeros(1), 0.005, SD_M)
    mass = np.exp(values) * 0.005**2
    variance = (mass[..., None] * grid_of(values, first_m, 0.005) ** 2).sum(axis=(0, 1)) / mass.sum()
    expected = (1 - WIDE_SHARE) * SD_M**2 + WIDE_SHARE * (WIDE_FACTOR * SD_M) ** 2
    assert variance == pytest.approx([expected] * 2, rel=0.03)
