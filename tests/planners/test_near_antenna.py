"""The carrier comes near a part that the robot is near to, keeps clear of what stands there, and looks around."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from planners.antenna_track import LEAST_LEG_M, NearTrack
from planners.fetch import Fetch
from planners.fetch_rules import FetchRules
from planners.free_legs import STAND_OFFS_M
from planners.near_antenna import MOVED_M, ROBOT_M, NearAntenna
from rfcompass.errors import InputError, OutOfReach, TagNeverHeard
from rfcompass.geometry import Pose2
from rfcompass.interfaces import AntennaCarrier
from rfcompass.localization.locate_base import locate_base
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.types import Observation, PartEstimate, Scan

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
TRACK = NearTrack()
LOOKS = 8  # four corners, four quarters
T_ROOM_BASE, T_ROOM_PART = Pose2(2.4, 2.2, 0.4), Pose2(2.9, 2.6, 1.0)
TRUTH = T_ROOM_BASE.inverse() @ T_ROOM_PART


class Legs:
    """A carrier that only remembers."""

    def __init__(self):
        self.asked = []

    def use_legs(self, legs_m):
        self.asked.append(legs_m)


def a_device(scene="free_space", base=T_ROOM_BASE):
    rng, layout = np.random.default_rng(3), LEG.layout(4)
    room = PlaneRoom(T_room_base=base, T_room_part=T_ROOM_PART)
    sensor = RadioSetup(scene=scene).sensor(room, ROBOT.layout, layout, rng)
    return SimulatedRobot(ROBOT, LEG, layout, room, rng, ROBOT.posture("scan").joints, sensor)


@cache
def heard():
    return a_device().scan()


def estimate(off_m=(0.0, 0.0)):
    return PartEstimate(LEG.part_id, TRUTH.translation_m + off_m, TRUTH.theta_rad, "told", 1)


def test_one_scan_tells_where_the_base_stands_among_the_antennas():
    found = locate_base(heard())
    assert np.linalg.norm(found.centre_m - T_ROOM_BASE.translation_m) < 0.05
    assert abs(found.theta_rad - T_ROOM_BASE.theta_rad) < 0.15


def test_a_base_that_nobody_hears_is_nowhere():
    silent = replace(heard(), scan=Scan())
    with pytest.raises(TagNeverHeard, match="0 of the robot's 9 tags"):
        locate_base(silent)
    assert not NearAntenna(Legs(), TRACK).comes_nearer(silent, estimate())


def test_the_carrier_comes_near_the_part_and_keeps_off_the_robot_and_the_furniture():
    desk_m = np.array([[[2.2, 1.2], [3.4, 1.5]]])
    carrier = Legs()
    assert NearAntenna(carrier, TRACK, keep_out_m=desk_m).comes_nearer(heard(), estimate())
    (legs_m,) = carrier.asked
    robot_m = T_ROOM_BASE.translation_m + np.array([[-ROBOT_M], [ROBOT_M]])
    for leg_m in legs_m:
        points_m = np.linspace(leg_m[0, :2], leg_m[1, :2], 50)
        nearest_m = np.linalg.norm(points_m - T_ROOM_PART.translation_m, axis=1).min()
        assert STAND_OFFS_M[0] - 0.06 <= nearest_m <= STAND_OFFS_M[-1] + 0.06
        for low_m, high_m in (*desk_m, robot_m):
            grown = TRACK.clear_m - 0.06  # the images place the base to centimetres
            assert not ((points_m > low_m - grown) & (points_m < high_m + grown)).all(axis=1).any()


def test_it_stays_where_it_drives_unless_the_part_seems_elsewhere():
    carrier = Legs()
    antenna = NearAntenna(carrier, TRACK)
    assert antenna.comes_nearer(heard(), estimate())
    assert not antenna.comes_nearer(heard(), estimate((0.5 * MOVED_M, 0.0)))
    assert antenna.comes_nearer(heard(), estimate((2.0 * MOVED_M, 0.0)))
    assert len(carrier.asked) == 2


def test_other_sides_are_taken_once_each_until_the_part_seems_elsewhere():
    carrier = Legs()
    antenna = NearAntenna(carrier, TRACK)
    assert antenna.comes_nearer(heard(), estimate())
    while antenna.changes_sides(heard(), estimate()):
        assert len(carrier.asked) <= 16  # it must end
    assert len({legs_m.tobytes() for legs_m in carrier.asked}) == len(carrier.asked) > 1
    assert antenna.comes_nearer(heard(), estimate((2.0 * MOVED_M, 0.0)))
    assert antenna.changes_sides(heard(), estimate((2.0 * MOVED_M, 0.0)))


def test_it_does_not_follow_a_part_that_the_robot_is_far_from():
    carrier = Legs()
    assert not NearAntenna(carrier, TRACK, from_m=0.3).comes_nearer(heard(), estimate())
    assert not carrier.asked


def test_it_looks_from_everywhere_once_and_goes_on_from_there_after_the_part_was_found():
    carrier = Legs()
    antenna = NearAntenna(carrier, TRACK)
    assert [antenna.looks_from_elsewhere() for _ in range(LOOKS + 1)] == [True] * LOOKS + [False]
    assert len({legs_m.tobytes() for legs_m in carrier.asked}) == LOOKS
    for legs_m in carrier.asked[:4]:
        assert (np.linalg.norm(legs_m[:, 1] - legs_m[:, 0], axis=1) >= LEAST_LEG_M).all()
    antenna.found()
    assert antenna.looks_from_elsewhere()
    antenna.found()
    assert antenna.looks_from_elsewhere()
    assert [legs_m.tobytes() for legs_m in carrier.asked[LOOKS:]] == [legs_m.tobytes() for legs_m in carrier.asked[:2]]


def test_a_rectangle_full_of_furniture_has_no_corner():
    full_m = np.array([[[0.0, 0.0], [6.0, 5.0]]])
    antenna = NearAntenna(Legs(), TRACK, keep_out_m=full_m)
    assert not antenna.looks_from_elsewhere()
    assert not antenna.comes_nearer(heard(), estimate())


def test_the_simulated_carrier_drives_the_legs_it_is_told():
    device = a_device()
    assert isinstance(device, AntennaCarrier)
    legs_m = TRACK.legs_m(T_ROOM_PART.translation_m)
    device.use_legs(legs_m)
    trace = next(iter(device.scan().scan.traces.values()))
    ends_m = legs_m.reshape(-1, 3)
    assert np.allclose(trace.antenna_positions_m.min(axis=0), ends_m.min(axis=0), atol=1e-6)
    assert np.allclose(trace.antenna_positions_m.max(axis=0), ends_m.max(axis=0), atol=1e-6)


def test_without_an_antenna_there_are_no_legs():
    room = PlaneRoom(T_room_base=T_ROOM_BASE, T_room_part=T_ROOM_PART)
    joints = ROBOT.posture("scan").joints
    device = SimulatedRobot(ROBOT, LEG, LEG.layout(4), room, np.random.default_rng(0), joints, NoisyDistances(0.0))
    with pytest.raises(InputError, match="hears without an antenna"):
        device.use_legs(TRACK.legs_m(np.array([3.0, 2.5])))


class Deaf:
    """A localizer that hears the part only after the antenna has moved so many times."""

    def __init__(self, carrier, moves):
        self.carrier, self.moves = carrier, moves

    def estimate(self, observations):
        if len(self.carrier.asked) < self.moves:
            raise TagNeverHeard("not from here", heard=0)
        return PartEstimate(LEG.part_id, TRUTH.translation_m, TRUTH.theta_rad, "told", len(observations))


class Repeats:
    """A device that hears the same at every stop, and goes nowhere."""

    def scan(self) -> Observation:
        return heard()

    def move_base(self, goal):
        return goal

    def move_arm(self, joints):
        pass


def a_fetch(moves):
    carrier = Legs()
    loop = Fetch(ROBOT, Repeats(), Deaf(carrier, moves), ROBOT.posture("scan"), antenna=NearAntenna(carrier, TRACK))
    return carrier, loop


def test_a_part_that_is_not_heard_is_looked_for_from_other_sides():
    carrier, loop = a_fetch(moves=2)
    first = next(iter(loop.steps()))
    assert first.estimate.stops == 1
    assert len(carrier.asked) == 2 + 1  # once more, for a second look that agrees


def test_the_look_around_ends_with_what_the_localizer_said():
    carrier, loop = a_fetch(moves=99)
    with pytest.raises(TagNeverHeard, match="not from here") as failure:
        next(iter(loop.steps()))
    assert len(carrier.asked) == LOOKS
    assert failure.value.numbers["phase"] == "navigate"


class Unsure(Deaf):
    """A localizer that could mean anywhere, until the antenna has moved so many times."""

    def estimate(self, observations):
        sd_m = 0.05 if len(self.carrier.asked) >= self.moves else 3.0 / (1 + len(self.carrier.asked))
        covariance = np.diag([sd_m**2, sd_m**2, 0.01])
        return PartEstimate(LEG.part_id, TRUTH.translation_m, TRUTH.theta_rad, "told", 1, covariance=covariance)


def test_an_answer_that_could_mean_anywhere_is_not_driven_to_before_the_antenna_has_looked_elsewhere():
    carrier = Legs()
    loop = Fetch(ROBOT, Repeats(), Unsure(carrier, 2), ROBOT.posture("scan"), antenna=NearAntenna(carrier, TRACK))
    first = next(iter(loop.steps()))
    assert len(carrier.asked) == 2 + 1  # once more, for a second look that agrees
    assert np.sqrt(first.estimate.covariance[0, 0]) < 0.1


def test_without_another_place_to_look_from_the_unsure_answer_is_all_there_is():
    loop = Fetch(ROBOT, Repeats(), Unsure(Legs(), 2), ROBOT.posture("scan"))
    assert np.sqrt(next(iter(loop.steps())).estimate.covariance[0, 0]) == pytest.approx(3.0)


class Walled(Repeats):
    """A device that gets nowhere."""

    def move_base(self, goal):
        return Pose2()


def test_a_drive_that_a_wall_stops_makes_the_antenna_look_elsewhere():
    carrier = Legs()
    far = PartEstimate(LEG.part_id, np.array([3.0, 0.0]), 0.0, "told", 1)

    class Told:
        def estimate(self, observations):
            return far

    antenna = NearAntenna(carrier, TRACK)
    loop = Fetch(ROBOT, Walled(), Told(), ROBOT.posture("scan"), FetchRules(max_moves=2), antenna=antenna)
    with pytest.raises(OutOfReach):
        list(loop.steps())
    assert len(carrier.asked) == 1 + 3  # a second look before the first drive, then one for each drive
