"""A task on a live page: what is drawn later arrives there as well, and what is out of date is gone."""

import numpy as np
import pytest

from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.types import PartEstimate
from rfcompass.types.configuration import Configuration
from rfcompass.viz.live_task import LiveTask
from rfcompass.viz.meshcat_page import RecordingWindow

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
SCAN = ROBOT.posture("scan")
SQUARE = 0.1 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@pytest.fixture
def task():
    live = LiveTask(ROBOT, SCAN, open_browser=False, pace_s=0.0)
    yield live
    live.close()


def sent(task, monkeypatch):
    """Everything that goes to the server from now on."""
    commands = []
    monkeypatch.setattr(task.live.visualizer.window, "send", lambda command: commands.append(command.lower()))
    return commands


def test_the_server_has_the_robot_from_the_start(task):
    assert task.live.url.startswith("http://127.0.0.1")
    assert len(task.live.visualizer.static_html()) > 100_000


def test_the_robot_drives_on_the_page_and_leaves_its_way(task, monkeypatch):
    commands = sent(task, monkeypatch)
    task.robot_at(Configuration(SCAN.joints, Pose2(1.0, 0.5, 0.2)))
    moved = {row["path"] for row in commands if row["type"] == "set_transform"}
    assert any(path.endswith("robot/base_link") for path in moved)
    assert any(row["type"] == "set_object" and row["path"].endswith("path/base") for row in commands)


def test_what_is_known_replaces_what_was_known_before(task, monkeypatch):
    commands = sent(task, monkeypatch)
    draws = np.random.default_rng(0).normal(size=(50, 3))
    task.known(PartEstimate(LEG.part_id, np.zeros(2), 1.0, "told", 1, region_m=SQUARE, samples=draws), Pose2())
    kinds = [(row["type"], row["path"].removeprefix("/meshcat/")) for row in commands]
    assert kinds == [
        ("delete", "region"),
        ("delete", "belief"),
        ("set_object", "region/estimate"),
        ("set_object", "belief/cloud"),
    ]


def test_a_part_is_drawn_once_and_then_moved(task, monkeypatch):
    commands = sent(task, monkeypatch)
    for x_m in (0.5, 0.7):
        T = np.eye(4)
        T[0, 3] = x_m
        task.part_at(LEG, LEG.layout(2).points_m, T)
    bodies = [row for row in commands if row["type"] == "set_object" and row["path"].endswith("table_leg_3/body")]
    places = [row["matrix"][12] for row in commands if row["path"].endswith("parts/table_leg_3") and "matrix" in row]
    assert len(bodies) == 1
    assert places[-2:] == [0.5, 0.7]


def test_a_window_that_nobody_follows_keeps_its_commands_to_itself():
    window = RecordingWindow()
    window.visualizer()["x"].delete()
    assert len(window.commands) == 1
