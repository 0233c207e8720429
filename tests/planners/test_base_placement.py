"""Where the base must stand: an answer puts the grasp into reach, and better knowledge never makes it less likely."""

import numpy as np
import pytest
from collision_scenes import ROBOT, at
from hypothesis import given
from hypothesis import strategies as st

from planners.base_placement import BasePlacement, PartGrasp, best_base_pose, inverse_map, shares
from planners.ik import IkRules, InverseKinematics
from planners.reachability import MapMaker
from planners.task_map import TaskMap, ToolDirections, top_down
from rfcompass.geometry import Pose2
from rfcompass.robots import CollisionModel, QuickCollisions
from rfcompass.types import Body, Box, GraspTask, PartEstimate, SearchVolume, Solution, World

SCAN = ROBOT.posture("scan")
IK = InverseKinematics(ROBOT, rules=IkRules(certify=False, explain=False))
MAP = MapMaker(ik=IK, spacing_m=0.02).make(SearchVolume([0.24, -0.2, 0.025], [0.56, 0.2, 0.065]), top_down(12), SCAN)
ACROSS = PartGrasp([0.0, 0.0], np.pi / 2, 0.03)


def estimate(x=1.0, y=0.5, theta=0.7, sd_m=0.0, sd_rad=0.0, **change):
    covariance = np.diag([sd_m**2, sd_m**2, sd_rad**2]) if sd_m else None
    return PartEstimate("leg", np.array([x, y]), theta, "test", 1, covariance=covariance, **change)


def place(est, grasps=(ACROSS,), seed=0, **options):
    return best_base_pose(est, MAP, list(grasps), rng=np.random.default_rng(seed), **options)


@given(x=st.floats(-2, 2), y=st.floats(-2, 2), theta=st.floats(-3.1, 3.1))
def test_from_the_place_it_names_the_grasp_is_solved(x, y, theta):
    answer = place(estimate(x, y, theta))
    assert answer.probability == 1.0
    part = answer.base.inverse() @ Pose2(x, y, theta)
    heading = part.theta_rad + ACROSS.closing_rad
    # The map knows twelve headings; the nearest is 7.5 degrees off at most, and is what it was asked for.
    heading = np.round(heading / (np.pi / 12)) * np.pi / 12
    task = GraspTask([part.x_m, part.y_m, ACROSS.height_m], [0, 0, -1.0], [np.cos(heading), np.sin(heading), 0])
    assert isinstance(IK.solve(task, SCAN), Solution)


def test_the_nearer_of_equally_good_places_is_taken():
    answer = place(estimate(0.42, 0.0, np.pi / 2))
    assert answer.travel_m < 0.05
    far = place(estimate(2.0, 0.0, np.pi / 2))
    assert 1.3 < far.travel_m < 1.75


def test_a_worse_estimate_is_less_likely_in_reach_and_a_place_in_the_middle_is_preferred():
    chances = [place(estimate(sd_m=sd, sd_rad=2 * sd)).probability for sd in (0.005, 0.03, 0.10, 0.20)]
    assert chances[0] > 0.99
    assert chances == sorted(chances, reverse=True)
    assert chances[-1] < 0.7


def test_the_probability_is_the_share_of_fresh_samples_that_are_in_reach():
    est = estimate(sd_m=0.05, sd_rad=0.1)
    answer = place(est)
    fresh = np.random.default_rng(9).multivariate_normal([1.0, 0.5, 0.7], est.covariance, 4000)
    bases = np.array([[answer.base.x_m, answer.base.y_m, answer.base.theta_rad]])
    share = shares(MAP, ACROSS, fresh, bases)[0]
    assert share == pytest.approx(answer.probability, abs=0.12)  # 3.3 SD of 200 samples, and the choice of the best


def test_samples_of_the_estimate_are_used():
    """Two places half a metre apart: no base reaches both, so one half is the best there is."""
    samples = np.concatenate([np.tile([0.5, y, np.pi / 2], (100, 1)) for y in (-0.5, 0.5)])
    answer = place(estimate(0.5, 0.5, np.pi / 2, samples=samples))
    assert answer.probability == pytest.approx(0.5, abs=0.01)


