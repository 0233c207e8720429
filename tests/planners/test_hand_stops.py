"""Stops with the hand over the floor: bases that are bolted down stay, and nothing touches at a free stop."""

from dataclasses import replace

from grasp_scenes import ROBOT, SCAN, box_at

from planners.hand_stops import FreeStops, HandStops
from rfcompass.robots import CollisionModel, QuickCollisions, Robot
from rfcompass.types import World

STOPS = HandStops(robot=ROBOT, count=8)


def moved(stops):
    return [stop.configuration.base != SCAN.base for stop in stops]


def test_every_other_stop_is_after_a_drive_and_none_for_a_base_that_is_bolted_down():
    assert moved(STOPS.candidates(SCAN)) == [False, True] * 4
    bolted = Robot(replace(ROBOT.description, base="fixed"))
    assert moved(HandStops(robot=bolted, count=8).candidates(SCAN)) == [False] * 8


def test_stops_in_an_obstacle_are_left_out_and_the_others_stay():
    bars = (box_at("left", (0.6, 0.02, 0.02), 0.6, 0.15, 0.1), box_at("right", (0.6, 0.02, 0.02), 0.6, -0.15, 0.1))
    checker = QuickCollisions(CollisionModel(ROBOT, World(bars)))
    offered = STOPS.candidates(SCAN)
    left = FreeStops(proposer=STOPS, collisions=checker).candidates(SCAN)
    assert 0 < len(left) < len(offered)
    kept = {stop.configuration.joints.tobytes() for stop in left}
    assert all(
        checker.collides(stop.configuration) for stop in offered if stop.configuration.joints.tobytes() not in kept
    )
    assert not any(checker.collides(stop.configuration) for stop in left)
