"""RF-Compass's localizer as printed: what it recovers, when it gives up, and what it reports as unknown."""

import numpy as np
import pytest
from compared_scenes import a_leg, distances, leg_points, random_observations, random_stops

from rfcompass.errors import Infeasible, InputError
from rfcompass.geometry import Pose2, polygon_area_m2, polygon_contains
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.comparing import compare_proximities
from rfcompass.localization.partition import PartitionLocalizer
from rfcompass.types import Comparisons, Observation, ProximityMatrix, TagPositions


@pytest.mark.parametrize("centre", ["analytic", "chebyshev", "centroid"])
def test_exact_comparisons_are_met_by_the_relaxed_solution_and_nearly_all_by_the_pose(centre):
    localizer, errors_m = PartitionLocalizer(centre=centre), []
    for seed in range(40):
        stops, truth = random_stops(np.random.default_rng(seed))
        fit = localizer.fit(stops)
        assert fit.epsilon == 0.0
        assert fit.satisfied_relaxed == fit.total == 432
        assert fit.satisfied >= 0.97 * fit.total
        assert polygon_contains(fit.region_m, np.array([fit.z[:2], truth.translation_m]), 1e-7).all()
        errors_m.append(np.hypot(*(fit.z[:2] - truth.translation_m)))
    assert np.median(errors_m) <= 0.013


def test_more_stops_help():
    def median_error_m(S):
        errors = []
        for seed in range(30):
            stops, truth = random_stops(np.random.default_rng(seed), S=S)
            errors.append(np.hypot(*(PartitionLocalizer().fit(stops).z[:2] - truth.translation_m)))
        return np.median(errors)

    assert median_error_m(3) < 0.5 * median_error_m(1)


def test_epsilon_rises_until_the_rest_agrees():
    """Small distance noise flips near-ties, whose margins are small."""
    reached = []
    for seed in range(20):
        observations, _ = random_observations(np.random.default_rng(seed), noise_m=0.01)
        estimate = PartitionLocalizer().estimate(observations)
        epsilon = estimate.diagnostics["epsilon"]
        assert abs(epsilon / 0.05 - round(epsilon / 0.05)) < 1e-9
        reached.append(epsilon)
        before = round(epsilon - 0.05, 12)
        if before >= 0.0:
            with pytest.raises(Infeasible):
                PartitionLocalizer(max_epsilon=before).estimate(observations)
    assert 0.0 < np.median(reached) <= 0.25


def test_the_schedule_ends_at_one_half_with_a_reason():
    m = np.array([[0.1, 1.0, 2.0]])
    there, swapped = compare_proximities(m), compare_proximities(m[:, ::-1])
    anchors_m = np.array([[0.0, 0, 0], [0.2, 0.1, 0], [0.4, 0, 0]])
    stops = [ComparedStop(anchors_m, leg_points(1), comparisons) for comparisons in (there, swapped)]
    with pytest.raises(Infeasible, match="consistency") as failure:
        PartitionLocalizer().fit(stops)
    assert failure.value.numbers["epsilon"] == 0.5
    assert failure.value.numbers["method"] == "consistency"


def test_contradictions_without_margins_fail_at_once_and_name_consistency():
    stops, _ = random_stops(np.random.default_rng(0), flips=0.1)
    with pytest.raises(Infeasible, match="consistency") as failure:
        PartitionLocalizer().fit(stops)
    assert failure.value.numbers["epsilon"] == 0.0


def test_nothing_to_compare_is_no_answer():
    (stop,), _ = random_observations(np.random.default_rng(0), S=1)
    silent = ProximityMatrix(
        stop.proximity.target_epcs, stop.proximity.anchor_epcs,
        np.full((4, 9), np.nan), stop.proximity.anchor_m, "distance",
    )  # fmt: skip
    with pytest.raises(Infeasible):
        PartitionLocalizer().estimate(
            [Observation(0, stop.anchors, stop.part, stop.part_tag_heights_m, proximity=silent)]
        )