@given(seed=st.integers(0, 1000))
def test_the_fast_count_equals_a_look_up_in_the_map(seed):
    rng = np.random.default_rng(seed)
    samples = np.column_stack([rng.uniform(-0.2, 0.2, (20, 2)), rng.uniform(-3, 3, 20)])
    bases = np.column_stack([rng.uniform(-0.6, 0.6, (5, 2)), rng.uniform(-3, 3, 5)])
    grasp = PartGrasp(rng.uniform(-0.1, 0.1, 2), rng.uniform(-3, 3), rng.uniform(0.025, 0.065))
    headings = np.arctan2(MAP.directions.closing[:, 1], MAP.directions.closing[:, 0])
    for base, share in zip(bases, shares(MAP, grasp, samples, bases), strict=True):
        hits = 0
        for sample in samples:
            tool = Pose2(*base).inverse() @ Pose2(*sample) @ Pose2(*grasp.offset_m, grasp.closing_rad)
            off = np.abs(np.angle(np.exp(2j * (tool.theta_rad - headings))))
            point = np.array([[tool.x_m, tool.y_m, grasp.height_m]])
            hits += int(MAP.can(point, np.array([off.argmin()]))[0])
        assert share == pytest.approx(hits / len(samples))


def test_every_pose_of_the_inverse_map_brings_the_grasp_onto_a_voxel_that_can():
    grasp = PartGrasp([0.1, 0.02], 0.3, 0.025)
    bases = inverse_map(MAP, grasp)
    assert len(bases) == 2 * MAP.reached[:, :, 0].sum()
    part = Pose2(0, 0, 0)
    for base in bases[:: len(bases) // 50]:
        tool = Pose2(*base).inverse() @ part @ Pose2(*grasp.offset_m, grasp.closing_rad)
        x, y = np.round((np.array([tool.x_m, tool.y_m]) - MAP.origin_m[:2]) / MAP.spacing_m).astype(int)
        assert MAP.reached[x, y, 0].any()
    assert len(inverse_map(MAP, PartGrasp([0, 0], 0, 1.0))) == 0


def test_a_place_where_the_robot_would_touch_something_is_passed_over():
    free = place(estimate())
    block = Body("block", Box(np.array([0.3, 0.3, 0.5])), at(free.base.x_m - 0.2, free.base.y_m, 0.25))
    checker = QuickCollisions(CollisionModel(ROBOT, World((block,))))
    answer = place(estimate(), posture=SCAN, checker=checker)
    assert isinstance(answer, BasePlacement)
    assert answer.blocked > 0
    assert not checker.collides(ROBOT.configuration(SCAN.joints, answer.base))
    everywhere = QuickCollisions(
        CollisionModel(ROBOT, World((Body("hall", Box(np.array([9.0, 9, 1])), at(0, 0, 0.5)),)))
    )
    failure = place(estimate(), posture=SCAN, checker=everywhere)
    assert failure.kind == "scene_collision"


def test_the_better_of_two_grasps_is_chosen():
    high = PartGrasp([0.0, 0.0], np.pi / 2, 1.0)
    assert place(estimate(), (high, ACROSS)).grasp is ACROSS
    assert place(estimate(), (high,)).kind == "unreachable"
    assert place(estimate(), ()).kind == "unreachable"


def test_without_an_orientation_there_is_no_heading_for_the_jaws():
    assert place(estimate(theta=None)).kind == "orientation_unknown"


def test_a_map_of_tilted_tools_is_no_map_for_grasps_from_above():
    tilted = TaskMap(MAP.origin_m, 0.02, ToolDirections(np.eye(3)[:1], np.eye(3)[1:2]), MAP.reached[..., :1])
    with pytest.raises(ValueError, match="down"):
        best_base_pose(estimate(), tilted, [ACROSS], rng=np.random.default_rng(0))
