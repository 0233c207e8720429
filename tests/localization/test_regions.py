"""What is drawn holds what it should, and only shrinks when more is known."""

import numpy as np
import pytest
from compared_scenes import random_stops
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.geometry import polygon_area_m2, polygon_contains
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.partition_solver import solve_partition
from rfcompass.localization.pose_set import pose_set
from rfcompass.localization.problem import build_partition
from rfcompass.localization.regions import convex_hull, region_polygon, tag_region, theta_interval


@pytest.mark.parametrize("K", [1, 2, 4])
def test_the_region_holds_the_true_centre_and_every_centre(K):
    for seed in range(10):
        stops, truth = random_stops(np.random.default_rng(seed), K=K)
        problem = build_partition(stops)
        region = region_polygon(problem)
        centres = [solve_partition(problem, centre=centre).z[:2] for centre in ("analytic", "chebyshev", "centroid")]
        assert polygon_contains(region, np.array([truth.translation_m, *centres]), 1e-7).all()
        assert polygon_contains(region, pose_set(problem).corners_m, 1e-7).all()


def test_each_tag_lies_in_its_own_region():
    for seed in range(10):
        stops, truth = random_stops(np.random.default_rng(seed))
        tags_m = truth.apply(stops[0].part_points_m)[:, :2]
        bounds_m = np.array([[-2.0, 2.0], [-2.0, 2.0]])
        for k, tag_m in enumerate(tags_m):
            cell = tag_region(stops, k, bounds_m=bounds_m)
            assert polygon_contains(cell, tag_m[None], 1e-9).all()


def test_more_comparisons_never_enlarge_region_and_interval():
    for seed in range(10):
        stops, _ = random_stops(np.random.default_rng(seed))
        bounds = build_partition(stops).bounds_m
        few = [
            ComparedStop(s.anchors_m, s.part_points_m, s.comparisons.take(np.arange(0, 144, 3)), s.T_newest_stop)
            for s in stops
        ]
        regions, intervals = [], []
        for chosen in (few, stops):
            problem = build_partition(chosen, bounds_m=bounds)
            theta = solve_partition(problem).theta_rad
            regions.append(region_polygon(problem))
            intervals.append(theta_interval(problem, theta))
        assert polygon_contains(regions[0], regions[1], 1e-7).all()
        assert polygon_area_m2(regions[1]) <= polygon_area_m2(regions[0])
        (low, high), (lower, higher) = intervals[1], intervals[0]
        shift = 2 * np.pi * round((lower - low) / (2 * np.pi))
        assert lower - 1e-6 <= low + shift
        assert high + shift <= higher + 1e-6


def test_the_interval_holds_the_true_orientation_and_that_of_every_pose():
    for seed in range(10):
        stops, truth = random_stops(np.random.default_rng(seed))
        problem = build_partition(stops)
        low, high = theta_interval(problem, solve_partition(problem).theta_rad)
        theta = np.append(pose_set(problem).theta_rad, truth.theta_rad)
        assert high - low < np.pi
        assert ((theta - low + 1e-6) % (2 * np.pi) <= high - low + 2e-6).all()


points = st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=3, max_size=30)


@given(points)
def test_a_hull_is_convex_and_holds_its_points(coordinates):
    cloud = np.round(np.array(coordinates), 6)
    hull = convex_hull(cloud)
    assert {tuple(p) for p in hull} <= {tuple(p) for p in cloud}
    if polygon_area_m2(hull) > 1e-6:
        assert polygon_contains(hull, cloud, 1e-9).all()
