"""The pose that agrees with the most: flips do little harm, and what is claimed is what is proven."""

import numpy as np
import pytest
from compared_scenes import random_observations, random_stops

from rfcompass.errors import Infeasible, InputError
from rfcompass.geometry import polygon_contains
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.consistency import ConsistencyLocalizer
from rfcompass.localization.partition import PartitionLocalizer
from rfcompass.types import Comparisons


def test_ten_per_cent_of_flips_cost_little():
    errors_m, turns = [], []
    for seed in range(40):
        stops, truth = random_stops(np.random.default_rng(seed), flips=0.1)
        fit = ConsistencyLocalizer().fit(stops)
        errors_m.append(np.hypot(*(fit.z[:2] - truth.translation_m)))
        turns.append(abs((fit.theta_rad - truth.theta_rad + np.pi) % (2 * np.pi) - np.pi))
        with pytest.raises(Infeasible):
            PartitionLocalizer().fit(stops)
    assert np.median(errors_m) <= 0.015
    assert np.median(turns) <= np.radians(5)


def test_exact_comparisons_give_the_centroid_of_the_partition():
    for seed in range(20):
        stops, _ = random_stops(np.random.default_rng(seed))
        fit, exact = ConsistencyLocalizer(margin_m=1e-5).fit(stops), PartitionLocalizer(centre="centroid").fit(stops)
        assert fit.diagnostics["best"] + fit.gap >= fit.total
        if fit.diagnostics["best"] == fit.total:
            assert np.abs(fit.z - exact.z).max() < 1e-6


def test_the_gap_bounds_what_the_truth_could_meet():
    for seed in range(20):
        stops, truth = random_stops(np.random.default_rng(seed), flips=0.1)
        fit = ConsistencyLocalizer().fit(stops)
        strict = sum(int(stop.satisfied(truth, -2.1e-3).sum()) for stop in stops)  # 1 mm inside and more
        assert strict <= fit.diagnostics["best"] + fit.gap


@pytest.mark.parametrize("K", [1, 2, 4])
def test_a_tenth_of_flips_leaves_nothing_open(K):
    for seed in range(10):
        stops, truth = random_stops(np.random.default_rng(seed), flips=0.1, K=K)
        fit = ConsistencyLocalizer().fit(stops)
        assert fit.gap == 0
        assert fit.diagnostics["complete"]
        strict = sum(int(stop.satisfied(truth, -2.1e-3).sum()) for stop in stops)
        assert strict <= fit.diagnostics["best"]


def test_anchors_that_stay_where_they_are_leave_nothing_open_either():
    """Bisectors that coincide over stops, and three through one point for each three anchors."""
    for seed in range(5):
        rng = np.random.default_rng(seed)
        (stop,), _ = random_stops(rng, S=1)
        again = []
        for _ in range(3):
            wrong, c = rng.uniform(size=len(stop.comparisons)) < 0.1, stop.comparisons
            nearer, farther = np.where(wrong, c.farther, c.nearer), np.where(wrong, c.nearer, c.farther)
            comparisons = Comparisons(c.target, nearer, farther, c.margin)
            again.append(ComparedStop(stop.anchors_m, stop.part_points_m, comparisons))
        fit = ConsistencyLocalizer().fit(again)
        assert fit.gap == 0
        assert fit.diagnostics["complete"]


def test_outliers_are_mostly_the_flipped_ones():
    exact, _ = random_stops(np.random.default_rng(4))
    flipped, _ = random_stops(np.random.default_rng(4), flips=0.1)
    nearer = [np.concatenate([stop.comparisons.nearer for stop in stops]) for stops in (exact, flipped)]
    wrong = set(np.flatnonzero(nearer[0] != nearer[1]).tolist())
    found = set(ConsistencyLocalizer().fit(flipped).outliers.tolist())
    assert len(wrong & found) >= 0.9 * len(wrong)
    assert len(found) <= 1.1 * len(wrong)


