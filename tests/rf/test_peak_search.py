"""Coarse to fine finds what an exhaustive search finds, also among side lobes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from survey_scenes import RAIL_M, reads_of

from rfcompass.rf.hologram import Matching, build_hologram
from rfcompass.rf.peak_search import coarse_peaks, grid_points, highest_peak, volume_axes
from rfcompass.types import SearchVolume

FIELD = SearchVolume([-0.5, -0.5, 0.0], [0.5, 0.5, 0.0])
coordinates = st.floats(-0.45, 0.45)


def bumps(places_m, heights, width_m):
    """A sum of round bumps."""

    def power_at(points_m):
        gaps_m = np.linalg.norm(points_m[:, None, :] - np.asarray(places_m), axis=2)
        return (np.asarray(heights) * np.exp(-((gaps_m / width_m) ** 2))).sum(axis=1)

    return power_at


@given(coordinates, coordinates)
def test_the_top_of_a_bump_is_found_to_the_resolution(x, y):
    peak = highest_peak(bumps([[x, y, 0.0]], [1.0], 0.05), FIELD, 0.3, keep=3, resolution_m=0.001)
    assert np.abs(peak.point_m - [x, y, 0.0]).max() < 0.001
    assert peak.power > 0.999


def test_a_lower_bump_that_the_coarse_grid_meets_better_does_not_win():
    step_m = 0.3 / 8
    on_grid, between = np.array([-0.5 + 6 * step_m, -0.5 + 6 * step_m, 0]), np.array([0.21, 0.17, 0.0])
    axes = volume_axes(FIELD, step_m)
    on_grid[:2] = axes[0][6], axes[1][6]
    between[:2] = (axes[0][20] + axes[0][21]) / 2, (axes[1][18] + axes[1][19]) / 2
    power_at = bumps([on_grid, between], [0.9, 1.0], 0.05)
    assert np.allclose(coarse_peaks(power_at, FIELD, 0.3, keep=1)[0].point_m, on_grid)
    assert np.allclose(highest_peak(power_at, FIELD, 0.3, keep=1, resolution_m=0.001).point_m, on_grid, atol=1e-3)
    assert np.allclose(highest_peak(power_at, FIELD, 0.3, keep=4, resolution_m=0.001).point_m, between, atol=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_no_point_of_a_fine_grid_beats_the_peak_of_a_noisy_hologram(seed):
    rng = np.random.default_rng(seed)
    clean = reads_of([0.4, 0.7, 0.0], seed=seed)
    noisy = type(clean)(
        clean.epc,
        RAIL_M,
        clean.frequencies_hz,
        clean.channel * np.exp(1j * rng.normal(0, 1.2, clean.channel.shape)),
        clean.read_counts,
        clean.antenna_ports,
    )
    volume = SearchVolume([-0.2, 0.2, 0.0], [1.2, 1.2, 0.0])
    hologram = build_hologram(noisy, volume, Matching())
    peak = highest_peak(hologram.power, volume, hologram.wavelength_m, keep=8, resolution_m=0.001)
    assert hologram.power(grid_points(volume_axes(volume, 0.005))).max() <= peak.power * (1 + 1e-6)


def test_the_grid_reaches_every_border_and_keeps_known_axes():
    x, y, z = volume_axes(SearchVolume([-1.0, 2.0, 0.5], [0.0, 2.7, 0.5]), 0.2)
    assert (x[0], x[-1], y[0], y[-1]) == (-1.0, 0.0, 2.0, 2.7)
    assert np.diff(x).max() <= 0.2 + 1e-12
    assert np.diff(y).max() <= 0.2 + 1e-12
    assert z.tolist() == [0.5]
    assert grid_points((x, y, z)).shape == (x.size * y.size, 3)
