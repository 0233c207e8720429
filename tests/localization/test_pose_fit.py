"""Counting what a pose meets, and handing it on as an estimate."""

import numpy as np
import pytest
from compared_scenes import random_observations, random_stops

from rfcompass.localization.compared_stop import compared_stops
from rfcompass.localization.partition import PartitionLocalizer
from rfcompass.localization.pose_fit import judge


def test_the_truth_meets_all_and_the_opposite_meets_few():
    for seed in range(10):
        stops, truth = random_stops(np.random.default_rng(seed))
        z = np.array([truth.x_m, truth.y_m, np.cos(truth.theta_rad), np.sin(truth.theta_rad)])
        exact = judge(stops, z, truth.theta_rad)
        assert exact.relaxed == exact.met == exact.total == 432
        assert exact.broken.size == 0
        away = judge(stops, z + np.array([2.0, 0.0, 0.0, 0.0]), truth.theta_rad)
        assert away.met + away.broken.size == away.total
        assert away.met < exact.met


def test_one_millimetre_of_difference_is_forgiven_to_the_pose_not_to_the_relaxation():
    stops, truth = random_stops(np.random.default_rng(0))
    z = np.array([truth.x_m, truth.y_m, np.cos(truth.theta_rad), np.sin(truth.theta_rad)])
    shifts = [judge(stops, z + np.array([step, 0, 0, 0]), truth.theta_rad) for step in np.linspace(0, 0.02, 41)]
    assert all(verdict.relaxed <= verdict.met for verdict in shifts)
    assert any(verdict.relaxed < verdict.met for verdict in shifts)


def test_without_theta_the_tags_count_as_lying_at_the_centre():
    stops, _ = random_stops(np.random.default_rng(0))
    at_centre = [stop.as_object() for stop in stops]
    for theta in (0.0, 1.0, 2.0):
        assert judge(stops, np.zeros(2), None).met == judge(at_centre, np.zeros(2), theta).met


def test_an_estimate_carries_the_evidence():
    observations, _ = random_observations(np.random.default_rng(0))
    fit = PartitionLocalizer().fit(compared_stops(observations))
    estimate = fit.to_estimate(observations, "partition")
    assert estimate.method == "partition"
    assert estimate.part_id == "leg"
    assert np.array_equal(estimate.centre_m, fit.z[:2])
    for key in ("epsilon", "orientation_norm", "satisfied_relaxed", "satisfied", "total", "radius_m"):
        assert key in estimate.diagnostics
    assert estimate.diagnostics["orientation_norm"] == pytest.approx(np.hypot(*fit.z[2:]))
