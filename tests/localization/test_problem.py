"""The rows of the partition: exact comparisons hold at the true pose, in every frame and at every height."""

import numpy as np
import pytest
from compared_scenes import random_stops

from rfcompass.errors import Infeasible, InputError, ShapeError
from rfcompass.geometry import Pose2
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.problem import bounds_about, build_partition, comparison_rows
from rfcompass.types import Comparisons


def unit_norm(pose):
    return np.array([pose.x_m, pose.y_m, np.cos(pose.theta_rad), np.sin(pose.theta_rad)])


@pytest.mark.parametrize("K", [1, 2, 3, 4])
def test_exact_comparisons_hold_at_the_true_pose(K):
    for seed in range(20):
        stops, truth = random_stops(np.random.default_rng(seed), K=K)
        rows = comparison_rows(stops, as_object=K == 1)
        assert rows.satisfied(unit_norm(truth)[: rows.A.shape[1]], 1e-12).all()
        assert len(rows) == sum(len(stop.comparisons) for stop in stops) == 3 * K * 36


def test_heights_and_all_stops_are_used():
    stops, truth = random_stops(np.random.default_rng(0))
    flat = [
        ComparedStop(s.anchors_m * [1, 1, 0], s.part_points_m * [1, 1, 0], s.comparisons, s.T_newest_stop)
        for s in stops
    ]
    misplaced = [ComparedStop(s.anchors_m, s.part_points_m, s.comparisons, Pose2()) for s in stops]
    for wrong in (flat, misplaced):
        assert not comparison_rows(wrong).satisfied(unit_norm(truth), 1e-3).all()


def test_a_part_with_one_tag_at_its_centre_has_two_unknowns():
    stops, _ = random_stops(np.random.default_rng(0), K=1)
    assert build_partition(stops).unknowns == 2
    off_centre = [
        ComparedStop(s.anchors_m, s.part_points_m + np.array([0.1, 0, 0]), s.comparisons, s.T_newest_stop)
        for s in stops
    ]
    assert build_partition(off_centre).unknowns == 4
    assert build_partition(off_centre, as_object=True).unknowns == 2


def test_the_bounds_are_rows_too():
    stops, _ = random_stops(np.random.default_rng(0))
    problem = build_partition(stops, bounds_m=np.array([[-1.0, 2.0], [-3.0, 4.0]]))
    A, b = problem.all_rows
    inside, outside = (
        np.array([1.9, 3.9, 0, 0]),
        np.array([[2.1, 0, 0, 0], [-1.1, 0, 0, 0], [0, 4.1, 0, 0], [0, -3.1, 0, 0]]),
    )
    assert (A[-4:] @ inside <= b[-4:]).all()
    assert ((A[-4:] @ outside.T > b[-4:, None]).sum(axis=0) == 1).all()


def test_the_default_bounds_lie_three_metres_about_all_anchors():
    stops, _ = random_stops(np.random.default_rng(0))
    anchors_m = np.vstack([stop.anchors_newest_m for stop in stops])[:, :2]
    bounds = build_partition(stops).bounds_m
    assert np.allclose(bounds, np.array([anchors_m.min(axis=0) - 3.0, anchors_m.max(axis=0) + 3.0]).T)
    assert np.allclose(bounds_about(anchors_m[:1], 0.25).mean(axis=1), anchors_m[0])


def test_epsilon_chooses_rows_by_their_margin():
    stops, _ = random_stops(np.random.default_rng(0), margins=True)
    margin = np.concatenate([stop.comparisons.margin for stop in stops])
    problem = build_partition(stops, epsilon=0.2, transitive_reduction=False)
    assert np.array_equal(problem.rows.provenance, np.flatnonzero(margin >= 0.2))
    assert 0 < len(problem.rows) < margin.size


def test_comparisons_without_margin_survive_every_epsilon():
    stops, _ = random_stops(np.random.default_rng(0))
    assert len(build_partition(stops, epsilon=0.5, transitive_reduction=False).rows) == 432


def test_anchors_above_each_other_make_no_row_unless_the_comparison_is_wrong():
    anchors_m, points_m = np.array([[0.0, 0, 0.1], [0, 0, 0.4], [0.3, 0, 0]]), np.zeros((1, 3))
    right, wrong = ([0, 0], [0, 0], [1, 2]), ([0, 0], [1, 0], [0, 2])
    for columns, rows in ((right, 1), (wrong, 2)):
        stop = ComparedStop(anchors_m, points_m, Comparisons(*columns, np.full(2, np.nan)))
        assert len(build_partition([stop]).rows) == rows


def test_nothing_to_build_from_is_said():
    stops, _ = random_stops(np.random.default_rng(0), margins=True)
    with pytest.raises(InputError):
        build_partition([])
    with pytest.raises(Infeasible, match=r"0\.99"):
        build_partition(stops, epsilon=0.99)
    with pytest.raises(ShapeError):
        build_partition(stops, bounds_m=np.array([[1.0, 0.0], [0.0, 1.0]]))
