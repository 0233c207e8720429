"""`fetch --device` over the served simulator is the same fetch; without a robot it ends in a typed error."""

import json
import socket
import threading
from contextlib import contextmanager

import numpy as np
import pytest

from rfcompass.localization import ConsistencyLocalizer
from rfcompass.recordings import PartDatabase, open_trace
from rfcompass.recordings.robot_link import RemoteRobot, RobotServer
from rfcompass.robots import YouBot
from rfcompass.studies.fetching import FetchTask, SimulatedFetch

SEED, TAGS = 3, 2
HOW = ("table_leg_3", "--tags", TAGS, "--proximity", "noisy_distance", "--database", ":memory:", "--json")


@contextmanager
def served():
    robot, leg = YouBot(), PartDatabase(":memory:").part("table_leg_3")
    room = SimulatedFetch(FetchTask(robot=robot, part=leg, tags=TAGS, localizer=ConsistencyLocalizer(), seed=SEED))
    with RobotServer(room.device, robot.name, robot.joint_names) as server:
        yield server


@contextmanager
def answering_with(line):
    """Something else that listens: it says one line to whoever comes, and hangs up."""
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def attend():
            with listener.accept()[0] as connection:
                connection.recv(1 << 16)
                connection.sendall(line)

        thread = threading.Thread(target=attend)
        thread.start()
        yield "{}:{}".format(*listener.getsockname())
        thread.join()


def address(server):
    return f"{server.host}:{server.port}"


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("device")
    return folder / "local", folder / "remote"


@pytest.fixture
def both(run, runs):
    """A fetch in the room of a seed, and one with the robot served from it; later uses read the answers."""
    local, remote = runs
    if not remote.exists():
        ran = run("fetch", *HOW, "--seed", SEED, "--out", local)
        (local.parent / "local.json").write_text(json.dumps([ran.code, ran.json]))
        with served() as server:
            ran = run("fetch", *HOW, "--device", address(server), "--out", remote)
        (local.parent / "remote.json").write_text(json.dumps([ran.code, ran.json]))
    return [json.loads((local.parent / f"{name}.json").read_text()) for name in ("local", "remote")]


def test_the_answer_is_that_of_a_local_fetch_but_for_the_truth(both):
    (local_code, local), (remote_code, remote) = both
    assert (local_code, remote_code) == (0, 0)
    assert remote["grasp"]["held"]
    assert local.pop("simulated_error") is not None
    assert remote.pop("simulated_error") is None
    assert {**remote, "run": None} == {**local, "run": None}


def test_the_run_folder_is_that_of_a_local_fetch_but_for_where_it_comes_from(both, runs):
    local, remote = runs
    assert {path.name for path in remote.iterdir()} == {path.name for path in local.iterdir()}
    for name in ("estimate.json", "events.jsonl", "trace/stops.csv", "trace/proximity.parquet"):
        assert (remote / name).read_bytes() == (local / name).read_bytes(), name
    asked = json.loads((remote / "run.json").read_text())
    assert asked["device"].startswith("127.0.0.1:")
    assert not {"seed", "scene", "sigma", "map"} & set(asked)
    ours, theirs = (json.loads((folder / "trace" / "meta.json").read_text()) for folder in (remote, local))
    assert "robot link" in ours["source"]
    assert {key for key in theirs if ours.get(key) != theirs[key]} == {"source", "license", "reader"}


def test_locate_finds_in_the_trace_what_the_remote_fetch_found(run, both, runs):
    answer = both[1][1]
    options = (
        "--part",
        "table_leg_3",
        "--last",
        answer["stops"],
        "--estimator",
        "consistency",
        "--database",
        ":memory:",
    )
    found = run("locate", runs[1] / "trace", *options, "--json").json
    assert found["centre_m"] == answer["centre_m"]
    assert found["theta_rad"] == answer["theta_rad"]


