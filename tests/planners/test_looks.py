"""Of several looks at one stop the surer of two is believed that, both sure, mean the same place."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.fetch import Fetch
from planners.looks import AGREE_M, Look, confirmed, surest
from planners.worth_driving import LOST_M
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot, WheelSlip
from rfcompass.types import PartEstimate

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
START = ROBOT.posture("scan")
SURE_M, UNSURE_M = 0.5 * LOST_M, 2.0 * LOST_M


class Step:
    """What a look needs of a step."""

    def __init__(self, x_m, doubt_m):
        self.estimate, self.doubt_m = PartEstimate("leg", np.array([x_m, 0.0]), None, "told", 1), doubt_m


def looks(*rows):
    return [Look(Step(x_m, doubt_m), ()) for x_m, doubt_m in rows]


def apart_m(one, other):
    return abs(one.step.estimate.centre_m[0] - other.step.estimate.centre_m[0])


rows = st.lists(st.tuples(st.floats(-5.0, 5.0), st.floats(0.01, 2.0)), min_size=1, max_size=8)


@given(rows)
def test_who_is_believed_has_a_sure_witness_and_is_the_surer_of_the_two(told):
    *earlier, newest = all_looks = looks(*told)
    believed = confirmed(all_looks)
    witnesses = [look for look in earlier if look.is_sure and apart_m(look, newest) <= AGREE_M]
    if not (newest.is_sure and witnesses):
        assert believed is None
        return
    assert believed in (newest, *witnesses)
    assert believed.step.doubt_m == min(look.step.doubt_m for look in (newest, *witnesses))


@given(rows)
def test_nobody_is_surer_than_the_surest(told):
    assert surest(looks(*told)).step.doubt_m == min(doubt_m for _, doubt_m in told)


@pytest.mark.parametrize(
    ("told", "believed"),
    [
        ([(0.0, SURE_M)], None),
        ([(0.0, SURE_M), (0.9 * AGREE_M, SURE_M)], 1),
        ([(0.0, 0.5 * SURE_M), (0.9 * AGREE_M, SURE_M)], 0),
        ([(0.0, SURE_M), (1.1 * AGREE_M, SURE_M)], None),
        ([(0.0, SURE_M), (0.0, UNSURE_M)], None),
        ([(0.0, UNSURE_M), (0.0, SURE_M)], None),
        ([(3.0, SURE_M), (0.0, 0.5 * SURE_M), (3.1, SURE_M)], 2),
    ],
)
def test_the_surer_of_two_sure_looks_within_half_a_metre_is_believed(told, believed):
    all_looks = looks(*told)
    assert confirmed(all_looks) is (None if believed is None else all_looks[believed])


class Carrier:
    """An antenna with a few more places to listen from, which never comes nearer."""

    def __init__(self, places):
        self.places = places

    def looks_from_elsewhere(self):
        self.places -= 1
        return self.places >= 0

    def comes_nearer(self, observation, estimate):
        return False

    def found(self):
        """All places may be had again; there are none in these tests."""


class Echoes:
    """Sees the part where it is, or, in some looks, elsewhere, and is sure of either."""

    def __init__(self, device, *off_m):
        self.device, self.off_m, self.asked = device, off_m, []

    def estimate(self, observations):
        off_m = self.off_m[len(self.asked)] if len(self.asked) < len(self.off_m) else 0.0
        self.asked.append([stop.stop_id for stop in observations])
        pose = self.device.true_pose_in_base()
        sure = np.diag([0.01, SURE_M**2, 0.01])
        at_m = pose.translation_m + np.array([0.0, off_m])
        return replace(PartEstimate(LEG.part_id, at_m, pose.theta_rad, "told", len(observations)), covariance=sure)


def stops_of(places, *off_m):
    room = PlaneRoom(T_room_base=Pose2(), T_room_part=Pose2(2.0, 0.0, 0.7))
    still = WheelSlip(position_m=0.0, heading_rad=0.0)
    device = SimulatedRobot(
        ROBOT, LEG, LEG.layout(4), room, np.random.default_rng(0), START.joints, NoisyDistances(0.0), still
    )
    seer = Echoes(device, *off_m)
    steps = list(Fetch(ROBOT, device, seer, START, antenna=Carrier(places)).navigate())
    return steps, seer


def test_an_echo_that_no_other_look_hears_is_not_driven_to():
    (first, *_), seer = stops_of(5, 1.5)
    assert first.estimate.centre_m[1] == pytest.approx(0.0)
    assert seer.asked[:3] == [[0], [1], [2]]
    assert seer.asked[3] == [2, 3]  # after the drive the believed one is remembered, not its witness, nor the echo


def test_only_the_first_drive_waits_for_a_second_look():
    steps, seer = stops_of(5)
    assert len(seer.asked) == len(steps) + 1


def test_where_there_is_no_second_place_the_only_look_is_driven_to():
    (first, *_), _ = stops_of(0, 1.5)
    assert first.estimate.centre_m[1] == pytest.approx(1.5)


def test_while_no_two_looks_have_agreed_the_next_stop_asks_again():
    steps, seer = stops_of(2, 1.5, -1.5)
    assert seer.asked[:3] == [[0], [1], [2]]
    assert len(seer.asked) > len(steps)
