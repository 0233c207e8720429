"""The closed loop: half the way each time, then the hand over the part; and it ends in a typed way."""

from dataclasses import replace

import numpy as np
import pytest

from planners.fetch import Fetch
from planners.fetch_rules import FetchRules
from rfcompass.errors import Infeasible, OutOfReach
from rfcompass.geometry import Pose2
from rfcompass.interfaces import MobileManipulator, Scanner
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot, WheelSlip
from rfcompass.types import PartEstimate

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
EXACT = NoisyDistances(0.0)
NO_SLIP = WheelSlip(position_m=0.0, heading_rad=0.0)


def a_device(x_m=3.0, y_m=1.0, theta_rad=0.7, kind=SimulatedRobot):
    room = PlaneRoom(T_room_base=Pose2(), T_room_part=Pose2(x_m, y_m, theta_rad))
    rng = np.random.default_rng(0)
    return kind(ROBOT, LEG, LEG.layout(4), room, rng, ROBOT.posture("scan").joints, EXACT, NO_SLIP)


class Clairvoyant:
    """Stands in for a localizer: says where the part is, so that only the loop is tested."""

    def __init__(self, device, knows_theta=True):
        self.device, self.knows_theta = device, knows_theta

    def estimate(self, observations):
        pose = self.device.true_pose_in_base()
        theta_rad = pose.theta_rad if self.knows_theta else None
        return PartEstimate(LEG.part_id, pose.translation_m, theta_rad, "told", len(observations))


def a_fetch(device, localizer, **rules):
    return Fetch(ROBOT, device, localizer, ROBOT.posture("scan"), FetchRules(**rules))


def test_the_simulated_robot_stands_behind_the_protocols_of_a_real_one():
    assert isinstance(a_device(), Scanner)
    assert isinstance(a_device(), MobileManipulator)


def test_each_move_halves_the_distance():
    device = a_device()
    steps = [step for step in a_fetch(device, Clairvoyant(device)).steps() if step.phase == "navigate"]
    distances_m = [step.estimate.distance_m for step in steps]
    assert np.allclose(distances_m[1:], np.array(distances_m[:-1]) / 2, atol=1e-9)
    assert [step.in_reach for step in steps] == [False] * (len(steps) - 1) + [True]


def test_a_step_is_never_longer_than_the_rules_allow():
    device = a_device(5.5, 0.0)
    steps = list(a_fetch(device, Clairvoyant(device), max_step_m=1.0).steps())
    bases = [step.configuration.base.translation_m for step in steps if step.phase == "navigate"]
    assert np.linalg.norm(np.diff(bases, axis=0), axis=1).max() <= 1.0 + 1e-9


@pytest.mark.parametrize("theta_rad", [-2.5, -0.4, 0.0, 1.1, 3.0])
def test_the_last_stops_have_the_part_under_the_hand_and_across_the_base(theta_rad):
    device = a_device(2.0, -1.0, theta_rad)
    rules = FetchRules()
    last = [step for step in a_fetch(device, Clairvoyant(device)).steps() if step.phase == "localise"]
    assert len(last) == len(rules.hand_sweep)
    for step in last:
        assert np.allclose(step.estimate.centre_m, rules.hand_point_m, atol=1e-6)
        assert abs(np.cos(step.estimate.theta_rad)) < 1e-6


def test_a_part_whose_turn_is_unknown_is_faced():
    device = a_device(2.0, -1.0)
    last = [s for s in a_fetch(device, Clairvoyant(device, knows_theta=False)).steps() if s.phase == "localise"]
    assert np.allclose(last[-1].estimate.centre_m, FetchRules().hand_point_m, atol=1e-6)


def test_the_hand_visits_different_places():
    device = a_device(1.0, 0.0)
    last = [step for step in a_fetch(device, Clairvoyant(device)).steps() if step.phase == "localise"]
    hands_m = np.array([step.observation.anchors.points_m[0] for step in last])
    gaps_m = np.linalg.norm(hands_m[:, None] - hands_m[None], axis=2)[np.triu_indices(len(hands_m), 1)]
    assert gaps_m.min() > 0.03


def test_a_part_that_stays_away_ends_the_loop():
    device = a_device(40.0, 0.0)
    with pytest.raises(OutOfReach) as caught:
        list(a_fetch(device, Clairvoyant(device), max_moves=3).steps())
    assert caught.value.numbers["moves"] == 3


def test_a_localizer_without_an_answer_ends_the_loop_and_the_stop_is_named():
    class Mute:
        def estimate(self, observations):
            raise Infeasible("contradicting rows", rows=3)

    with pytest.raises(Infeasible) as caught:
        list(a_fetch(a_device(), Mute()).steps())
    assert caught.value.numbers == {"rows": 3, "stop": 0, "phase": "navigate"}


