"""How likely a grasp is to hold."""

from dataclasses import replace

import numpy as np
import pytest
from grasp_poses import kind, over
from hypothesis import given
from hypothesis import strategies as st

from planners import pose_samples, success_probability
from planners.success import part_frames
from rfcompass import YouBot
from rfcompass.errors import InputError, PartError, ShapeError
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import hand_of, judge_grasp
from rfcompass.types import Box, Cylinder, Failure, PartEstimate, Sphere
from rfcompass.types.grasp_noise import GraspNoise

HAND = hand_of(YouBot())
LEG = PartDatabase(":memory:").part("table_leg_3")
COVARIANCE = np.diag([0.01**2, 0.01**2, 0.06**2])
HEIGHT_M = LEG.resting_height_m


def estimate(theta=0.3, **kwargs):
    return PartEstimate("table_leg_3", np.array([0.42, 0.01]), theta, "test", 1, HEIGHT_M, **kwargs)


def above(pose):
    """Hand over the middle of a leg at a pose, `T_base_hand`."""
    return np.linalg.inv(part_frames(np.array([[pose.x_m, pose.y_m, pose.theta_rad]]), HEIGHT_M)[0]) @ over()


def test_a_certain_pose_under_the_hand_is_certain_to_be_held():
    pose = Pose2(0.42, 0.01, 0.3)
    chance = success_probability(HAND, LEG, above(pose), np.array([[0.42, 0.01, 0.3]] * 100), HEIGHT_M)
    assert chance.probability == 1.0
    assert chance.risks == ()
    assert 0 < chance.standard_error < 0.02


def test_each_sample_counts_as_the_readable_judge_says():
    rng = np.random.default_rng(5)
    samples = pose_samples(estimate(covariance=4 * COVARIANCE), rng, 60)
    T = above(Pose2(0.42, 0.01, 0.3))
    kinds = [kind(judge_grasp(HAND, LEG.shape, F @ T, mass_kg=LEG.mass_kg)) for F in part_frames(samples, HEIGHT_M)]
    chance = success_probability(HAND, LEG, T, samples, HEIGHT_M)
    assert chance.probability == pytest.approx(np.mean([k == "holds" for k in kinds]))
    assert dict(chance.risks) == pytest.approx({k: kinds.count(k) / 60 for k in set(kinds) - {"holds"}})
    assert chance.probability + sum(share for _, share in chance.risks) == pytest.approx(1.0)


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3))
def test_the_chance_does_not_depend_on_where_the_base_stands(x, y, theta):
    rng = np.random.default_rng(6)
    samples = pose_samples(estimate(covariance=COVARIANCE), rng, 200)
    T = above(Pose2(0.42, 0.01, 0.3))
    moved = Pose2(x, y, theta)
    lifted = np.eye(4)
    lifted[:2, :2], lifted[:2, 3] = moved.rotation, moved.translation_m
    elsewhere = np.column_stack([moved.apply(samples[:, :2]), samples[:, 2] + theta])
    here, there = (
        success_probability(HAND, LEG, pose, at, HEIGHT_M) for pose, at in ((T, samples), (lifted @ T, elsewhere))
    )
    assert here.probability == pytest.approx(there.probability, abs=0.006)  # one near tie may fall either way


def test_a_wider_hand_and_a_surer_estimate_are_likelier_to_hold():
    T, chances = above(Pose2(0.42, 0.01, 0.3)), []
    for greatest_m, scale in ((0.075, 4.0), (0.075, 1.0), (0.10, 1.0)):
        samples = pose_samples(estimate(covariance=scale * COVARIANCE), np.random.default_rng(7), 2000)
        chances.append(success_probability(HAND.with_opening(greatest_m), LEG, T, samples, HEIGHT_M).probability)
    assert chances[0] < chances[1] < chances[2]