def far_observation(distance_m, K=2):
    """A robot whose anchors lie on a small square, and a leg far away across the line of sight."""
    anchors_m = np.array([[0.05, 0.03, 0.1], [0.04, -0.06, 0.2], [-0.05, 0.05, 0.1], [-0.06, -0.03, 0.3]])
    truth = Pose2(distance_m, 0.3 * distance_m, 0.4)
    points_m = leg_points(K)
    m = distances(anchors_m, points_m, truth)
    robot = tuple("abcd")
    matrix = ProximityMatrix(a_leg(points_m).epcs, robot, m, np.full((4, 4), np.nan), "distance")
    return Observation(
        0, TagPositions("base", robot, anchors_m), a_leg(points_m), points_m[:, 2], proximity=matrix
    ), truth


def test_far_away_the_orientation_is_reported_as_unknown():
    stop, truth = far_observation(2.5)
    estimate = PartitionLocalizer().estimate([stop])
    assert estimate.theta_rad is None
    assert estimate.diagnostics["orientation_norm"] is None
    assert np.isnan(estimate.covariance[2]).all()
    assert abs(estimate.bearing_rad - np.arctan2(truth.y_m, truth.x_m)) < 0.5
    assert polygon_contains(estimate.region_m, truth.translation_m[None], 1e-6).all()


def test_near_by_the_orientation_is_known():
    for seed in range(20):
        observations, truth = random_observations(np.random.default_rng(seed))
        estimate = PartitionLocalizer().estimate(observations)
        assert abs((estimate.theta_rad - truth.theta_rad + np.pi) % (2 * np.pi) - np.pi) < 0.3
        assert 0.9 < estimate.diagnostics["orientation_norm"] < 1.0


def test_one_tag_at_the_centre_gives_a_position_only():
    for seed in range(10):
        observations, truth = random_observations(np.random.default_rng(seed), K=1)
        estimate = PartitionLocalizer().estimate(observations)
        assert estimate.theta_rad is None
        assert np.hypot(*(estimate.centre_m - truth.translation_m)) < 0.15


def test_the_bounds_hold():
    stop, _ = far_observation(2.5)
    bounds_m = np.array([[0.5, 2.0], [-1.0, 1.0]])
    estimate = PartitionLocalizer(bounds_m=bounds_m).estimate([stop])
    assert (bounds_m[:, 0] < estimate.centre_m).all()
    assert (estimate.centre_m < bounds_m[:, 1]).all()
    assert polygon_area_m2(estimate.region_m) <= 1.5 * 2.0 + 1e-9


def test_only_the_window_is_used():
    observations, _ = random_observations(np.random.default_rng(3), S=5)
    all_five, last_three = (PartitionLocalizer().estimate(seen) for seen in (observations, observations[2:]))
    assert all_five.stops == 3
    assert np.array_equal(all_five.centre_m, last_three.centre_m)


def test_both_solvers_and_extra_constraints_are_within_reach():
    observations, _ = random_observations(np.random.default_rng(0))
    fast = PartitionLocalizer().estimate(observations)
    slow = PartitionLocalizer(solver="cvxpy").estimate(observations)
    assert np.abs(fast.centre_m - slow.centre_m).max() < 1e-6
    limit = float(fast.centre_m[1]) - 1e-4
    walled = PartitionLocalizer(solver="cvxpy", extra_constraints=lambda z: [z[1] <= limit]).estimate(observations)
    assert walled.centre_m[1] <= limit + 1e-7


def test_the_height_of_the_part_is_passed_on():
    observations, _ = random_observations(np.random.default_rng(0))
    assert abs(PartitionLocalizer().estimate(observations).height_m - 0.05) < 1e-12


def test_a_schedule_that_does_not_rise_is_refused():
    observations, _ = random_observations(np.random.default_rng(0))
    with pytest.raises(InputError, match="epsilon_step"):
        PartitionLocalizer(epsilon_step=0.0).estimate(observations)


def test_comparisons_that_epsilon_drops_are_outliers():
    stops, _ = random_stops(np.random.default_rng(0), margins=True)
    first = stops[0].comparisons
    weakest = int(first.margin.argmin())
    nearer, farther = first.nearer.copy(), first.farther.copy()
    nearer[weakest], farther[weakest] = farther[weakest], nearer[weakest]
    wrong = Comparisons(first.target, nearer, farther, first.margin)
    fit = PartitionLocalizer().fit([
        ComparedStop(stops[0].anchors_m, stops[0].part_points_m, wrong, stops[0].T_newest_stop), *stops[1:],
    ])  # fmt: skip
    if fit.epsilon > 0.0:
        assert weakest in fit.outliers
    assert fit.total == 432
