"""The robot offers stops inside its limits, outside the keep-out box, and never on the part."""

import numpy as np
import pytest

from planners.hand_stops import HandStops
from planners.next_stop import BODY_HALF_M, choose_next_stop
from rfcompass.errors import InputError, OutOfReach
from rfcompass.geometry import Pose2
from rfcompass.interfaces import StopProposer
from rfcompass.robots import YouBot
from rfcompass.types.configuration import Configuration

ROBOT = YouBot()
POINTS_M = np.array([[-0.2, 0.0, 0.05], [0.2, 0.0, 0.05]])
FEW = HandStops(robot=ROBOT, count=12)


def poses_about(x_m, y_m, spread_m=0.05):
    rng = np.random.default_rng(0)
    return np.column_stack([rng.normal((x_m, y_m), spread_m, (50, 2)), rng.uniform(-np.pi, np.pi, 50)])


def now(base=None):
    return ROBOT.posture("scan", base)


def test_stops_are_inside_the_limits_and_over_the_rectangle():
    assert isinstance(FEW, StopProposer)
    stops = FEW.candidates(now())
    assert len(stops) == 12
    for stop in stops:
        ROBOT.check_limits(stop.configuration, soft=True)
        x_m, y_m, z_m = ROBOT.tool_pose(stop.configuration).translation
        assert FEW.low_m[0] - 0.001 <= x_m <= FEW.high_m[0] + 0.001
        assert FEW.low_m[1] - 0.001 <= y_m <= FEW.high_m[1] + 0.001
        assert z_m == pytest.approx(FEW.height_m, abs=0.001)
    assert sum(stop.configuration.base == Pose2() for stop in stops) == 6


def test_equal_questions_get_equal_answers_in_any_frame():
    T = Pose2(1.0, 2.0, 0.5)
    for one, other in zip(FEW.candidates(now()), FEW.candidates(now(T)), strict=True):
        assert np.array_equal(one.configuration.joints, other.configuration.joints)
        expected = T @ one.configuration.base
        assert expected.x_m == pytest.approx(other.configuration.base.x_m)
        assert one.seconds == other.seconds


def test_the_base_keeps_out_of_the_box():
    everywhere = HandStops(robot=ROBOT, count=12, keep_out_m=np.array([[-9.0, 9.0], [-9.0, 9.0]]))
    assert everywhere.candidates(now()) == []
    ahead = HandStops(robot=ROBOT, count=12, keep_out_m=np.array([[0.01, 9.0], [-9.0, 9.0]]))
    assert 0 < len(ahead.candidates(now())) < 12
    assert all(stop.configuration.base.x_m <= 0.01 for stop in ahead.candidates(now()))


def test_the_chosen_stop_is_the_best_of_those_that_leave_the_part_alone():
    chosen = choose_next_stop(ROBOT, now(), FEW, poses_about(0.42, 0.0), POINTS_M)
    best = chosen.stops[chosen.scores.best].configuration
    assert best is chosen.configuration
    rate = chosen.scores.gain_nat / chosen.scores.seconds
    assert rate.max() == rate[chosen.scores.best] > 0


def test_it_is_the_same_choice_wherever_the_world_has_its_origin():
    T = Pose2(-2.0, 1.0, 2.0)
    here = choose_next_stop(ROBOT, now(), FEW, poses_about(0.42, 0.0), POINTS_M)
    there = choose_next_stop(ROBOT, now(T), FEW, poses_about(0.42, 0.0), POINTS_M)
    assert here.scores.best == there.scores.best
    np.testing.assert_allclose(here.scores.gain_nat, there.scores.gain_nat, rtol=1e-9)


class OneStop:
    """Offers to stand where it is told."""

    def __init__(self, base):
        self.base = base

    def candidates(self, configuration):
        from rfcompass.types.stops import ProposedStop  # noqa: PLC0415

        return [ProposedStop(Configuration(configuration.joints, configuration.base @ self.base), 1.0)]


def test_no_stop_stands_on_the_part():
    """At any heading the body covers a disc of its half width, and a point tag lies in it."""
    on_it = OneStop(Pose2(0.42, 0.0, 1.0))
    with pytest.raises(OutOfReach):
        choose_next_stop(ROBOT, now(), on_it, poses_about(0.42, 0.0, 0.3 * BODY_HALF_M[1]), POINTS_M * 0.0)


def test_a_base_that_stays_runs_over_nothing():
    stays = OneStop(Pose2())
    chosen = choose_next_stop(ROBOT, now(), stays, poses_about(0.1, 0.0), POINTS_M * 0.0)
    assert chosen.configuration.base == now().base


def test_without_poses_there_is_nothing_to_choose():
    with pytest.raises(InputError):
        choose_next_stop(ROBOT, now(), FEW, np.zeros((0, 3)), POINTS_M)
