"""The whole job through a socket is the same job; and it ends where the robot is lost."""

import itertools

import numpy as np
import pytest
from same_records import differences

from planners.fetch import Fetch
from planners.grasp import GraspPlanner
from planners.near_antenna import NearAntenna
from planners.pick_up import PickUp
from rfcompass.errors import GraspFailed, RobotLinkError, RobotLost
from rfcompass.recordings import PartDatabase
from rfcompass.recordings.robot_link import RemoteRobot, RobotServer, reads_json
from rfcompass.recordings.robot_link.heard import heard_of
from rfcompass.robots import YouBot
from rfcompass.studies.fetch_modes import NOISY_DISTANCE, Mode, fetch_mode
from rfcompass.studies.fetch_trace import fetch_trace
from rfcompass.studies.fetching import FetchTask, SimulatedFetch
from rfcompass.studies.radio_setup import standing_m
from rfcompass.types.reads import TagRead

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")


def a_task(proximity, seed):
    how = fetch_mode(Mode.BEST, proximity)
    return FetchTask(
        robot=ROBOT, part=LEG, tags=4, localizer=how.localizer, seed=seed, radio=how.radio, meter=how.meter,
        near=how.near,
    )  # fmt: skip


def a_loop(task, room, device):
    antenna = None
    if task.near is not None:
        antenna = NearAntenna(device, task.near, keep_out_m=standing_m(room.device.sensor.scene))
    start = ROBOT.posture("scan")
    return Fetch(ROBOT, device, task.localizer, start, task.rules, task.meter, antenna)


def everything(loop):
    """All steps and tries, and why it ended."""
    events, end = [], None
    try:
        events += loop.steps()
        for event in PickUp(loop, GraspPlanner(ROBOT), LEG).events(events[-1]):
            events.append(event)
    except GraspFailed as failure:
        end = failure.message, failure.numbers
    return events, end


def served(task):
    room = SimulatedFetch(task)
    return room, RobotServer(room.device, ROBOT.name, ROBOT.joint_names)


def remote(server, task):
    return RemoteRobot(server.host, server.port, ROBOT, LEG, LEG.layout(task.tags, task.spacing))


@pytest.mark.parametrize(
    ("proximity", "seed"),
    [(NOISY_DISTANCE, 4), *(pytest.param(*job, marks=pytest.mark.slow) for job in ((NOISY_DISTANCE, 1), (None, 1)))],
)
def test_a_fetch_through_the_socket_is_the_same_to_the_last_bit(proximity, seed):
    task = a_task(proximity, seed)
    room = SimulatedFetch(task)
    direct = everything(a_loop(task, room, room.device))
    far_room, server = served(task)
    with server, remote(server, task) as device:
        through = everything(a_loop(task, far_room, device))
    assert len(direct[0]) > 5
    assert [differences(a, b) for a, b in itertools.zip_longest(through[0], direct[0])] == [[]] * len(direct[0])
    assert through[1] == direct[1]
    assert far_room.device.true_pose_in_room() == room.device.true_pose_in_room()


def test_what_a_reader_reports_read_by_read_is_the_scan_that_was_averaged_at_once():
    """What a bridge sends and what the reference server sends are the same scan."""
    room = SimulatedFetch(a_task(None, 2))
    seen = room.device.scan()
    trace = fetch_trace(ROBOT, room.stops)
    names = [name for name in trace.reads.column_names if name != "stop_id"]
    reads = [TagRead(**{name: row[name] for name in names}) for row in trace.reads.to_pylist()]
    heard = heard_of(reads_json(reads, trace.antenna_poses, trace.meta), {*seen.anchors.epcs, *seen.part.epcs})
    assert differences(dict(sorted(heard.scan.traces.items())), dict(sorted(seen.scan.traces.items()))) == []


def test_a_robot_that_is_lost_ends_the_loop_and_no_antenna_looks_from_elsewhere():
    task = a_task(NOISY_DISTANCE, 1)
    room, server = served(task)

    class Antenna:
        looked = 0

        def comes_nearer(self, *_):
            return False

        def looks_from_elsewhere(self):
            self.looked += 1
            return self.looked < 3

        def found(self):
            return None

    class DriesUp(RemoteRobot):
        def move_base(self, T_base_goal):
            motion = super().move_base(T_base_goal)
            server.stop()
            return motion

    layout = LEG.layout(task.tags, task.spacing)
    with server, DriesUp(server.host, server.port, ROBOT, LEG, layout) as device:
        loop = a_loop(task, room, device)
        loop.antenna = Antenna()
        steps = loop.steps()
        next(steps)
        before = loop.antenna.looked, len(room.stops)
        with pytest.raises(RobotLost) as caught:
            next(steps)
        assert caught.value.numbers["command"] == "scan"
        with pytest.raises(RobotLinkError):
            next(a_loop(task, room, device).steps())
    assert (loop.antenna.looked, len(room.stops)) == before
    assert np.array_equal(room.device.joints, ROBOT.posture("scan").joints)
