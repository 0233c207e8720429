"""Ways of arm and base: they touch nothing, keep the limits, go straight where that is free, or say why not."""

from itertools import pairwise

import numpy as np
import pytest
from collision_scenes import ROBOT, at
from hypothesis import given
from hypothesis import strategies as st

from planners.arm_path import plan_arm
from planners.motion_check import MotionChecker, between
from planners.navigation import plan_drive
from planners.path_search import FoundPath, SearchRules
from planners.path_timing import in_time
from rfcompass import Pose2
from rfcompass.robots import CollisionModel, FclCollisions, QuickCollisions
from rfcompass.types import Body, Box, Configuration, World

SCAN = ROBOT.posture("scan")
# A post in front of the arm: swinging from one side to the other meets it.
POST = Body("post", Box(np.array([0.05, 0.05, 0.6])), at(0.42, 0.0, 0.30))
WALL = Body("wall", Box(np.array([0.1, 2.0, 0.5])), at(1.2, 0.0, 0.25))


def checker(*bodies):
    return MotionChecker(QuickCollisions(CollisionModel(ROBOT, World(bodies))))


def aside(turn_rad):
    joints = SCAN.joints.copy()
    joints[0] += turn_rad
    return Configuration(joints)


def ask_arm(seed=0, bodies=(POST,), **rules):
    rng = np.random.default_rng(seed)
    return plan_arm(checker(*bodies), aside(-0.6), aside(0.6), rng, SearchRules(**rules))


def looks_free(path, bodies, count=40):
    """Let fcl look at many places along a path."""
    judge = FclCollisions(CollisionModel(ROBOT, World(bodies)))
    places = [between(a, b, t) for a, b in pairwise(path) for t in np.linspace(0, 1, count)]
    return not any(map(judge.collides, places))


def test_the_straight_way_is_taken_where_it_is_free():
    found = ask_arm(bodies=())
    assert (len(found.path), found.searched) == (2, 0)
    assert found.report.free


def test_the_arm_goes_around_a_post():
    found = ask_arm()
    assert isinstance(found, FoundPath)
    assert found.searched > 0
    assert found.report.free
    assert looks_free(found.path, (POST,))
    for row in found.path:
        ROBOT.check_limits(row, soft=True)
    assert found.path[0].joints == pytest.approx(aside(-0.6).joints)
    assert found.path[-1].joints == pytest.approx(aside(0.6).joints)


def test_equal_seeds_give_equal_ways_and_others_do_not():
    first, again, other = (np.array([row.joints for row in ask_arm(seed).path]) for seed in (5, 5, 6))
    assert np.array_equal(first, again)
    assert first.shape != other.shape or not np.array_equal(first, other)


def test_a_search_that_may_not_look_far_ends_with_a_reason():
    failure = ask_arm(most_checks=3)
    assert failure.kind == "no_path"
    numbers = dict(failure.numbers)
    assert numbers["second"] == "post"
    assert numbers["searched"] >= 3


def test_an_end_that_touches_is_named():
    into = Body("into", Box(np.full(3, 0.1)), at(*ROBOT.tool_pose(aside(0.6)).translation))
    rng = np.random.default_rng(0)
    assert plan_arm(checker(into), aside(-0.6), aside(0.6), rng).kind == "goal_collision"
    failure = plan_arm(checker(into), aside(0.6), aside(-0.6), rng)
    assert failure.kind == "start_collision"
    assert "into" in dict(failure.numbers).values()


def test_the_base_drives_around_a_wall():
    rng = np.random.default_rng(1)
    found = plan_drive(checker(WALL), SCAN, Pose2(2.4, 0.0, 0.5), rng)
    assert isinstance(found, FoundPath)
    assert looks_free(found.path, (WALL,))
    assert found.path[-1].base == Pose2(2.4, 0.0, 0.5)
    assert all(np.array_equal(row.joints, SCAN.joints) for row in found.path)
    assert max(abs(row.base.y_m) for row in found.path) > 1.0


def test_a_base_that_is_fenced_in_has_no_way_out():
    fence = [
        Body(f"fence {k}", Box(np.array([0.05, 3.0, 0.4])), at(np.cos(a), np.sin(a), 0.2, turned(a)))
        for k, a in enumerate(np.arange(4) * np.pi / 2)
    ]
    failure = plan_drive(
        checker(*fence), SCAN, Pose2(3.0, 0.0, 0.0), np.random.default_rng(0), SearchRules(most_checks=3000)
    )
    assert failure.kind == "no_path"
    assert dict(failure.numbers)["searched"] > 3000


def turned(a):
    return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1.0]])


def test_the_base_turns_the_shorter_way():
    start = Configuration(SCAN.joints, Pose2(0, 0, 3.0))
    found = plan_drive(checker(), start, Pose2(0, 0, -3.0), np.random.default_rng(0))
    assert in_time(ROBOT, "drive", found.path).duration_s < 1.0


def test_an_arm_does_not_drive():
    with pytest.raises(ValueError, match="plan_drive"):
        plan_arm(checker(), SCAN, Configuration(SCAN.joints, Pose2(1, 0, 0)), np.random.default_rng(0))


@given(seed=st.integers(0, 1000), share=st.floats(0.1, 1.0))
def test_no_joint_is_faster_than_its_limit_and_one_is_as_fast(seed, share):
    rng = np.random.default_rng(seed)
    rows = rng.uniform(ROBOT.limits.soft_lower, ROBOT.limits.soft_upper, (5, len(ROBOT.joint_names)))
    timed = in_time(ROBOT, "reach", rows, share)
    speeds = np.abs(np.diff(timed.joints, axis=0)) / np.diff(timed.times_s)[:, None] / ROBOT.limits.velocity
    assert speeds.max(axis=1) == pytest.approx(share)


def test_a_base_keeps_its_speeds():
    rows = [Configuration(SCAN.joints, Pose2(*pose)) for pose in ((0, 0, 0), (0.8, 0, 0), (0.8, 0, 1.0))]
    assert in_time(ROBOT, "drive", rows, 1.0).times_s == pytest.approx([0, 1, 2])


def test_timing_and_search_refuse_what_cannot_be():
    with pytest.raises(ValueError, match="cannot be"):
        in_time(ROBOT, "reach", np.zeros((0, 7)))
    with pytest.raises(ValueError, match="cannot be"):
        in_time(ROBOT, "reach", np.zeros((2, 7)), 0.0)
    with pytest.raises(ValueError, match="SearchRules"):
        SearchRules(step=0.0)
