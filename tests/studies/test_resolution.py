"""Exact comparisons never rule out the truth; more of them never widen what is left; flips do harm."""

import numpy as np
import pytest

from rfcompass.geometry import Pose2
from rfcompass.studies.hand_moves import HandMoves, on_body
from rfcompass.studies.resolution import (
    AFTER,
    ARMS,
    DISC_M,
    HAND_M,
    METHODS,
    RESOLUTION,
    SURE,
    Measured,
    compare_at,
    draw_part,
    part_points_m,
    resolution_trial,
    robot_with,
)


def stops(policy, seed, count, flips=0.0):
    rng, robot, points_m = np.random.default_rng(seed), robot_with("skew6"), part_points_m()
    truth = draw_part(points_m, rng)
    measured = Measured(SURE)
    moves = HandMoves(robot, policy, points_m, SURE).configurations(truth, measured, rng)
    for _, now in zip(range(count), moves, strict=False):
        measured.configurations.append(now)
        measured.stops.append(compare_at(robot, now, truth, points_m, flips, rng))
    return measured, measured.configurations[-1].base.inverse() @ truth


@pytest.mark.parametrize("policy", ["sweep", "random", "active"])
def test_exact_comparisons_hold_at_the_truth_whatever_the_robot_does(policy):
    measured, truth = stops(policy, 3, 3)
    for stop in measured.in_newest_frame():
        assert stop.satisfied(truth, 1e-9).all()


def test_a_share_of_the_answers_is_flipped():
    measured, truth = stops("sweep", 4, 10, flips=0.1)
    held = np.concatenate([stop.satisfied(truth, 0.0) for stop in measured.in_newest_frame()])
    assert held.mean() == pytest.approx(0.9, abs=4 * np.sqrt(0.09 / held.size))


def test_the_part_lies_within_reach_of_the_hand_and_not_under_the_robot():
    rng, points_m = np.random.default_rng(0), part_points_m()
    for _ in range(200):
        pose = draw_part(points_m, rng)
        assert np.linalg.norm(pose.translation_m - HAND_M) <= DISC_M
        assert not on_body(pose, points_m)
    assert on_body(Pose2(), points_m)


def test_every_method_answers_after_every_count_of_exact_stops_and_gets_better():
    found = resolution_trial({"arm": "skew, sweep", "flips": 0.0}, 5, np.random.default_rng(5))
    assert len(found) == 2 * len(METHODS) * len(AFTER)
    for method in METHODS:
        assert found[f"{method}_centre_{AFTER[-1]}_m"] < 0.03
        assert found[f"{method}_centre_{AFTER[-1]}_m"] < max(found[f"{method}_centre_1_m"], 0.01)


def test_all_arms_are_declared_and_the_main_one_has_a_thousand_runs():
    assert set(RESOLUTION.factors["arm"]) == set(ARMS)
    main = [seed for seed in RESOLUTION.seeds if RESOLUTION.applies({"arm": "skew, sweep"}, seed)]
    assert len(main) == 1000
    assert not set(RESOLUTION.seeds) & set(RESOLUTION.tuning_seeds)
