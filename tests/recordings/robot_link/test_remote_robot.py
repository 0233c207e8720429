"""The client: same robot, other process. Whatever the other side does, it ends in a typed error, and nothing twice."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from same_records import differences
from scripted_robot import JOINTS, LAYOUT, LEG, ROBOT, ScriptedRobot

from rfcompass.errors import (
    InputError,
    JointLimitError,
    RobotBusy,
    RobotFrameError,
    RobotLost,
    RobotModelError,
    RobotRefused,
    RobotSchemaError,
    ShapeError,
)
from rfcompass.geometry import Pose2
from rfcompass.recordings.robot_link import RemoteRobot, RobotLink, RobotServer

GOAL = Pose2(0.25, -0.5, 0.125)
HELLO = {
    "schema": "rfcompass-robot-link/1", "robot": "youbot", "joints": list(JOINTS), "resumed": True,
    "capabilities": ["move_base", "scan"],
}  # fmt: skip


def connected(server, **times):
    return RemoteRobot(server.host, server.port, ROBOT, LEG, LAYOUT, **times)


@pytest.fixture
def device():
    return ScriptedRobot()


@pytest.fixture
def served(device):
    with RobotServer(device, "youbot", JOINTS) as server:
        yield server
        device.go.set()


class Impostor:
    """Accepts connections one after the other and says to each what its script says, then hangs up."""

    def __init__(self, *scripts):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.host, self.port = self.listener.getsockname()
        self.heard, self.scripts, self.done = [], scripts, threading.Event()
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def _run(self):
        for script in self.scripts:
            connection = self.listener.accept()[0]
            with connection, connection.makefile("rb") as lines:
                for answer in script:
                    self.heard.append(json.loads(lines.readline()))
                    if answer == "silence":
                        self.done.wait(10.0)
                    elif answer is not None:
                        with_id = isinstance(answer, dict) and "id" not in answer
                        frame = {"id": self.heard[-1]["id"], **answer} if with_id else answer
                        connection.sendall(frame if isinstance(frame, bytes) else json.dumps(frame).encode() + b"\n")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.done.set()
        self.thread.join(10.0)
        self.listener.close()


GREETS = {"reply": HELLO}


def test_a_drive_a_posture_and_a_scan_are_done_once_each(served, device):
    with connected(served) as robot:
        assert robot.move_base(GOAL) == GOAL
        joints = np.array(device.joints) + 0.01
        robot.move_arm(joints)
        seen = robot.scan()
        assert differences(robot.state(), device.state()) == []
    assert (device.moves, device.arm_moves, device.scans) == ([GOAL], 1, 1)
    assert np.array_equal(device.joints, joints)
    assert np.array_equal(seen.anchors.points_m, ROBOT.tag_positions(ROBOT.configuration(joints)).points_m)
    assert seen.base_pose == GOAL


def test_the_outcome_of_a_grasp_comes_back_with_its_reason(served, device):
    with connected(served) as robot:
        assert differences(robot.close_hand(), device.close_hand()) == []


def test_joints_find_their_places_by_name(device):
    order = np.arange(len(JOINTS))[::-1]

    class Backwards(ScriptedRobot):
        def state(self):
            state = super().state()
            return type(state)(state.joints[order], state.base, state.base_covariance)

        def move_arm(self, joints):
            super().move_arm(joints[order])

    backwards = Backwards()
    with RobotServer(backwards, "youbot", JOINTS[::-1]) as server, connected(server) as robot:
        wanted = np.array(robot.state().joints) + 0.01 * np.arange(len(JOINTS))
        robot.move_arm(wanted)
        assert np.array_equal(robot.state().joints, wanted)
        assert np.array_equal(backwards.joints, wanted)


def test_a_refusal_comes_back_as_what_it_was_and_the_robot_can_go_on(served, device):
    with connected(served) as robot:
        with pytest.raises(JointLimitError) as caught:
            robot.move_arm(np.full(len(JOINTS), 9.0))
        assert caught.value.numbers["joint"] == "arm_joint_1"
        assert caught.value.numbers["command"] == "move_arm"
        assert robot.unanswered is None
        assert robot.move_base(GOAL) == GOAL


def test_values_that_are_no_posture_are_refused_before_anything_is_sent(served, device):
    with connected(served) as robot:
        for joints in (np.zeros(2), np.full(len(JOINTS), np.nan)):
            with pytest.raises(ShapeError):
                robot.move_arm(joints)
    assert device.arm_moves == 0


def test_a_robot_that_carries_no_antenna_says_so(served):
    with connected(served) as robot, pytest.raises(RobotRefused) as caught:
        robot.use_legs(np.zeros((1, 2, 3)))
    assert caught.value.numbers["reason"] == "not_capable"


def test_another_robot_is_not_taken_for_ours(device):
    with RobotServer(device, "ur5e", ("shoulder",)) as server, pytest.raises(RobotModelError):
        connected(server)


def test_a_second_client_is_refused(served):
    with connected(served), pytest.raises(RobotBusy):
        connected(served)


def test_nobody_there_is_a_robot_lost():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    for nobody in (port, 70_000):
        with pytest.raises(RobotLost):
            RemoteRobot("127.0.0.1", nobody, ROBOT, LEG, LAYOUT)


def test_who_accepts_and_says_nothing_is_a_robot_lost():
    with Impostor(["silence"]) as server, pytest.raises(RobotLost, match="within"):
        connected(server, timeout_s=0.05)


@pytest.mark.parametrize(
    ("answer", "error"),
    [
        ({"reply": {**HELLO, "schema": "rfcompass-robot-link/2"}}, RobotSchemaError),
        ({"reply": {}}, RobotSchemaError),
        ({"reply": 7}, RobotSchemaError),
        ({"reply": {**HELLO, "joints": 3}}, RobotFrameError),
        ({"reply": {"schema": HELLO["schema"]}}, RobotFrameError),
        ({}, RobotFrameError),
        ({"id": 7, **GREETS}, RobotFrameError),
        (b"220 mail.example ESMTP\n", RobotFrameError),
        (b"\n", RobotFrameError),
        (b'{"id":0', RobotLost),
        (None, RobotLost),
    ],
)
def test_a_greeting_that_is_none_is_a_typed_error(answer, error):
    with Impostor([answer]) as server, pytest.raises(error):
        connected(server)


@pytest.mark.parametrize(
    "answer",
    [b"hm\n", b"[]\n", {"id": 9, "reply": {}}, {"id": None, "reply": {}}, {}, {"reply": {"motion": [1, 2]}},
     {"reply": {"motion": [1, 2, None]}}, {"reply": None}],
    ids=str,
)  # fmt: skip
def test_an_answer_that_is_none_closes_the_connection(answer):
    with Impostor([GREETS, answer]) as server, connected(server) as robot:
        with pytest.raises(RobotFrameError):
            robot.move_base(GOAL)
        with pytest.raises(RobotLost, match="reconnect"):
            robot.move_base(GOAL)
    assert [frame["command"] for frame in server.heard] == ["hello", "move_base"]


@settings(max_examples=25)
@given(st.binary(min_size=1, max_size=60).map(lambda piece: piece.replace(b"\n", b"x") + b"\n"))
def test_whatever_is_answered_the_error_is_typed(line):
    with Impostor([GREETS, line]) as server, connected(server) as robot, pytest.raises(RobotFrameError):
        robot.scan()


def test_an_answer_without_end_is_cut_off():
    with Impostor([GREETS, b"x" * 5000]) as server:
        link = RobotLink(server.host, server.port, longest_reply_bytes=1000)
        with pytest.raises(RobotFrameError, match="longer than 1000"):
            link.ask("state", 5.0)
        link.close()


def test_a_server_that_could_not_read_our_number_refuses_the_command():
    refusal = {"id": None, "error": {"kind": "RobotFormatError", "message": "what?", "numbers": {}}}
    with Impostor([GREETS, refusal]) as server, connected(server) as robot, pytest.raises(InputError, match="what"):
        robot.move_base(GOAL)


def test_a_slow_robot_is_lost_and_found_and_has_driven_once(served, device):
    device.hold = True
    with connected(served, command_s=0.05) as robot:
        with pytest.raises(RobotLost) as caught:
            robot.move_base(GOAL)
        assert caught.value.numbers["command"] == robot.unanswered == "move_base"
        robot.reconnect()
        with pytest.raises(RobotLost):
            robot.repeat_unanswered()
        device.go.set()
        robot.reconnect()
        assert robot.state().base == GOAL
        assert robot.unanswered == "move_base"
        assert robot.repeat_unanswered(10.0) == GOAL
        assert robot.unanswered is None
        with pytest.raises(InputError):
            robot.repeat_unanswered()
        assert robot.state().base == GOAL
    assert device.moves == [GOAL]


def test_a_command_that_never_arrived_is_done_when_it_is_repeated_and_only_then():
    scripts = [GREETS, None], [GREETS, {"reply": {"motion": [0.25, -0.5, 0.125]}}]
    with Impostor(*scripts) as server, connected(server) as robot:
        with pytest.raises(RobotLost):
            robot.move_base(GOAL)
        robot.reconnect()
        assert [frame["command"] for frame in server.heard] == ["hello", "move_base", "hello"]
        assert robot.repeat_unanswered() == GOAL
    first, again = server.heard[1], server.heard[3]
    assert first == again
    assert server.heard[0]["session"] == server.heard[2]["session"]


def test_a_server_that_has_forgotten_us_is_not_asked_to_drive_again(device):
    """Started anew, it cannot know whether the drive was done; so nobody may say that it was not."""
    device.hold = True
    with RobotServer(device, "youbot", JOINTS) as server:
        robot = connected(server, command_s=0.05)
        with pytest.raises(RobotLost):
            robot.move_base(GOAL)
        device.go.set()
    with server:
        robot.reconnect()
        with pytest.raises(RobotRefused) as caught:
            robot.repeat_unanswered()
        assert caught.value.numbers["reason"] == "forgotten"
        assert robot.state().base == GOAL
        assert robot.move_base(GOAL) == GOAL
        robot.close()
    assert len(device.moves) == 2


def test_ctrl_c_during_a_drive_leaves_no_answer_for_the_next_command(served, device, monkeypatch):
    with connected(served) as robot:

        def interrupted(*_):
            raise KeyboardInterrupt

        monkeypatch.setattr(RobotLink, "_receive", interrupted)
        with pytest.raises(KeyboardInterrupt):
            robot.move_base(GOAL)
        monkeypatch.undo()
        assert device.driving.wait(10.0)
        with pytest.raises(RobotLost):
            robot.state()
        robot.reconnect()
        assert robot.state().base == GOAL
        assert robot.repeat_unanswered() == GOAL


SERVE = """
import sys, time
sys.path[:0] = {path!r}
from scripted_robot import JOINTS, ScriptedRobot
from rfcompass.recordings.robot_link import RobotServer
robot = ScriptedRobot()
robot.hold = True
with RobotServer(robot, "youbot", JOINTS) as server:
    print(server.port, flush=True)
    robot.driving.wait()
    print("driving", flush=True)
    time.sleep(60)
"""


@contextmanager
def another_process():
    here = Path(__file__).parent
    code = SERVE.format(path=[str(here), str(here.parents[2])])
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    try:
        yield process, int(process.stdout.readline())
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def test_a_server_killed_in_the_middle_of_a_drive_is_a_robot_lost():
    with another_process() as (process, port), RemoteRobot("127.0.0.1", port, ROBOT, LEG, LAYOUT) as robot:

        def kill():
            process.stdout.readline()
            os.kill(process.pid, signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        with pytest.raises(RobotLost) as caught:
            robot.move_base(GOAL)
        killer.join()
        assert caught.value.numbers["command"] == "move_base"
        with pytest.raises(RobotLost):
            robot.reconnect()
        with pytest.raises(RobotLost):
            robot.repeat_unanswered()