def test_noise_of_the_arm_and_of_friction_costs_success():
    rng = np.random.default_rng(8)
    samples = pose_samples(estimate(covariance=COVARIANCE), rng, 2000)
    T = above(Pose2(0.42, 0.01, 0.3))
    noisy = GraspNoise(position_m=0.01).draw(2000, rng)
    exact = success_probability(HAND, LEG, T, samples, HEIGHT_M)
    assert success_probability(HAND, LEG, T, samples, HEIGHT_M, draws=noisy).probability < exact.probability - 0.02


def test_a_part_above_the_payload_is_never_held():
    heavy = replace(LEG, mass_kg=0.7, inertia_kg_m2=LEG.inertia_kg_m2 * 4)
    chance = success_probability(HAND, heavy, above(Pose2()), np.zeros((10, 3)), HEIGHT_M)
    assert chance.probability == 0.0
    assert chance.risks == (("too_heavy", 1.0),)
    assert chance.standard_error > 0


def test_samples_of_an_estimate_are_its_own():
    own = np.random.default_rng(9).normal(size=(30, 3))
    drawn = pose_samples(estimate(samples=own), np.random.default_rng(1), 20)
    assert len(np.unique(drawn, axis=0)) == 20
    assert all((row == own).all(axis=1).any() for row in drawn)
    assert pose_samples(estimate(samples=own), np.random.default_rng(1), 50).shape == (50, 3)


def test_draws_have_the_covariance_of_the_estimate():
    drawn = pose_samples(estimate(covariance=COVARIANCE), np.random.default_rng(2), 20_000)
    np.testing.assert_allclose(drawn.mean(axis=0), [0.42, 0.01, 0.3], atol=2e-3)
    np.testing.assert_allclose(np.cov(drawn.T), COVARIANCE, atol=1e-4)


def test_a_point_estimate_is_one_pose_again_and_again():
    np.testing.assert_array_equal(pose_samples(estimate(), np.random.default_rng(3), 3), [[0.42, 0.01, 0.3]] * 3)


def test_without_orientation_only_a_round_thing_can_be_grasped():
    unknown = np.full((3, 3), np.nan)
    unknown[:2, :2] = COVARIANCE[:2, :2]
    blind = estimate(theta=None, covariance=unknown)
    for shape in (None, LEG.shape, Cylinder(0.02, 0.1, "x"), Box(np.full(3, 0.05))):
        refused = pose_samples(blind, np.random.default_rng(4), 10, shape=shape)
        assert isinstance(refused, Failure)
        assert refused.kind == "orientation_unknown"
    for shape in (Cylinder(0.02, 0.1, "z"), Sphere(0.03)):
        drawn = pose_samples(blind, np.random.default_rng(4), 1000, shape=shape)
        assert np.ptp(drawn[:, 2]) > 6
        assert drawn[:, :2].std(axis=0) == pytest.approx(0.01, rel=0.2)


def test_bad_input_is_named():
    rng, T = np.random.default_rng(0), above(Pose2())
    with pytest.raises(ShapeError, match="not finite"):
        estimate(covariance=np.full((3, 3), np.nan))
    with pytest.raises(InputError, match="no covariance"):
        pose_samples(estimate(covariance=np.diag([1.0, 1.0, -1.0])), rng, 5)
    with pytest.raises(InputError, match="at least 1"):
        pose_samples(estimate(), rng, 0)
    with pytest.raises(ShapeError, match="there are none"):
        success_probability(HAND, LEG, T, np.zeros((0, 3)), HEIGHT_M)
    with pytest.raises(ShapeError, match="not finite"):
        success_probability(HAND, LEG, T, np.full((2, 3), np.nan), HEIGHT_M)
    with pytest.raises(ShapeError, match="2 draws for 3 samples"):
        success_probability(HAND, LEG, T, np.zeros((3, 3)), HEIGHT_M, draws=GraspNoise().draw(2, rng))
    with pytest.raises(PartError, match="no rigid transform"):
        success_probability(HAND, LEG, np.zeros((4, 4)), np.zeros((3, 3)), HEIGHT_M)
