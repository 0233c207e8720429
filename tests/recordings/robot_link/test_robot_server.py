"""The server survives whatever is said to it, obeys one client at a time, and does nothing twice."""

import json
import logging
import socket
import threading
import time
from contextlib import suppress

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scripted_robot import JOINTS, LineClient, ScriptedRobot

from rfcompass.errors import RobotLinkError
from rfcompass.recordings.robot_link import RobotServer
from rfcompass.recordings.robot_link import server as server_module
from rfcompass.recordings.robot_link.frames import LONGEST_COMMAND_BYTES

NESTED = {"id": json.loads("[" * 900 + "]" * 900)}
DRIVE = {"command": "move_base", "goal": [1.0, 0.0, 0.0]}


@pytest.fixture
def device():
    return ScriptedRobot()


@pytest.fixture
def served(device):
    with RobotServer(device, "youbot", JOINTS) as server:
        yield server
        device.go.set()


@pytest.fixture
def client(served):
    with LineClient(served) as line:
        line.hello()
        yield line


def kind(frame):
    return frame["error"]["kind"]


def test_hello_tells_who_is_there_and_what_it_can_do(served):
    with LineClient(served) as line:
        told = line.hello()
    assert told["id"] == 0
    assert told["reply"] == {
        "schema": "rfcompass-robot-link/1", "robot": "youbot", "joints": list(JOINTS),
        "capabilities": ["state", "scan", "move_base", "move_arm", "close_hand"], "resumed": False,
    }  # fmt: skip


@pytest.mark.parametrize(
    "first", [b"GET / HTTP/1.1\r\n", {"id": 1, "command": "move_base", "goal": [1, 0, 0]}, {"id": 1}]
)
def test_who_does_not_say_hello_first_is_sent_away_and_nothing_moves(served, device, first):
    with LineClient(served) as line:
        assert kind(line.ask(first)) == "RobotFormatError"
        assert line.hear() is None
    assert not device.moves


def test_another_version_is_named_and_sent_away(served):
    with LineClient(served) as line:
        assert kind(line.hello(schema=NESTED)) == "RobotSchemaError"
    with LineClient(served) as line:
        told = line.hello(schema="rfcompass-robot-link/2")
        assert kind(told) == "RobotSchemaError"
        assert told["error"]["numbers"]["expected"] == "rfcompass-robot-link/1"
        assert line.hear() is None


@pytest.mark.parametrize(
    "said",
    [b"\n", b"{\n", b"[]\n", b"\x00\xff\n", b'{"id":1e999}\n', {}, {"id": -1}, {"id": 1}, {"id": 1, "command": 3},
     {"id": "1"}, {"id": 1, "command": "move_base"}, {"id": 1, "command": "move_base", "goal": [1, 0]},
     {"id": 1, "command": "move_base", "goal": ["1", 0, 0]}, {"id": 1, "command": "move_arm", "joints": [0] * 5},
     {"id": 1, "command": "move_arm", "joints": {"elbow": 1}}, {"id": 1, "command": "hello"},
     {"id": 1, "command": "use_legs", "legs_m": []}, {"id": 1, "command": "fly"}, {"id": 1, "command": "fly" * 300_000},
     NESTED, {"id": 1, "command": "move_base", "goal": NESTED["id"]}, {"id": 1, "command": NESTED["id"]}],
    ids=lambda said: str(said)[:60],
)  # fmt: skip
def test_what_makes_no_sense_is_answered_with_an_error_and_the_next_command_is_done(client, device, said):
    assert kind(client.ask(said)) in ("RobotFormatError", "RobotRefused")
    assert client.ask({"id": 2, **DRIVE}) == {"id": 2, "reply": {"motion": [1.0, 0.0, 0.0]}}
    assert len(device.moves) == 1
    assert device.arm_moves == 0


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.binary(max_size=40), max_size=5))
def test_garbage_never_crashes_it(served, garbage):
    with LineClient(served) as line:
        if "reply" not in line.hello(session="a"):
            pytest.fail("the earlier client is still there")
        for piece in garbage:
            line.say(piece.replace(b"\n", b"") + b"\n")
            assert "error" in line.hear()
        assert "reply" in line.ask({"id": 1 + _last(line), **DRIVE})


