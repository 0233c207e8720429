"""What a posterior over poses answers: moments, regions, modes and levels agree with each other and with samples."""

import numpy as np
import pytest

from rfcompass.geometry import Pose2, polygon_contains
from rfcompass.localization.pose_posterior import PosePosterior

HALF = np.array([0.005, np.pi / 128])
HUB_M = np.array([0.03, -0.02])


def tiled(density, reach=(0.12, 0.12, 1.2), centre=(0.3, 0.1, 0.7)):
    """All cells about a centre, weighed by a density of (x, y, θ) of the hub."""
    axes = [
        np.arange(np.floor((c - r) / (2 * h)), np.ceil((c + r) / (2 * h))) * 2 * h + h
        for c, r, h in zip(centre, reach, HALF[[0, 0, 1]], strict=True)
    ]
    cells = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    weight = density(cells)
    kept = weight > 1e-6 * weight.max()
    return PosePosterior(cells[kept], weight[kept] / weight[kept].sum(), HALF, HUB_M)


def bell(sd=(0.02, 0.03, 0.2), centre=(0.3, 0.1, 0.7)):
    return tiled(lambda cells: np.exp(-0.5 * (((cells - centre) / sd) ** 2).sum(axis=1)))


def test_moments_are_those_of_many_samples():
    posterior = bell()
    samples = posterior.samples(20_000)
    assert posterior.mean_m == pytest.approx(samples[:, :2].mean(axis=0), abs=5e-4)
    assert posterior.theta_rad == pytest.approx(samples[:, 2].mean(), abs=5e-3)
    assert posterior.covariance == pytest.approx(np.cov(samples.T), abs=2e-3, rel=0.05)


def test_the_mode_is_the_top():
    assert bell().poses[bell().weight.argmax()] == pytest.approx(bell().mode)
    hub_m = Pose2(*bell().mode).apply(HUB_M)
    assert hub_m == pytest.approx([0.3, 0.1], abs=1.01 * HALF[0])


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_the_region_holds_its_share_of_the_samples(share):
    posterior = bell()
    inside = polygon_contains(posterior.region(share), posterior.samples(20_000)[:, :2])
    assert share - 0.01 <= inside.mean() <= share + 0.07  # whole squares of 1 cm, σ 2 to 3 cm


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_the_interval_of_theta_holds_its_share(share):
    low, high = bell().theta_interval(share)
    turned = (bell().samples(20_000)[:, 2] - low) % (2 * np.pi)
    assert share - 0.01 <= (turned <= high - low).mean() <= share + 0.06


def test_levels_of_poses_drawn_from_the_posterior_are_uniform():
    posterior = bell()
    levels = np.sort([posterior.level(Pose2(*pose)) for pose in posterior.samples(400)])
    # Kolmogorov and Smirnov's bound at 99 %
    assert np.abs(levels - (np.arange(400) + 0.5) / 400).max() < 1.63 / np.sqrt(400)
    assert posterior.level(Pose2(9.0, 9.0, 0.0)) == 1.0


def test_all_orientations_alike_give_no_theta():
    posterior = tiled(
        lambda cells: np.exp(-0.5 * (((cells - [0.3, 0.1, 0.0])[:, :2] / 0.02) ** 2).sum(axis=1)),
        (0.12, 0.12, np.pi - 1e-9),
        (0.3, 0.1, 0.0),
    )
    assert posterior.theta_rad is None
    assert posterior.theta_interval(0.9) is None
    assert posterior.theta_information == pytest.approx(0.0, abs=1e-9)
    assert np.isnan(posterior.covariance[2]).all()
    assert np.isfinite(posterior.covariance[:2, :2]).all()


def test_a_leg_that_may_lie_either_way_has_no_theta_but_information():
    def either_way(cells):
        return np.exp(-0.5 * (((cells - [0.3, 0.1, 0.0])[:, :2] / 0.02) ** 2).sum(axis=1)) * np.exp(
            8.0 * np.cos(2 * (cells[:, 2] - 0.7))
        )

    posterior = tiled(either_way, (0.12, 0.12, np.pi - 1e-9), (0.3, 0.1, 0.0))
    assert posterior.theta_rad is None
    assert posterior.theta_information > 0.5


def test_places_apart_are_modes_of_their_own():
    def two(cells):
        near, far = cells[:, :2] - [0.24, 0.1], cells[:, :2] - [0.36, 0.1]
        return 0.7 * np.exp(-0.5 * (near**2).sum(axis=1) / 0.012**2) + 0.3 * np.exp(
            -0.5 * (far**2).sum(axis=1) / 0.012**2
        )

    posterior = tiled(two, (0.15, 0.08, 0.03))
    assert posterior.modes[:2] == pytest.approx([0.7, 0.3], abs=0.03)
    assert len(bell().modes) == 1


def test_samples_are_always_the_same_and_may_be_none():
    assert np.array_equal(bell().samples(50), bell().samples(50))
    assert bell().samples(0).shape == (0, 3)


def test_theta_is_found_across_the_seam():
    posterior = tiled(
        lambda c: np.exp(-0.5 * (((c - [0.3, 0.1, np.pi]) / [0.02, 0.02, 0.2]) ** 2).sum(axis=1)),
        centre=(0.3, 0.1, np.pi),
    )
    assert np.cos(posterior.theta_rad - np.pi) == pytest.approx(1.0, abs=1e-4)
    assert posterior.covariance[2, 2] == pytest.approx(0.2**2, rel=0.1)
