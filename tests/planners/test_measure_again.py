"""Measure again first? Only if that is expected to help, and by as much as it then does."""

from dataclasses import replace

import numpy as np
import pytest
from grasp_scenes import LEG, ROBOT, SCAN, estimate
from scipy.stats import multivariate_normal

from planners.grasp import GraspPlanner
from planners.hand_stops import HandStops
from planners.hypothetical_stop import Hearing
from planners.measure_again import AgainRules, MeasureAgain
from rfcompass.localization import NoiseModel
from rfcompass.robots.hand import hand_of, judge_grasps
from rfcompass.types import GraspPlan, PartEstimate
from rfcompass.types.stops import ProposedStop

HAND = hand_of(ROBOT)
TAGS = LEG.layout(4)
GOOD = NoiseModel(alpha_m=0.01, bias_m=0.005)
VAGUE = estimate(sd_m=0.012, sd_deg=6.0, samples=600)


@pytest.fixture(scope="module")
def vague_plan():
    found = GraspPlanner(ROBOT).plan(LEG, VAGUE)
    assert isinstance(found, GraspPlan)
    assert 0.2 < found.success_probability < 0.8
    return found


def adviser(noise=GOOD, **rules):
    return MeasureAgain(ROBOT, HAND, HandStops(robot=ROBOT, count=12), noise, AgainRules(**rules))


def advise(plan, where=VAGUE, noise=GOOD, seed=0, **rules):
    return adviser(noise, **rules).advise(plan, LEG, where, SCAN, TAGS, np.random.default_rng(seed))


def test_a_vague_estimate_is_worth_another_stop(vague_plan):
    advice = advise(vague_plan)
    assert advice.success_now == vague_plan.success_probability
    assert advice.success_after > advice.success_now + 0.05
    assert isinstance(advice.stop, ProposedStop)
    said = f"success would rise from {advice.success_now:.2f} to {advice.success_after:.2f}"
    assert said in advice.message
    assert replace(vague_plan, advice=advice).advice is advice


def test_equal_questions_get_equal_advice(vague_plan):
    first, again = advise(vague_plan), advise(vague_plan)
    assert first.success_after == again.success_after
    assert np.array_equal(first.stop.configuration.joints, again.stop.configuration.joints)


def test_a_sure_grasp_needs_no_other_stop():
    sure = estimate(sd_m=0.001, sd_deg=0.5)
    plan = GraspPlanner(ROBOT).plan(LEG, sure)
    assert plan.success_probability > 0.97
    assert advise(plan, sure) is None


def test_a_meter_that_tells_nothing_is_not_asked_again(vague_plan):
    assert advise(vague_plan, noise=NoiseModel(alpha_m=2.0, bias_m=1.0)) is None


def test_a_point_estimate_has_nothing_to_gain():
    point = PartEstimate(LEG.part_id, [0.42, 0.03], 1.4, "told", 1, LEG.resting_height_m)
    assert advise(GraspPlanner(ROBOT).plan(LEG, point), point) is None


def outlook(plan, noise, outcomes=60):
    measuring = adviser(noise, outcomes=outcomes)
    points_m = TAGS.points_m + np.array([0.0, 0.0, LEG.resting_height_m])
    hearing = Hearing(ROBOT.tag_positions(SCAN).points_m, points_m)
    return measuring.successes(plan, LEG, VAGUE.samples, hearing, np.random.default_rng(2))


def test_a_better_meter_promises_more_and_a_useless_one_what_there_is(vague_plan):
    coarse, fine = outlook(vague_plan, NoiseModel(alpha_m=0.05)), outlook(vague_plan, NoiseModel(0.005, bias_m=1e-3))
    assert fine.mean() > coarse.mean() + 0.1
    useless = outlook(vague_plan, NoiseModel(alpha_m=5.0, bias_m=5.0))
    assert useless.mean() == pytest.approx(vague_plan.success_probability, abs=0.06)


def test_what_is_promised_is_how_often_a_grasp_after_such_a_stop_holds(vague_plan):
    """Draw truths, measure, aim at the posterior mean, and judge at the truth itself: written out, one at a time."""
    promised = outlook(vague_plan, GOOD, outcomes=150)
    rng = np.random.default_rng(5)
    anchors_m = ROBOT.tag_positions(SCAN).points_m
    poses = estimate(sd_m=0.012, sd_deg=6.0, samples=2000, seed=77).samples
    truths = estimate(sd_m=0.012, sd_deg=6.0, samples=300, seed=78).samples
    d = np.array([distances_m(pose, anchors_m) for pose in poses])
    noises = [normal_noise(k, poses.mean(axis=0), anchors_m) for k in range(d.shape[1])]
    held = []
    for truth in truths:
        logs = np.zeros(len(poses))
        for k, noise in enumerate(noises):
            measured = distances_m(truth, anchors_m)[k] + noise.rvs(random_state=rng)
            logs += noise.logpdf(measured - d[:, k])
        weights = np.exp(logs - logs.max())
        mean = weights @ poses / weights.sum()
        T_part_hand = np.linalg.inv(pose_matrix(truth)) @ pose_matrix(mean) @ vague_plan.T_part_hand
        held.append(judge_grasps(HAND, LEG.shape, T_part_hand[None])[0] == 0)
    assert np.mean(held) == pytest.approx(promised.mean(), abs=0.07)


def distances_m(pose, anchors_m):
    tags_m = (pose_matrix(pose) @ np.column_stack([TAGS.points_m, np.ones(4)]).T).T[:, :3]
    return np.linalg.norm(tags_m[:, None] - anchors_m, axis=2)


def pose_matrix(pose):
    x, y, theta = pose
    T = np.eye(4)
    T[:2, :2] = [[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]]
    T[:3, 3] = x, y, LEG.resting_height_m
    return T


def normal_noise(k, pose, anchors_m):
    """Errors of the distances of one tag: of their own, and of the tag's place."""
    tag_m = (pose_matrix(pose) @ [*TAGS.points_m[k], 1.0])[:3]
    towards = (tag_m - anchors_m) / np.linalg.norm(tag_m - anchors_m, axis=1)[:, None]
    covariance = GOOD.alpha_m**2 * np.eye(len(anchors_m)) + GOOD.bias_m**2 * towards @ towards.T
    return multivariate_normal(np.zeros(len(anchors_m)), covariance)


def test_rules_that_cannot_be_are_refused():
    for bad in ({"stops": 0}, {"outcomes": 0}, {"poses": 1}, {"least_rise": 2.0}):
        with pytest.raises(ValueError, match="AgainRules"):
            AgainRules(**bad)