class Unsure(Clairvoyant):
    """Knows the part, and says how unsure it is of each stop; notes the stops that it was given."""

    def __init__(self, device, *sds_m):
        super().__init__(device)
        self.sds_m, self.given = sds_m, []

    def estimate(self, observations):
        self.given.append([observation.stop_id for observation in observations])
        sd_m = self.sds_m[min(len(self.given), len(self.sds_m)) - 1]
        if sd_m is None:
            raise Infeasible("contradicting rows", rows=3)
        return replace(super().estimate(observations), covariance=np.diag([0.01, sd_m**2, 0.01]))


class Elsewhere:
    """An antenna's carrier that has a few more places to listen from, and never comes nearer."""

    def __init__(self, places):
        self.places = places

    def looks_from_elsewhere(self):
        self.places -= 1
        return self.places >= 0

    def comes_nearer(self, observation, estimate):
        return False

    def found(self):
        self.places = 0


@pytest.mark.parametrize("doubts_m", [(2.0, 0.8, 1.5), (0.8, 2.0, None), (None, 3.0, 0.8), (2.0, 2.0, 0.8)])
def test_if_no_look_is_worth_a_drive_the_surest_one_is_driven_to_and_alone_remembered(doubts_m):
    device = a_device(2.0, 0.0)
    seer = Unsure(device, *doubts_m, 0.1)
    loop = Fetch(ROBOT, device, seer, ROBOT.posture("scan"), FetchRules(), None, Elsewhere(2))
    loop._time.drove([Pose2(0.8, 0.0, 0.0)])  # before the first look, which need not be the surest
    first, second, *_ = loop.navigate()
    assert first.spent.drive_s == pytest.approx(1.0)
    assert np.sqrt(first.estimate.covariance[1, 1]) == pytest.approx(0.8)
    assert first.observation.stop_id == doubts_m.index(0.8)
    assert seer.given[3] == [first.observation.stop_id, second.observation.stop_id]


class Cornered(SimulatedRobot):
    """A robot that a wall keeps from one side of the part: it cannot drive to x beyond the wall."""

    wall_m = 1.2

    def move_base(self, T_base_goal):
        ahead = self.true_pose_in_room() @ T_base_goal
        return super().move_base(T_base_goal if ahead.x_m <= self.wall_m else Pose2())


@pytest.mark.parametrize("theta_rad", [-1.2, 0.3, 1.5])
def test_a_part_in_front_of_a_wall_is_reached_from_another_side(theta_rad):
    device = a_device(1.1, 0.2, theta_rad, kind=Cornered)
    last = [step for step in a_fetch(device, Clairvoyant(device)).steps() if step.phase == "localise"][-1]
    assert np.allclose(last.estimate.centre_m, FetchRules().hand_point_m, atol=1e-6)
    assert all(pose.x_m <= Cornered.wall_m for pose in device.true_way_in_room())


def test_tags_that_say_nothing_about_reach_leave_it_to_the_estimate():
    class NoHand:
        """Hears no pair of a hand tag."""

        def __init__(self, device):
            self.device = device

        def __getattr__(self, name):
            return getattr(self.device, name)

        def scan(self):
            heard = self.device.scan()
            hands = [i for i, role in enumerate(ROBOT.layout.roles) if role.startswith("hand")]
            anchor_m, m = heard.proximity.anchor_m.copy(), heard.proximity.m.copy()
            anchor_m[hands], anchor_m[:, hands], m[:, hands] = np.nan, np.nan, np.nan
            return replace(heard, proximity=replace(heard.proximity, anchor_m=anchor_m, m=m))

    device = a_device()
    steps = list(a_fetch(NoHand(device), Clairvoyant(device)).navigate())
    assert steps[-1].in_reach
    assert steps[-1].estimate.distance_m <= FetchRules().reach_m


def test_with_a_map_every_drive_beside_the_part_asks_it():
    class Map:
        asked = ()

        def way(self, observation, joints, T_base_goal, approach=None, beside=None, stands=None):
            self.asked = (*self.asked, (T_base_goal, beside))
            return (T_base_goal,)

    device = a_device()
    loop = Fetch(ROBOT, device, Clairvoyant(device), ROBOT.posture("scan"), around=Map())
    step = list(loop.navigate())[-1]
    before = len(loop.around.asked)
    loop.drive_to(step, Pose2(0.1, 0.0, 0.2))
    loop.stand_over(step)
    assert len(loop.around.asked) == before + 2
    assert loop.around.asked[before] == (Pose2(0.1, 0.0, 0.2), step.estimate)
    assert loop.around.asked[before + 1][1] is step.estimate
