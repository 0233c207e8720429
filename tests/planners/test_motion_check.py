"""Motions are checked without gaps: the law is that a finely sampled motion never finds what the checker missed."""

import numpy as np
import pytest
from collision_scenes import ROBOT, at, random_configurations, things

from planners.motion_check import MotionChecker, between
from rfcompass.geometry import Pose2
from rfcompass.robots.collision_model import CollisionModel
from rfcompass.robots.quick_collisions import QuickCollisions
from rfcompass.types import Body, Box, Configuration, World

SCAN = ROBOT.posture("scan")


def checker(world=None, **options):
    return MotionChecker(QuickCollisions(CollisionModel(ROBOT, world or World(), **options)))


def sampled_distances(motions, start, end, count=60):
    return np.array([motions.checker.nearest(between(start, end, t)).distance_m for t in np.linspace(0, 1, count)])


def test_a_sampled_motion_never_touches_where_the_checker_says_free():
    motions, ends = checker(things()), random_configurations(40, seed=11)
    seen = {True: 0, False: 0}
    for start, end in zip(ends[::2], ends[1::2], strict=True):
        report = motions.check(start, end)
        seen[report.free] += 1
        sampled_m = sampled_distances(motions, start, end, 60)
        if report.free:
            assert sampled_m.min() > 0
            assert report.at_least_m <= sampled_m.min() + 1e-5
            assert 0 < report.at_least_m <= report.clearance.distance_m
        else:
            stuck = motions.checker.nearest(between(start, end, report.at))
            assert stuck.touching
    assert min(seen.values()) >= 2


def test_no_pair_approaches_faster_than_its_bound():
    motions = checker(things(), with_tags=True)
    ends = random_configurations(60, seed=12)  # 5e-5: GJK's tolerance, twice and with room
    for start, end in zip(ends[::2], ends[1::2], strict=True):
        speed = motions._speeds(start, end)
        for t in (0.1, 0.6):
            change_m = motions.checker.distances(between(start, end, t + 0.01)) - motions.checker.distances(
                between(start, end, t)
            )
            assert (np.abs(change_m) <= 0.01 * speed + 5e-5).all()


def test_a_thin_plate_in_the_way_is_never_skipped():
    """Joint 1 sweeps the hand through a plate of 1 mm: both ends are free, the middle is not."""
    plate = Body("plate", Box(np.array([0.2, 0.001, 0.12])), at(0.48, 0.0, 0.12))
    motions = checker(World((plate,)))
    start, end = (Configuration(SCAN.joints + np.eye(7)[0] * turn) for turn in (-0.5, 0.5))
    assert not motions.checker.collides(start)
    assert not motions.checker.collides(end)
    report = motions.check(start, end)
    assert not report.free
    assert report.clearance.second == "plate"
    assert report.clearance.distance_m <= 0
    assert 0 < report.at < 0.5


def test_the_base_may_move_too_and_is_stopped_by_what_stands_in_its_way():
    post = Body("post", Box(np.array([0.02, 0.02, 0.1])), at(1.0, 0, 0.05))
    motions = checker(World((post,)))
    beyond = Configuration(SCAN.joints, Pose2(2.0, 0, 0))
    report = motions.check(SCAN, beyond)
    assert not report.free
    assert report.clearance.second == "post"
    beside = Configuration(SCAN.joints, Pose2(2.0, 1.0, 0.5))
    assert not motions.check(SCAN, Configuration(SCAN.joints, Pose2(0.0, 1.0, 0.0))).clearance.touching
    assert motions.check(Configuration(SCAN.joints, Pose2(0, 1, 0)), beside).free


def test_standing_still_is_one_check():
    report = checker().check(SCAN, SCAN)
    assert report.free
    assert report.checks == 2


def test_a_path_reports_its_tightest_place():
    motions = checker(things())
    up = Configuration(ROBOT.posture("candle").joints)
    report = motions.check_path([SCAN, up, SCAN])
    assert report.free
    single = [motions.check(a, b) for a, b in ((SCAN, up), (up, SCAN))]
    assert report.clearance.distance_m == min(row.clearance.distance_m for row in single)
    assert report.checks == sum(row.checks for row in single)


def test_a_path_of_one_configuration_is_none():
    with pytest.raises(ValueError, match="two"):
        checker().check_path([SCAN])
