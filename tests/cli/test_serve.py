"""`rfcompass robots serve` puts a simulated robot behind a socket, and ends politely."""

import json
import signal
import subprocess
import sys

import pytest
from same_records import differences

from rfcompass.localization import ConsistencyLocalizer
from rfcompass.recordings import PartDatabase
from rfcompass.recordings.robot_link import RemoteRobot
from rfcompass.robots import YouBot
from rfcompass.studies.fetching import FetchTask, SimulatedFetch

CALL = "import sys; from rfcompass.cli import main; sys.argv[0] = 'rfcompass'; main()"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_served_robot_is_that_of_the_seed_and_a_signal_ends_it_with_exit_code_0(number, tmp_path):
    options = ["table_leg_3", "--no-radio", "--seed", "3", "--port", "0", "--database", tmp_path / "parts.db", "--json"]
    command = [sys.executable, "-c", CALL, "robots", "serve", *map(str, options)]
    robot, leg = YouBot(), PartDatabase(":memory:").part("table_leg_3")
    task = FetchTask(robot=robot, part=leg, tags=4, localizer=ConsistencyLocalizer(), seed=3)
    expected = SimulatedFetch(task).device.scan()
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        try:
            told = json.loads(process.stdout.readline())
            with RemoteRobot(told["host"], told["port"], robot, leg, leg.layout(4, task.spacing)) as remote:
                assert differences(remote.scan(), expected) == []
            process.send_signal(number)
            assert process.wait(20.0) == 0
        finally:
            process.kill()


def test_a_part_that_nobody_knows_is_bad_input(run, tmp_path):
    assert run("robots", "serve", "table_leg_9", "--database", tmp_path / "parts.db").code == 2


def test_an_address_that_cannot_be_had_is_no_answer(run, tmp_path):
    options = ("--no-radio", "--host", "192.0.2.1", "--database", tmp_path / "parts.db", "--json")
    ran = run("robots", "serve", "table_leg_3", *options)
    assert ran.code == 1
    assert ran.json["failure"]["kind"] == "RobotLinkError"
