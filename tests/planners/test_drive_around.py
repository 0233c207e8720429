"""Drives around a map: a way clear of things, straight where it is free, and time that adds up."""

from itertools import pairwise

import numpy as np
import pytest

from planners.drive_around import Approach, DriveAround
from planners.fetch import Fetch
from planners.fetch_rules import FetchRules
from planners.map_pose import KnownStart, RadioPose
from planners.motion_check import MotionChecker
from planners.path_search import SearchRules
from planners.short_drive import cost_m, first_part, plan_short_drive, shortened
from planners.time_account import CARRIER_M_S, TimeAccount, drive_time_s, track_m
from rfcompass.errors import TagNeverHeard
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import CollisionModel, QuickCollisions, YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot, WheelSlip
from rfcompass.simulation.motion_capture import NoReader
from rfcompass.studies.radio_scan import scan_over_part
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.types import PartEstimate
from rfcompass.types.configuration import Configuration
from rfcompass.types.shapes import Box
from rfcompass.types.world import Body, World

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
JOINTS = ROBOT.posture("scan").joints
NO_SLIP = WheelSlip(position_m=0.0, heading_rad=0.0)
# Somewhere on a map that is turned against odometry.
T_MAP_ODOM = Pose2(2.0, -1.0, 0.8)


def standing(x_m, y_m, size_m=(0.3, 1.0, 1.0), name="thing"):
    """A box in the frame of odometry, put on the map."""
    at, T = T_MAP_ODOM @ Pose2(x_m, y_m, 0.0), np.eye(4)
    T[:2, :2], T[:2, 3], T[2, 3] = at.rotation, at.translation_m, size_m[2] / 2
    return Body(name, Box(np.array(size_m)), T)


def around(*bodies, where=None, **options):
    return DriveAround(ROBOT, World(bodies), where or KnownStart(T_MAP_ODOM), np.random.default_rng(0), **options)


def a_device(x_m=3.0, y_m=0.0, theta_rad=0.7, slip=NO_SLIP):
    room = PlaneRoom(T_room_base=Pose2(), T_room_part=Pose2(x_m, y_m, theta_rad))
    rng = np.random.default_rng(0)
    return SimulatedRobot(ROBOT, LEG, LEG.layout(4), room, rng, JOINTS, NoisyDistances(0.0), slip)


class Told:
    def __init__(self, device):
        self.device = device

    def estimate(self, observations):
        pose = self.device.true_pose_in_base()
        return PartEstimate(LEG.part_id, pose.translation_m, pose.theta_rad, "told", len(observations))


def navigated(device, plan, **rules):
    loop = Fetch(ROBOT, device, Told(device), ROBOT.posture("scan"), FetchRules(**rules), around=plan)
    return list(loop.navigate())


def touches(path, *bodies):
    checker = MotionChecker(QuickCollisions(CollisionModel(ROBOT, World(bodies))))
    return not checker.check_path([Configuration(JOINTS, T_MAP_ODOM @ pose) for pose in path]).free


def test_a_way_that_is_free_is_straight():
    goal = Pose2(1.5, 0.2, 0.3)
    (only,) = around(standing(1.0, 3.0)).way(a_device().scan(), JOINTS, goal)
    assert only.translation_m == pytest.approx(goal.translation_m)
    assert only.theta_rad == pytest.approx(goal.theta_rad)


def test_a_way_leads_around_what_stands_in_it_and_ends_at_the_goal():
    thing, goal = standing(1.5, 0.0), Pose2(3.0, 0.0, 0.0)
    way = around(thing).way(a_device().scan(), JOINTS, goal)
    assert touches([Pose2(), goal], thing)
    assert not touches([Pose2(), *way], thing)
    assert way[-1].translation_m == pytest.approx(goal.translation_m)
    legs_m = np.linalg.norm(np.diff([pose.translation_m for pose in (Pose2(), *way)], axis=0), axis=1)
    assert 3.0 < legs_m.sum() < 4.5


def test_things_are_kept_clear_of_by_the_margin():
    thing, goal = standing(1.5, 0.0), Pose2(3.0, 0.0, 0.0)
    way = around(thing, clear_m=0.1).way(a_device().scan(), JOINTS, goal)
    wider = standing(1.5, 0.0, (0.45, 1.15, 1.0))  # a fifth of the margin is not seen
    assert not touches([Pose2(), *way], wider)


def test_a_goal_that_is_not_free_is_moved_to_the_nearest_place_that_is():
    thing = standing(2.0, 0.0)
    way = around(thing).way(a_device().scan(), JOINTS, Pose2(2.0, 0.0, 0.0))
    assert not touches([Pose2(), *way], thing)
    assert 0.1 < np.linalg.norm(way[-1].translation_m - [2.0, 0.0]) < 0.9


