"""The last stops: where they tell most, reachable without a touch, and no more than are needed."""

import numpy as np
import pytest

from planners.final_stops import FinalStops
from planners.hand_stops import HandStops
from planners.motion_check import MotionChecker, MotionReport
from planners.next_stop import choose_next_stop
from rfcompass.localization import StopRule
from rfcompass.recordings import PartDatabase
from rfcompass.robots import CollisionModel, QuickCollisions, YouBot
from rfcompass.types import PartEstimate
from rfcompass.types.configuration import Configuration
from rfcompass.types.world import World

ROBOT = YouBot()
TAGS = PartDatabase(":memory:").part("table_leg_3").layout(4)
STOPS = HandStops(robot=ROBOT, count=20, drive_m=0.0, turn_rad=0.0)
CHECKER = MotionChecker(QuickCollisions(CollisionModel(ROBOT, World())))
NOW = ROBOT.posture("scan")


def estimate(sd_m=0.03, count=200):
    rng = np.random.default_rng(4)
    samples = np.array([0.42, 0.0, np.pi / 2]) + rng.normal(size=(count, 3)) * [sd_m, sd_m, 0.1]
    return PartEstimate("leg", np.array([0.42, 0.0]), np.pi / 2, "told", 1, 0.025, samples=samples)


class Never:
    """Every motion touches something."""

    def check(self, start, end):
        return MotionReport(free=False, clearance=None, at_least_m=0.0, at=0.5, checks=1)


def test_the_stop_that_tells_most_for_its_time_is_taken():
    final = FinalStops(ROBOT, STOPS)
    points_m = TAGS.points_m + np.array([0.0, 0.0, 0.025])
    best = choose_next_stop(ROBOT, NOW, STOPS, estimate().samples, points_m)
    chosen = final.choose(NOW, estimate(), TAGS)
    assert np.array_equal(chosen.joints, best.configuration.joints)
    assert chosen.base == best.configuration.base


def test_a_stop_is_taken_only_if_the_motion_to_it_touches_nothing():
    chosen = FinalStops(ROBOT, STOPS, CHECKER).choose(NOW, estimate(), TAGS)
    assert chosen.base == NOW.base
    assert CHECKER.check(NOW, chosen).free
    assert FinalStops(ROBOT, STOPS, Never()).choose(NOW, estimate(), TAGS) is None


def test_where_nothing_is_in_question_or_nothing_offered_nobody_chooses():
    class Nothing:
        def candidates(self, configuration):
            return []

    assert FinalStops(ROBOT, STOPS).choose(NOW, estimate(count=0), TAGS) is None
    assert FinalStops(ROBOT, Nothing()).choose(NOW, estimate(), TAGS) is None


@pytest.mark.parametrize(("sd_m", "enough"), [(0.002, True), (0.02, False)])
def test_a_part_that_is_known_well_enough_needs_no_stop(sd_m, enough):
    final = FinalStops(ROBOT, STOPS, rule=StopRule(within_rad=None))
    assert final.is_enough(estimate(sd_m)) == enough
    assert not final.is_enough(estimate(sd_m, count=0))


def test_the_same_question_has_the_same_answer():
    first, second = (FinalStops(ROBOT, STOPS, CHECKER).choose(NOW, estimate(), TAGS) for _ in range(2))
    assert isinstance(first, Configuration)
    assert np.array_equal(first.joints, second.joints)
