"""What a robot behind a socket heard, as a trace, is what it heard."""

from dataclasses import replace

import numpy as np
import pytest

from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase, open_trace, write_trace
from rfcompass.recordings.robot_link import RemoteRobot, RobotServer
from rfcompass.robots import YouBot
from rfcompass.simulation import PlaneRoom, RecordedStop, SimulatedRobot
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.studies.remote_fetching import RecordedRobot
from rfcompass.studies.remote_trace import remote_trace
from rfcompass.types import Observation, ReadTrace, Scan

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
LAYOUT = LEG.layout(2)
ROOM = PlaneRoom(T_room_base=Pose2(2.5, 2.5, 0.4), T_room_part=Pose2(3.0, 2.9, 1.2))


@pytest.fixture(scope="module")
def heard():
    """Two stops of a robot that hears by radio, as recorded on this side of the socket."""
    rng = np.random.default_rng(4)
    sensor = RadioSetup(scene="free_space").sensor(ROOM, ROBOT.layout, LAYOUT, rng)
    there = SimulatedRobot(ROBOT, LEG, LAYOUT, ROOM, rng, ROBOT.posture("scan").joints, sensor)
    with (
        RobotServer(there, ROBOT.name, ROBOT.joint_names) as server,
        RemoteRobot(server.host, server.port, ROBOT, LEG, LAYOUT) as remote,
    ):
        robot = RecordedRobot(remote, ROBOT)
        robot.scan()
        robot.move_base(Pose2(0.2, 0.1, 0.5))
        robot.scan()
    return robot.stops


def a_stop(*traces):
    anchors = ROBOT.tag_positions(ROBOT.posture("scan"))
    heights_m = LAYOUT.points_m[:, 2] + LEG.resting_height_m
    seen = Observation(0, anchors, LAYOUT, heights_m, scan=Scan({trace.epc: trace for trace in traces}, frame="hall"))
    return RecordedStop(seen, ROBOT.posture("scan"), None)


def a_trace(epc, positions_m, rng, **how):
    M = len(positions_m)
    return ReadTrace(
        epc=epc, antenna_positions_m=np.array(positions_m), frequencies_hz=np.array([920e6]),
        channel=rng.normal(size=(M, 1)) + 1j * rng.normal(size=(M, 1)), read_counts=np.full((M, 1), 3),
        antenna_ports=np.ones(M, dtype=np.int64), **how,
    )  # fmt: skip


def check_same(scan, expected):
    assert set(scan.traces) == set(expected.traces)
    for epc, trace in expected.traces.items():
        got = scan.traces[epc]
        rows = np.flatnonzero(got.mask.any(axis=1))
        heard_at = np.flatnonzero(trace.mask.any(axis=1))
        assert np.array_equal(got.antenna_positions_m[rows], trace.antenna_positions_m[heard_at])
        assert np.array_equal(got.antenna_ports[rows], trace.antenna_ports[heard_at])
        assert (got.tx_positions_m is None) == (trace.tx_positions_m is None)
        assert np.allclose(got.channel[rows], trace.channel[heard_at], rtol=1e-12, atol=0.0)


def test_each_stop_of_the_written_trace_is_the_scan_to_rounding(heard, tmp_path):
    write_trace(remote_trace(ROBOT, heard, "robbie"), tmp_path / "trace")
    trace = open_trace(tmp_path / "trace")
    assert trace.meta.geometry == "bistatic"
    assert trace.meta.frame == heard[0].observation.scan.frame
    assert trace.meta.source.startswith("robbie over a robot link")
    for stop in heard:
        expected = stop.observation.scan
        assert len(expected.traces) > 5
        check_same(trace.scan(stop.observation.stop_id), expected)


def test_the_stops_of_the_trace_are_what_the_robot_believed(heard):
    trace = remote_trace(ROBOT, heard, "robbie")
    for seen, stop in zip(trace.observations(ROBOT, LEG), heard, strict=True):
        assert seen.base_pose == stop.observation.base_pose
        assert np.array_equal(seen.base_covariance, stop.observation.base_covariance)
        assert np.array_equal(seen.anchors.points_m, stop.observation.anchors.points_m)


def test_tags_heard_from_different_places_keep_their_own_and_a_place_passed_twice_stays_two():
    rng = np.random.default_rng(0)
    one = a_trace(LAYOUT.epcs[0], [[0.0, 0.0, 0.3], [0.5, 0.0, 0.3], [0.0, 0.0, 0.3]], rng)
    other = a_trace(LAYOUT.epcs[1], [[0.5, 0.0, 0.3], [0.5, 0.4, 0.3]], rng)
    stop = a_stop(one, other)
    trace = remote_trace(ROBOT, [stop], "robbie")
    assert len(trace.antenna_poses.pose_ids) == 4
    check_same(trace.scan(0), stop.observation.scan)


def test_half_turns_and_a_frame_are_said_and_cells_without_a_channel_left_out():
    rng = np.random.default_rng(1)
    one = a_trace(LAYOUT.epcs[0], [[0.0, 0.0, 0.3], [0.5, 0.0, 0.3]], rng, phase_modulus_rad=np.pi)
    blank = replace(one, channel=np.array([[0.0], one.channel[1]]))
    trace = remote_trace(ROBOT, [a_stop(blank)], "robbie")
    assert (trace.meta.phase_modulus, trace.meta.geometry, trace.meta.frame) == ("pi", "monostatic", "hall")
    assert trace.reads.num_rows == 1


def test_a_stop_that_heard_nothing_is_a_stop_all_the_same():
    trace = remote_trace(ROBOT, [a_stop()], "robbie")
    assert trace.reads.num_rows == 0
    assert trace.stop_ids.tolist() == [0]