def _last(line):
    """The last number that was used: told by asking with number 0."""
    return line.ask({"id": 0, "command": "scan"})["error"]["numbers"].get("last_id", 0)


@pytest.mark.parametrize("greets", [True, False])
def test_a_line_that_is_too_long_ends_the_connection_and_not_the_server(served, device, greets):
    """However much the client still has to say, it hears why, and then that the server has hung up."""
    with LineClient(served) as line:
        if greets:
            line.hello()
        line.say(b" " * (10 * LONGEST_COMMAND_BYTES))
        assert kind(line.hear()) == "RobotFormatError"
        assert line.hear() is None
        with LineClient(served) as other:  # need not wait until the first has left
            assert "reply" in other.hello(session="b")
    assert not device.moves


def test_a_driver_that_fails_is_a_refusal(client, caplog):
    with caplog.at_level(logging.CRITICAL):
        answers = [client.ask({"id": number, "command": "scan"}) for number in (1, 2, 3, 4)]
    assert ["error" in answer for answer in answers] == [False, False, True, False]
    assert answers[2]["error"]["numbers"]["reason"] == "failed"
    assert "ZeroDivisionError" in answers[2]["error"]["message"]


def test_a_second_client_is_told_that_the_robot_is_busy_until_the_first_has_left(served, client, device):
    with LineClient(served) as other:
        told = other.hello(session="b")
        assert kind(told) == "RobotBusy"
        assert other.hear() is None
    assert "reply" in client.ask({"id": 1, **DRIVE})
    client.socket.shutdown(socket.SHUT_WR)
    assert client.hear() is None
    with LineClient(served) as other:
        assert other.hello(session="b")["reply"]["resumed"] is False
        assert "reply" in other.ask({"id": 1, **DRIVE})
    assert len(device.moves) == 2


def test_the_same_command_asked_twice_is_done_once_and_answered_alike(client, device):
    once, again = client.ask({"id": 5, **DRIVE}), client.ask({"id": 5, **DRIVE})
    assert once == again
    assert len(device.moves) == 1


def test_looking_at_the_state_does_not_make_it_forget(client, device):
    once = client.ask({"id": 5, **DRIVE})
    assert "reply" in client.ask({"id": 6, "command": "state"})
    assert client.ask({"id": 5, **DRIVE}) == once
    assert len(device.moves) == 1


@pytest.mark.parametrize("number", [5, 4, 0])
def test_a_number_is_used_once(client, device, number):
    client.ask({"id": 5, **DRIVE})
    assert kind(client.ask({"id": number, "command": "move_base", "goal": [0, 1, 0]})) == "RobotFormatError"
    assert len(device.moves) == 1


def test_a_client_that_comes_back_in_the_middle_of_a_drive_waits_for_it(served, device):
    device.hold = True
    with LineClient(served) as line:
        line.hello()
        line.say({"id": 1, **DRIVE})
        assert device.driving.wait(10.0)
    with LineClient(served) as line:
        assert line.hello()["reply"]["resumed"] is True
        line.say({"id": 1, **DRIVE})
        device.go.set()
        assert line.hear() == {"id": 1, "reply": {"motion": [1.0, 0.0, 0.0]}}
    assert len(device.moves) == 1


def test_a_client_that_comes_back_replaces_its_own_connection_that_hangs(served):
    with LineClient(served) as dead, LineClient(served) as line:
        dead.hello()
        assert line.hello()["reply"]["resumed"] is True
        assert "reply" in line.ask({"id": 1, "command": "state"})
        with suppress(ConnectionResetError):
            assert dead.hear() is None


def test_what_a_client_left_behind_on_an_old_connection_is_void(served, device):
    with LineClient(served) as old, LineClient(served) as line:
        old.hello()
        assert line.hello()["reply"]["resumed"] is True
        with suppress(ConnectionError):
            old.ask({"id": 1, **DRIVE})
        assert "reply" in line.ask({"id": 2, "command": "scan"})
    assert not device.moves