def test_of_places_near_a_blocked_goal_those_within_reach_of_the_part_come_first():
    thing, part_m = standing(2.0, 0.0), np.array([2.4, 0.0])
    approach = Approach(part_m, 0.6, 10.0)
    way = around(thing).way(a_device().scan(), JOINTS, Pose2(2.0, 0.0, 0.0), approach)
    assert np.linalg.norm(way[-1].translation_m - part_m) <= 0.6 + 1e-9


def test_an_approach_ends_after_its_length():
    thing, approach = standing(1.5, 0.0), Approach(np.array([3.5, 0.0]), 0.6, 1.2)
    way = around(thing).way(a_device().scan(), JOINTS, Pose2(3.0, 0.0, 0.0), approach)
    legs_m = np.linalg.norm(np.diff([pose.translation_m for pose in (Pose2(), *way)], axis=0), axis=1)
    assert legs_m.sum() == pytest.approx(1.2)


def test_a_goal_outside_the_area_is_moved_into_it():
    corner = T_MAP_ODOM.translation_m
    area_m = (tuple(corner - 1.0), tuple(corner + 1.0))
    way = around(area_m=area_m).way(a_device().scan(), JOINTS, Pose2(5.0, 0.0, 0.0))
    end_m = T_MAP_ODOM.apply(way[-1].translation_m)
    assert (np.abs(end_m - corner) <= 1.0 + 1e-9).all()


def test_where_no_way_leads_the_robot_stays():
    walls = [standing(1.0, 0.0, (0.1, 2.1, 1.0), "front"), standing(-1.0, 0.0, (0.1, 2.1, 1.0), "back"),
             standing(0.0, 1.0, (2.1, 0.1, 1.0), "left"), standing(0.0, -1.0, (2.1, 0.1, 1.0), "right")]  # fmt: skip
    closed = around(*walls, rules=SearchRules(most_checks=300))
    assert closed.way(a_device().scan(), JOINTS, Pose2(3.0, 0.0, 0.0)) == ()


def test_who_does_not_know_where_he_is_drives_straight():
    class Lost:
        def base_pose(self, observation):
            return None

    goal = Pose2(3.0, 0.0, 0.0)
    assert around(standing(1.5, 0.0), where=Lost()).way(a_device().scan(), JOINTS, goal) == (goal,)


def test_a_robot_that_seems_to_stand_in_a_thing_can_leave_it():
    way = around(standing(0.3, 0.0, (0.4, 0.4, 0.3))).way(a_device().scan(), JOINTS, Pose2(-1.5, 0.0, 0.0))
    assert way[-1].translation_m == pytest.approx([-1.5, 0.0])


def test_a_start_that_is_known_is_carried_on_by_odometry():
    device = a_device()
    device.move_base(Pose2(1.0, 0.5, 0.4))
    found = KnownStart(T_MAP_ODOM).base_pose(device.scan())
    truth = T_MAP_ODOM @ device.true_pose_in_room()
    assert np.allclose([found.x_m, found.y_m, found.theta_rad], [truth.x_m, truth.y_m, truth.theta_rad])


def test_the_robots_own_tags_tell_where_it_is_and_odometry_where_they_do_not():
    stop = scan_over_part(ROBOT, LEG, LEG.layout(2), RadioSetup(scene="free_space"), np.random.default_rng(0))
    pose = RadioPose()
    assert pose.base_pose(a_device().scan()) is None
    found = pose.base_pose(stop.observation)
    assert 0 < found.x_m < 6
    assert 0 < found.y_m < 5
    deaf = a_device()
    deaf.move_base(Pose2(0.3, 0.0, 0.0))
    later = pose.base_pose(deaf.scan())
    assert later.translation_m == pytest.approx(found.apply(np.array([0.3, 0.0])))


def test_the_loop_gets_to_a_part_behind_a_thing_and_touches_nothing():
    thing, device = standing(1.4, 0.0, (0.2, 1.2, 1.0)), a_device(3.0, 0.0)
    steps = navigated(device, around(thing))
    assert steps[-1].in_reach
    assert not touches(device.true_way_in_room(), thing)
    straight = a_device(3.0, 0.0)
    navigated(straight, None)
    assert touches(straight.true_way_in_room(), thing)


def test_on_an_empty_map_the_loop_is_as_long_as_without_one():
    with_map, without = a_device(), a_device()
    navigated(with_map, around())
    navigated(without, None)
    ways_m = [np.array([pose.translation_m for pose in one.true_way_in_room()]) for one in (with_map, without)]
    assert np.allclose(*ways_m, atol=1e-9)