def test_the_region_holds_the_estimate_and_satisfied_counts_add_up():
    for seed in range(10):
        stops, _ = random_stops(np.random.default_rng(seed), flips=0.1)
        fit = ConsistencyLocalizer().fit(stops)
        assert polygon_contains(fit.region_m, fit.z[None, :2], 1e-9).all()
        assert fit.satisfied + fit.outliers.size == fit.total
        low, high = fit.theta_interval_rad
        assert (fit.theta_rad - low) % (2 * np.pi) <= high - low


def test_one_tag_at_the_centre_gives_a_position_only():
    for seed in range(10):
        stops, truth = random_stops(np.random.default_rng(seed), K=1, flips=0.1)
        fit = ConsistencyLocalizer().fit(stops)
        assert fit.theta_rad is None
        assert fit.z.shape == (2,)
        assert np.hypot(*(fit.z - truth.translation_m)) < 0.3


def test_an_orientation_on_which_the_cells_do_not_agree_is_unknown():
    """One comparison of one tag off the centre says next to nothing about the turn."""
    stop = ComparedStop([[-0.5, 0, 0], [0.5, 0, 0]], np.array([[0.05, 0.0, 0.0]]), Comparisons([0], [1], [0], [np.nan]))
    fit = ConsistencyLocalizer().fit([stop])
    assert fit.theta_rad is None
    assert fit.z[0] > 0.0


def test_a_wrong_order_of_anchors_above_each_other_only_costs_itself():
    stops, _ = random_stops(np.random.default_rng(0), S=1, K=2)
    high = np.vstack([stops[0].anchors_m, stops[0].anchors_m[:1] + np.array([0.0, 0.0, 0.3])])
    c = stops[0].comparisons
    wrong = Comparisons(
        np.append(c.target, 0), np.append(c.nearer, 9), np.append(c.farther, 0), np.append(c.margin, np.nan)
    )
    fit = ConsistencyLocalizer(margin_m=1e-5).fit([ComparedStop(high, stops[0].part_points_m, wrong)])
    assert fit.diagnostics["best"] == len(c)
    assert fit.outliers.tolist() == [len(c)]


def test_noise_on_distances_is_survived_from_observations():
    errors_m = []
    for seed in range(10):
        observations, truth = random_observations(np.random.default_rng(seed), noise_m=0.01)
        estimate = ConsistencyLocalizer().estimate(observations)
        errors_m.append(np.hypot(*(estimate.centre_m - truth.translation_m)))
        assert estimate.covariance.shape == (3, 3)
    assert np.median(errors_m) < 0.05


def test_a_search_without_room_is_refused():
    stops, _ = random_stops(np.random.default_rng(0))
    with pytest.raises(InputError, match="max_boxes"):
        ConsistencyLocalizer(max_boxes=10).fit(stops)
    assert ConsistencyLocalizer(max_boxes=64).fit(stops).gap > 0


@pytest.mark.parametrize("name", ["margin_m", "leaf_m", "leaf_rad"])
@pytest.mark.parametrize("value", [0.0, -1e-3, float("nan")])
def test_a_margin_or_leaf_without_size_is_refused(name, value):
    stops, _ = random_stops(np.random.default_rng(0))
    with pytest.raises(InputError, match=f"{name} = .* is not above 0"):
        ConsistencyLocalizer(**{name: value}).fit(stops)


def test_when_every_comparison_is_wrong_everywhere_all_poses_tie():
    stop = ComparedStop(
        [[0.0, 0, 0.1], [0, 0, 0.4], [0.3, 0, 0]], np.zeros((1, 3)), Comparisons([0], [1], [0], [np.nan])
    )
    fit = ConsistencyLocalizer().fit([stop])
    assert fit.diagnostics["best"] == fit.satisfied == 0
    assert np.allclose(fit.z, [0.15, 0.0])


def test_the_answer_does_not_lie_between_cells_that_are_apart():
    """Two comparisons that hold at opposite ends: the middle would meet neither."""
    anchors_m = np.array([[0.0, 0, 0], [0.2, 0, 0], [2.0, 0, 0], [2.2, 0, 0]])
    stop = ComparedStop(anchors_m, np.zeros((1, 3)), Comparisons([0, 0], [0, 3], [1, 2], [np.nan, np.nan]))
    fit = ConsistencyLocalizer().fit([stop])
    assert fit.satisfied == fit.diagnostics["best"] == 1
