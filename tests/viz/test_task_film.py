"""The film of a task: everything appears when it was known, and parts ride with the robot."""

import numpy as np
import pytest

from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.types import PartEstimate
from rfcompass.types.configuration import Configuration
from rfcompass.viz.overlay import StageMark
from rfcompass.viz.robot_scene import RobotScene
from rfcompass.viz.task_film import Film, FilmedPart, FilmedStop, draw_film

ROBOT = YouBot()
LEGS = PartDatabase(":memory:").assembly("LACK")[:2]
JOINTS = ROBOT.posture("scan").joints
SQUARE = 0.1 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def an_estimate(leg, samples=0):
    draws = np.random.default_rng(0).normal(size=(samples, 3))
    return PartEstimate(leg.part_id, np.array([0.5, 0.0]), 1.0, "told", 1, region_m=SQUARE, samples=draws)


def a_film():
    bases = [Pose2(), Pose2(1.0, 0.0, 0.5), Pose2(2.0, 1.0, 0.0)]
    stops = (
        FilmedStop(0.0, 1.0, bases[0], an_estimate(LEGS[0])),
        FilmedStop(1.0, 2.0, bases[1], an_estimate(LEGS[1], samples=400)),
    )
    moved = np.eye(4)
    moved[:3, 3] = 2.0, 1.0, 0.025
    parts = (
        FilmedPart(LEGS[0], LEGS[0].layout(4).points_m, (0.0, 2.0), (np.eye(4), moved)),
        FilmedPart(LEGS[1], LEGS[1].layout(4).points_m, (1.0,), (np.eye(4),)),
    )
    pictures = tuple(Configuration(JOINTS, base) for base in bases)
    return Film((0.0, 1.0, 2.0), pictures, stops, parts, (StageMark("table_leg_1", 0.0), StageMark("table_leg_2", 1.0)))


def tracks(window, kind):
    """Keys of one kind of track, by the last names of the node's path."""
    (animation,) = [command for command in window.commands if command["type"] == "set_animation"]
    found = {}
    for row in animation["animations"]:
        for track in row["clip"]["tracks"]:
            if track["name"] == kind:
                found["/".join(row["path"].split("/")[-2:])] = [
                    (key["time"] / 30, key["value"]) for key in track["keys"]
                ]
    return found


@pytest.fixture(scope="module")
def drawn():
    return draw_film(ROBOT, a_film(), [("table_leg_1", "delivered")])


def test_what_was_known_at_a_stop_is_shown_until_the_next(drawn):
    shown = tracks(drawn.window, ".visible")
    assert shown["region/stop_0"] == [(0.0, True), (1.0, False)]
    assert shown["region/stop_1"] == [(0.0, False), (1.0, True), (2.0, False)]
    assert shown["belief/stop_1"] == shown["region/stop_1"]
    assert "belief/stop_0" not in shown  # no draws, no cloud


def test_a_part_appears_when_it_is_found_and_then_moves(drawn):
    assert tracks(drawn.window, ".visible")["parts/table_leg_2"] == [(0.0, False), (1.0, True)]
    ways = tracks(drawn.window, ".position")
    assert ways["parts/table_leg_1"] == [(0.0, [0.0, 0.0, 0.0]), (2.0, [2.0, 1.0, 0.025])]
    assert "parts/table_leg_2" not in ways


def test_the_page_has_a_row_for_every_layer_and_a_mark_for_every_part(drawn):
    assert [layer.node for layer in drawn.overlay.layers] == ["robot", "path", "parts", "region", "belief"]
    assert [mark.name for mark in drawn.overlay.stages] == ["table_leg_1", "table_leg_2"]
    assert drawn.html() == draw_film(ROBOT, a_film(), [("table_leg_1", "delivered")]).html()


@pytest.mark.parametrize("end_s", [None, 3.0])
def test_a_node_that_is_shown_for_a_while_is_hidden_in_the_end(end_s):
    scene = RobotScene()
    scene.show_between("region/x", 1.0, end_s)
    (last,) = [c for c in scene.window.commands if c["type"] == "set_property" and c["property"] == "visible"]
    assert last["value"] is (end_s is None)