def test_what_waits_on_the_old_connection_of_a_client_who_came_back_is_never_done(served, device):
    device.hold = True
    with LineClient(served) as old, LineClient(served) as line:
        old.hello()
        old.say(b"".join(json.dumps({"id": number, **DRIVE}).encode() + b"\n" for number in (1, 2)))
        assert device.driving.wait(10.0)
        line.hello()
        device.go.set()
        for number in (3, 4, 5):  # by then the server has come to what waited
            assert line.ask({"id": number, "command": "state"})["reply"]["base"] == [1.0, 0.0, 0.0]
    assert len(device.moves) == 1


def test_nobody_else_gets_a_robot_that_is_still_driving(served, device):
    device.hold = True
    with LineClient(served) as line:
        line.hello()
        line.say({"id": 1, **DRIVE})
        assert device.driving.wait(10.0)
    with LineClient(served) as other:
        assert kind(other.hello(session="b")) == "RobotBusy"
    device.go.set()
    deadline_s = time.monotonic() + 10.0
    while time.monotonic() < deadline_s:
        with LineClient(served) as other:
            if "reply" in other.hello(session="b"):
                return
    pytest.fail("the robot has driven, and nobody gets it")


def test_nobody_else_gets_a_robot_that_drives_for_a_client_who_came_back_and_left(served, device):
    device.hold = True
    with LineClient(served) as line:
        line.hello()
        line.say({"id": 1, **DRIVE})
        assert device.driving.wait(10.0)
        with LineClient(served) as back:
            assert back.hello()["reply"]["resumed"] is True
            back.socket.shutdown(socket.SHUT_WR)
            assert back.hear() is None
    with LineClient(served) as other:
        told = other.hello(session="b")
    assert told["error"]["numbers"]["reason"] == "working"


def test_who_says_nothing_is_sent_away(device, monkeypatch):
    monkeypatch.setattr(server_module, "HELLO_S", 0.05)
    with RobotServer(device, "youbot", JOINTS) as server, LineClient(server) as silent:
        assert silent.hear() is None


def test_strangers_who_say_nothing_are_few(served):
    strangers = [LineClient(served) for _ in range(server_module.MOST_CONNECTIONS)]
    try:
        with LineClient(served) as line:
            assert line.hear() is None
    finally:
        for stranger in strangers:
            stranger.close()


def test_stopping_waits_for_the_robot_and_ends_all_threads(device):
    device.hold = True
    before = threading.active_count()
    server = RobotServer(device, "youbot", JOINTS)
    server.start()
    with LineClient(server) as line:
        line.hello()
        line.say({"id": 1, **DRIVE})
        assert device.driving.wait(10.0)
        stopping = threading.Thread(target=server.stop)
        stopping.start()
        stopping.join(0.1)
        assert stopping.is_alive()
        device.go.set()
        stopping.join(10.0)
    assert device.base.x_m == 1.0
    assert threading.active_count() == before
    server.stop()
    with pytest.raises(OSError, match="refused"):
        LineClient(server)


def test_it_starts_again_on_the_same_port(device):
    server = RobotServer(device, "youbot", JOINTS)
    for _ in range(2):
        with server, LineClient(server) as line:
            port = server.port
            assert line.hello()["reply"]["resumed"] is False
        assert server.port == port


def test_a_client_that_takes_no_bytes_does_not_keep_it_from_stopping(device):
    with RobotServer(device, "youbot", JOINTS) as server, LineClient(server) as line:
        line.hello()
        line.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        for number in range(1, 2000):
            line.say({"id": number, "command": "state"})


@pytest.mark.parametrize("port", [70_000, "taken"])
def test_a_port_that_cannot_be_had_is_an_error(device, served, port):
    wanted = served.port if port == "taken" else port
    with pytest.raises(RobotLinkError):
        RobotServer(device, "youbot", JOINTS, port=wanted).start()


def test_what_it_sends_is_one_line_for_each_answer(client):
    client.say({"id": 1, "command": "scan"})
    assert json.loads(client.lines.readline())["reply"]["stop_id"] == 0
