"""Robots by name."""

import pickle
import subprocess
import sys

import pytest

import rfcompass.robots
from rfcompass.errors import UnknownRobot
from rfcompass.robots import describe_robot, known_robots, library, load_robot
from rfcompass.robots.layouts import data_folder


@pytest.fixture
def without_extra(monkeypatch):
    """As if the robots extra were not installed."""
    monkeypatch.setattr(library, "extra_folder", lambda: None)


def test_our_robots_are_there_without_the_extra(without_extra):
    assert known_robots() == ("ur5e_2f85", "youbot")
    assert load_robot("youbot", "skew6").description.layout_name == "youbot_skew6"


def test_an_unknown_robot_lists_the_known_ones_and_the_way_to_more(without_extra):
    with pytest.raises(UnknownRobot, match=r"'panda'.*youbot.*pip install rfcompass\[robots\]") as caught:
        load_robot("panda")
    assert caught.value.numbers == {"name": "panda", "known": ["ur5e_2f85", "youbot"]}


def test_a_bare_urdf_takes_a_layout():
    path = data_folder() / "youbot.urdf"
    assert load_robot(path).layout.epcs == ()
    robot = load_robot(path, "youbot_x4")
    assert len(robot.layout.epcs) == 9
    assert robot.name == "youbot"


def test_a_description_file_is_a_robot():
    assert load_robot(data_folder() / "robots" / "youbot.json").posture("scan").joints.shape == (7,)


def test_a_description_survives_the_trip_between_processes():
    description = pickle.loads(pickle.dumps(describe_robot("youbot")))
    assert description.postures["scan"]["gripper_finger_joint_l"] == 0.025


def test_importing_the_package_imports_nothing_heavy():
    code = (
        "import sys, rfcompass.robots; print(*sorted({'pinocchio', 'numba', 'yourdfpy', 'trimesh'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_every_public_name_can_be_imported():
    for name in rfcompass.robots.__all__:
        assert getattr(rfcompass.robots, name).__name__ == name
    with pytest.raises(AttributeError, match="YouBot"):
        _ = rfcompass.robots.PR3