def test_a_robot_that_goes_away_ends_the_run_and_what_it_heard_is_kept(run, tmp_path, monkeypatch):
    drive, drives = RemoteRobot.move_base, []
    folder = tmp_path / "run"
    with served() as server:

        def drives_twice(self, T_base_goal):
            drives.append(drive(self, T_base_goal))
            if len(drives) == 2:
                server.stop()
            return drives[-1]

        monkeypatch.setattr(RemoteRobot, "move_base", drives_twice)
        ran = run("fetch", *HOW, "--device", address(server), "--out", folder)
    assert ran.code == 1
    assert ran.json["failure"]["kind"] == "RobotLost"
    assert ran.json["failure"]["command"] == "scan"
    assert json.loads((folder / "estimate.json").read_text()) == ran.json
    assert len((folder / "events.jsonl").read_text().splitlines()) == 2
    assert np.array_equal(open_trace(folder / "trace").stop_ids, [0, 1])
    assert len(drives) == 2


def test_a_robot_that_goes_away_before_it_has_heard_anything_leaves_nothing(run, tmp_path, monkeypatch):
    with served() as server:
        monkeypatch.setattr(RemoteRobot, "move_arm", lambda self, joints: server.stop())
        ran = run("fetch", *HOW, "--device", address(server), "--out", tmp_path / "run")
    assert (ran.code, ran.json["failure"]["kind"]) == (1, "RobotLost")
    assert list(tmp_path.iterdir()) == []


def test_where_nobody_listens_there_is_no_answer_and_nothing_is_left(run, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        nobody = "{}:{}".format(*taken.getsockname())
    ran = run("fetch", *HOW, "--device", nobody, "--out", tmp_path / "run")
    assert (ran.code, ran.json["failure"]["kind"]) == (1, "RobotLost")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        (b"HTTP/1.1 400 Bad Request\r\n\r\n", "RobotFrameError"),
        (b"", "RobotLost"),
        (b'{"id":0,"reply":{"schema":"rfcompass-robot-link/9"}}\n', "RobotSchemaError"),
    ],
)
def test_who_speaks_another_protocol_is_no_robot_of_ours(run, tmp_path, line, kind):
    with answering_with(line) as device:
        ran = run("fetch", *HOW, "--device", device, "--out", tmp_path / "run")
    assert (ran.code, ran.json["failure"]["kind"]) == (1, kind)
    assert list(tmp_path.iterdir()) == []


def test_another_kind_of_robot_is_bad_input(run, tmp_path):
    with served() as server:
        ran = run("fetch", *HOW, "--robot", "ur5e_2f85", "--device", address(server), "--out", tmp_path / "run")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, "RobotModelError")
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_is_there_is_not_replaced_and_no_robot_is_asked(run, both, runs):
    ran = run("fetch", *HOW, "--device", "127.0.0.1:1", "--out", runs[1])
    assert (ran.code, ran.json["failure"]["kind"]) == (2, "TraceError")


@pytest.mark.parametrize(
    "options",
    [
        ("--seed", 0),
        ("--sigma", 0.05),
        ("--map",),
        ("--no-map",),
        ("--deliver", "1,0,0"),
        ("--silent", "table_leg_3"),
        ("--all-of", "LACK"),
        ("--scene", "room_los"),
        ("--occluded",),
        ("--others",),
    ],
)
def test_what_only_a_simulated_room_has_is_refused_by_name(run, tmp_path, options):
    out = ("--device", "127.0.0.1:1", "--out", tmp_path / "run", "--database", ":memory:", "--json")
    ran = run("fetch", *([] if options[0] == "--all-of" else ["table_leg_3"]), *options, *out)
    assert (ran.code, ran.json["failure"]["kind"]) == (2, "InputError")
    assert ran.json["failure"]["options"] == ["--map" if options[0] == "--no-map" else options[0]]
    assert list(tmp_path.iterdir()) == []


def test_several_parts_are_refused(run, tmp_path):
    ran = run("fetch", "table_leg_1", *HOW, "--device", "127.0.0.1:1", "--out", tmp_path / "run")
    assert (ran.code, ran.json["failure"]["kind"], ran.json["failure"]["parts"]) == (2, "InputError", 2)


@pytest.mark.parametrize(
    "device", ["", "5090", ":5090", "host", "host:", "host:http", "host:0", "host:65536", "host:²"]
)
def test_an_address_is_a_host_and_a_port(run, tmp_path, device):
    ran = run("fetch", *HOW, "--device", device, "--out", tmp_path / "run")
    assert (ran.code, ran.json["failure"]["kind"], ran.json["failure"]["got"]) == (2, "InputError", device)