def test_without_a_map_the_device_is_told_what_it_always_was():
    device, goals = a_device(slip=WheelSlip()), []
    move = type(device).move_base

    class Noted:
        scan, move_arm = device.scan, device.move_arm

        def move_base(self, goal):
            goals.append(goal)
            return move(device, goal)

    loop = Fetch(ROBOT, Noted(), Told(device), ROBOT.posture("scan"))
    steps = list(loop.navigate())
    assert goals == [loop._half_way(step.estimate) for step in steps[:-1]]


def test_a_cut_way_is_shorter_and_free_and_has_the_same_ends():
    thing = Body("thing", Box(np.array([0.3, 1.0, 1.0])), np.eye(4))
    checker = MotionChecker(QuickCollisions(CollisionModel(ROBOT, World((thing,)))))
    corners = [(-2, 0), (-2, 2.5), (2, 2.5), (2, 0)]
    path = [Configuration(JOINTS, Pose2(float(x), float(y), 0.0)) for x, y in corners]
    short = shortened(checker, path, np.random.default_rng(0))
    assert cost_m(short) < 0.9 * cost_m(path)
    assert checker.check_path(short).free
    assert (short[0], short[-1]) == (path[0], path[-1])


def test_equal_seeds_give_equal_ways():
    thing = Body("thing", Box(np.array([0.3, 1.0, 1.0])), np.eye(4))
    checker = MotionChecker(QuickCollisions(CollisionModel(ROBOT, World((thing,)))))
    start = Configuration(JOINTS, Pose2(-1.5, 0.0, 0.0))
    one, other = (
        plan_short_drive(checker, start, Pose2(1.5, 0.0, 0.0), np.random.default_rng(3), SearchRules()) for _ in "ab"
    )
    assert [row.base for row in one] == [row.base for row in other]


@pytest.mark.parametrize("length_m", [0.5, 1.0, 1.7])
def test_the_first_part_of_a_way_has_its_length(length_m):
    path = [Configuration(JOINTS, Pose2(x, y, 0.0)) for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))]
    part = first_part(path, length_m)
    legs_m = np.linalg.norm(np.diff([row.base.translation_m for row in part], axis=0), axis=1)
    assert legs_m.sum() == pytest.approx(length_m)
    assert first_part(path, 5.0) == tuple(path)


@pytest.mark.parametrize(
    ("motion", "seconds"), [(Pose2(0.8, 0.0, 0.0), 1.0), (Pose2(0.0, -1.6, 0.5), 2.0), (Pose2(0.08, 0.0, -1.5), 1.5)]
)
def test_a_drive_takes_as_long_as_the_slower_of_driving_and_turning(motion, seconds):
    assert drive_time_s(motion) == pytest.approx(seconds)


def test_a_scan_takes_the_way_of_the_antenna_and_the_next_one_the_way_to_it():
    stop = scan_over_part(ROBOT, LEG, LEG.layout(2), RadioSetup(scene="free_space"), np.random.default_rng(0))
    account, way_m = TimeAccount(), track_m(stop.observation)
    along_m = np.linalg.norm(np.diff(way_m, axis=0), axis=1).sum()
    back_m = np.linalg.norm(way_m[-1] - way_m[0])
    account.scanned(stop.observation)
    assert account.close().scan_s == pytest.approx(along_m / CARRIER_M_S)
    account.scanned(stop.observation)
    assert account.close().scan_s == pytest.approx((along_m + back_m) / CARRIER_M_S)
    assert account.close().total_s == 0.0


def test_a_motion_of_the_arm_takes_as_long_as_its_slowest_joint():
    account, moved = TimeAccount(), JOINTS.copy()
    joint = int(np.flatnonzero(ROBOT.limits.velocity > 0)[0])
    moved[joint] += 0.4 * ROBOT.limits.velocity[joint]
    account.moved_arm(ROBOT, [JOINTS, moved, JOINTS])
    assert account.close().arm_s == pytest.approx(2 * 0.4 / 0.8)


def test_the_steps_hold_the_time_of_all_drives():
    device = a_device()
    steps = navigated(device, None)
    way = device.true_way_in_room()
    drives_s = sum(drive_time_s(one.inverse() @ other) for one, other in pairwise(way))
    assert sum(step.spent.drive_s for step in steps) == pytest.approx(drives_s)
    assert steps[0].spent.total_s == 0.0


def test_where_no_tag_is_heard_the_estimate_alone_tells_reach():
    device = a_device(0.55, 0.0)
    device.sensor = NoReader()
    (step,) = navigated(device, None, tags_tell_reach=False)
    assert step.in_reach
    with pytest.raises(TagNeverHeard):
        navigated(device, None)
