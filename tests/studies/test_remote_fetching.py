"""A robot behind a socket whose answers do not make a run ends it in a typed error of the link."""

from types import SimpleNamespace

import numpy as np
import pytest
from same_records import differences

from rfcompass.errors import JointLimitError, RobotFrameError, RobotLost, RobotRefused
from rfcompass.geometry import Pose2
from rfcompass.localization import PosteriorLocalizer
from rfcompass.recordings import PartDatabase
from rfcompass.recordings.robot_link import Greeting, RemoteRobot, RobotServer
from rfcompass.robots import YouBot
from rfcompass.studies.fetching import FetchTask, SimulatedFetch
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.studies.remote_fetching import RecordedRobot, RemoteFetch, RemoteTask, check_able
from rfcompass.types import Observation, ReadTrace, RobotState, Scan

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
LAYOUT = LEG.layout(2)
COMMANDS = ("state", "scan", "move_base", "move_arm", "close_hand")


def heard_in(frame):
    trace = ReadTrace(
        epc=LAYOUT.epcs[0], antenna_positions_m=np.zeros((1, 3)), frequencies_hz=np.array([920e6]),
        channel=np.ones((1, 1)), read_counts=np.ones((1, 1), dtype=np.int64), antenna_ports=np.ones(1, dtype=np.int64),
    )  # fmt: skip
    return Scan({trace.epc: trace}, frame=frame)


class Teller:
    """Says at each scan what its script says."""

    def __init__(self, *script):
        self.script, self.scan_posture = list(script), ROBOT.posture("scan")

    def scan(self):
        told = self.script.pop(0)
        if isinstance(told, Exception):
            raise told
        stop_id, scan = told
        heights_m = LAYOUT.points_m[:, 2] + LEG.resting_height_m
        return Observation(stop_id, ROBOT.tag_positions(self.scan_posture), LAYOUT, heights_m, scan=scan)

    def state(self):
        return RobotState(self.scan_posture.joints, Pose2(), np.zeros((3, 3)))

    def move_arm(self, joints):
        raise JointLimitError("too far", joint="arm_joint_2", command="move_arm")


@pytest.mark.parametrize(
    "second", [(5, Scan()), (4, Scan()), (6, heard_in("corridor"))], ids=["same stop", "older stop", "another frame"]
)
def test_a_stop_that_cannot_follow_the_last_one_is_no_answer_and_not_kept(second):
    robot = RecordedRobot(Teller((5, heard_in("hall")), second), ROBOT)
    robot.scan()
    with pytest.raises(RobotFrameError):
        robot.scan()
    assert [stop.observation.stop_id for stop in robot.stops] == [5]


def test_a_silent_stop_in_between_has_no_frame():
    robot = RecordedRobot(Teller((0, heard_in("hall")), (1, Scan()), (7, heard_in("hall"))), ROBOT)
    for _ in range(3):
        robot.scan()
    assert [stop.observation.stop_id for stop in robot.stops] == [0, 1, 7]


def test_what_the_robot_calls_bad_input_is_its_refusal_and_not_ours():
    with pytest.raises(RobotRefused) as caught:
        RecordedRobot(Teller(), ROBOT).move_arm(np.zeros(len(ROBOT.joint_names)))
    assert caught.value.numbers == {"joint": "arm_joint_2", "command": "move_arm", "reason": "JointLimitError"}


def test_that_a_robot_is_lost_is_said_as_it_was():
    lost = RobotLost("gone", command="scan", id=3)
    with pytest.raises(RobotLost) as caught:
        RecordedRobot(Teller(lost), ROBOT).scan()
    assert caught.value is lost


@pytest.mark.parametrize("lacks", COMMANDS)
def test_a_robot_that_lacks_a_command_is_refused_before_anything_moves(lacks):
    able = SimpleNamespace(greeting=Greeting("robbie", (), tuple(name for name in COMMANDS if name != lacks), False))
    if lacks == "close_hand":
        check_able(able, grasp=False)
    with pytest.raises(RobotRefused) as caught:
        check_able(able, grasp=True)
    assert caught.value.numbers["missing"] == [lacks]


@pytest.mark.slow
def test_by_radio_the_first_stops_are_those_of_a_room_whose_carrier_never_comes_near():
    task = FetchTask(
        robot=ROBOT, part=LEG, tags=2, localizer=PosteriorLocalizer(), seed=2, radio=RadioSetup(scene="free_space"),
        active_stops=True,
    )  # fmt: skip
    local = [judged.step for judged, _ in zip(SimulatedFetch(task).steps(), range(3), strict=False)]
    far = RemoteTask(robot=ROBOT, part=LEG, tags=2, localizer=PosteriorLocalizer(), active_stops=True)
    with (
        RobotServer(SimulatedFetch(task).device, ROBOT.name, ROBOT.joint_names) as server,
        RemoteRobot(server.host, server.port, ROBOT, LEG, far.layout) as remote,
    ):
        through = [told.step for told, _ in zip(RemoteFetch(far, remote).steps(), range(3), strict=False)]
    assert [differences(a, b) for a, b in zip(through, local, strict=True)] == [[]] * 3
