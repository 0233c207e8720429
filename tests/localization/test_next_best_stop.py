"""A stop is worth what its answers would tell the poses in question apart, and no more for saying it twice."""

import numpy as np
import pytest
from compared_scenes import leg_points
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.errors import InputError
from rfcompass.geometry import Pose2
from rfcompass.localization import NoiseModel, next_best_stop
from rfcompass.localization.next_best_stop import LEAST_CHANCE

NOISE = NoiseModel(comparison_m=0.02, lapse=0.04)
seeds = st.integers(0, 2**31)


def some_poses(rng, count=40, spread_m=0.1):
    return np.column_stack([0.4 + spread_m * rng.normal(size=(count, 2)), rng.uniform(-np.pi, np.pi, count)])


def some_anchors(rng, N=5):
    return np.column_stack([rng.uniform(0.1, 0.7, (N, 2)), rng.uniform(0.05, 0.2, N)])


def printed_gain(poses, points_m, anchors_m, noise):
    """The docstring, one probability at a time."""
    answers = []
    for x, y, theta in poses:
        tags_m = Pose2(x, y, theta).apply(points_m)
        row = []
        for tag_m in tags_m:
            for i in range(len(anchors_m)):
                for j in range(i + 1, len(anchors_m)):
                    gap = np.linalg.norm(tag_m - anchors_m[j]) - np.linalg.norm(tag_m - anchors_m[i])
                    row.append(noise.lapse / 2 + (1 - noise.lapse) / (1 + np.exp(-gap / noise.comparison_m)))
        answers.append(row)
    p = np.array(answers)
    D = np.maximum((p * (1 - p)).mean(axis=0), LEAST_CHANCE)
    C = np.cov(p.T, bias=True)
    return 0.5 * np.log(np.linalg.det(np.eye(len(D)) + C / np.sqrt(np.outer(D, D))))


def gains(poses, stops, noise=NOISE, K=2):
    return next_best_stop(poses, leg_points(K), stops, np.ones(len(stops)), noise).gain_nat


@settings(max_examples=10)
@given(seed=seeds)
def test_the_gain_is_the_printed_one(seed):
    rng = np.random.default_rng(seed)
    poses, anchors_m = some_poses(rng), some_anchors(rng)
    assert gains(poses, [anchors_m])[0] == pytest.approx(printed_gain(poses, leg_points(2), anchors_m, NOISE), rel=1e-6)


@settings(max_examples=20)
@given(seed=seeds)
def test_a_further_anchor_never_tells_less(seed):
    rng = np.random.default_rng(seed)
    poses, anchors_m = some_poses(rng), some_anchors(rng, 6)
    fewer, all_ = gains(poses, [anchors_m[:5], anchors_m])
    assert all_ >= fewer - 1e-9


@settings(max_examples=20)
@given(seed=seeds)
def test_moving_poses_and_anchors_together_changes_nothing(seed):
    rng = np.random.default_rng(seed)
    poses, anchors_m = some_poses(rng), some_anchors(rng)
    T = Pose2(0.3, -0.7, 1.1)
    moved = np.column_stack([T.apply(poses[:, :2]), poses[:, 2] + T.theta_rad])
    assert gains(moved, [T.apply(anchors_m)])[0] == pytest.approx(gains(poses, [anchors_m])[0], rel=1e-9)


def test_who_knows_the_pose_learns_nothing():
    rng = np.random.default_rng(0)
    poses = np.tile([0.4, 0.0, 0.3], (20, 1))
    assert gains(poses, [some_anchors(rng)])[0] == pytest.approx(0.0, abs=1e-9)


def test_saying_the_same_twice_counts_much_less_than_twice():
    """With the answers of a pair doubled, its matrix has no further direction: log det(I + 2 C) < 2 log det(I + C)."""
    rng = np.random.default_rng(1)
    poses, anchors_m = some_poses(rng, 200), some_anchors(rng, 2)
    twin_m = np.vstack([anchors_m, anchors_m[:1] + 1e-9])
    once, twice = gains(poses, [anchors_m, twin_m], K=1)
    assert once < twice < once + np.log(2.0) / 2 + 1e-6


def test_time_counts():
    rng = np.random.default_rng(2)
    poses, anchors_m = some_poses(rng), some_anchors(rng)
    scores = next_best_stop(poses, leg_points(2), [anchors_m, anchors_m], np.array([30.0, 20.0]), NOISE)
    assert scores.best == 1


@pytest.mark.parametrize(
    ("poses", "stops", "seconds"),
    [(np.zeros((1, 3)), 1, [1.0]), (np.zeros((5, 3)), 0, []), (np.zeros((5, 3)), 1, [0.0])],
)
def test_nothing_to_choose_is_refused(poses, stops, seconds):
    anchors_m = some_anchors(np.random.default_rng(3))
    with pytest.raises(InputError):
        next_best_stop(poses, leg_points(2), [anchors_m] * stops, np.array(seconds))
