"""One fetch with a robot behind a socket: the loop of a simulated fetch, without a room, and so without truth."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from planners.fetch import Fetch, FetchStep
from planners.grasp import GraspPlanner
from planners.pick_up import GraspTrial, PickUp
from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError, RobotFrameError, RobotRefused
from rfcompass.geometry.pose2 import Pose2
from rfcompass.interfaces import Localizer, ProximityMeter
from rfcompass.recordings.robot_link import RemoteRobot
from rfcompass.robots import Robot
from rfcompass.simulation import RecordedStop
from rfcompass.studies.fetch_job import ReportedStep
from rfcompass.studies.fetching import SCAN_POSTURE, final_stops
from rfcompass.types.grasps import GraspOutcome
from rfcompass.types.observation import Observation
from rfcompass.types.parts import Part
from rfcompass.types.tags import TagLayout


@dataclass(frozen=True, slots=True, kw_only=True)
class RemoteTask:
    """What to fetch with a robot that is elsewhere; what it hears with, and where, is its own affair.

    Attributes:
        robot: What kind of robot it is; it measures from its posture "scan".
        part: What lies on the floor.
        tags: Number of tags on the part, K.
        spacing: Which placement of K tags.
        localizer: Finds the part.
        meter: Measures proximities where the robot sends reads.
        active_stops: Whether the last stops are chosen by what they would tell.
    """

    robot: Robot
    part: Part
    tags: int
    localizer: Localizer
    spacing: str = "ends"
    meter: ProximityMeter | None = None
    active_stops: bool = False

    @property
    def layout(self) -> TagLayout:
        """The part's tags that are on."""
        return self.part.layout(self.tags, self.spacing)


@dataclass(slots=True)
class RecordedRobot:
    """A robot behind a socket, and what it heard at each stop (`Scanner`, `MobileManipulator`).

    What the robot refuses as bad input ends a run, and is not what the user handed in: it becomes a `RobotRefused`.

    Args:
        remote: The robot.
        robot: What kind of robot it is.
    """

    remote: RemoteRobot
    robot: Robot
    stops: list[RecordedStop] = field(init=False, default_factory=list)

    def scan(self) -> Observation:
        """Inventory all tags once, and keep what was heard.

        Raises:
            RobotFrameError: If the number of the stop does not grow, or the antenna's frame is another than before.
            RobotLinkError: If the robot is lost or refuses.
        """
        with _refusing("scan"):
            seen, state = self.remote.scan(), self.remote.state()
        self._check_follows(seen)
        at = self.robot.configuration(state.joints, seen.base_pose)
        self.stops.append(RecordedStop(seen, at, None))
        return seen

    def move_base(self, T_base_goal: Pose2) -> Pose2:
        """Drive; raises `RobotLinkError` if the robot is lost or refuses, as the two below."""
        with _refusing("move_base"):
            return self.remote.move_base(T_base_goal)

    def move_arm(self, joints: FloatArray) -> None:
        """Move the joints, in the order of the robot's `joint_names`, shape (Q,)."""
        with _refusing("move_arm"):
            self.remote.move_arm(joints)

    def close_hand(self) -> GraspOutcome:
        """Close the jaws and report whether something is held."""
        with _refusing("close_hand"):
            return self.remote.close_hand()

    def _check_follows(self, seen: Observation) -> None:
        """A trace has each stop once, and all antenna positions in one frame."""
        if not self.stops:
            return
        last = self.stops[-1].observation
        if seen.stop_id <= last.stop_id:
            message = f"stop {seen.stop_id} came after stop {last.stop_id}"
            raise RobotFrameError(message, command="scan", stop=seen.stop_id)
        frames = {stop.observation.scan.frame for stop in self.stops if stop.observation.scan.traces}
        if seen.scan.traces and frames - {seen.scan.frame}:
            message = f"the antenna was in frame {seen.scan.frame} at stop {seen.stop_id}, and in another before"
            raise RobotFrameError(message, command="scan", stop=seen.stop_id, frame=seen.scan.frame)


class RemoteFetch:
    """The loop with a robot behind a socket.

    No link tells how the antenna may be moved or what stands around: the antenna drives the robot's own track at every
    stop, and the base drives straight.

    Args:
        task: What to fetch.
        remote: The robot.
    """

    def __init__(self, task: RemoteTask, remote: RemoteRobot) -> None:
        """Command nothing yet."""
        self._task, self._device = task, RecordedRobot(remote, task.robot)
        self._start = task.robot.posture(SCAN_POSTURE)
        final = final_stops(task.robot) if task.active_stops else None
        self._loop = Fetch(task.robot, self._device, task.localizer, self._start, meter=task.meter, final=final)

    @property
    def stops(self) -> tuple[RecordedStop, ...]:
        """All stops so far, one whose localisation failed included."""
        return tuple(self._device.stops)

    def steps(self) -> Iterator[ReportedStep]:
        """Bring the arm into the posture to measure from, then run the loop.

        Raises:
            RobotLinkError: If the robot is lost, or refuses a command.
            NoAnswer: If the loop ends without the part; the subclass says why.
        """
        self._device.move_arm(self._start.joints)
        for step in self._loop.steps():
            yield ReportedStep(step)

    def pick_up(self, found: ReportedStep) -> Iterator[ReportedStep | GraspTrial]:
        """Grasp the part.

        Args:
            found: The last step of `steps`.

        Raises:
            RobotLinkError: If the robot is lost, or refuses a command.
            GraspFailed: If the part is not in the hand at the end; says why.
            NoAnswer: If the part is lost after a failed try.
            RobotModelError: If the robot has no hand of two fingers.
        """
        for event in PickUp(self._loop, GraspPlanner(self._task.robot), self._task.part).events(found.step):
            yield ReportedStep(event) if isinstance(event, FetchStep) else event


def check_able(remote: RemoteRobot, *, grasp: bool) -> None:
    """Refuse a robot that lacks a command of the loop, before anything moves.

    Raises:
        RobotRefused: If it does; carries what is `missing`.
    """
    needed = {"state", "scan", "move_base", "move_arm", *(("close_hand",) if grasp else ())}
    if missing := sorted(needed - set(remote.greeting.capabilities)):
        message = f"{remote.greeting.robot} cannot {', '.join(missing)}; a fetch needs that"
        raise RobotRefused(message, reason="not_capable", missing=missing)


@contextmanager
def _refusing(command: str) -> Iterator[None]:
    try:
        yield
    except InputError as error:
        numbers = {**error.numbers, "command": command, "reason": error.kind}
        raise RobotRefused(f"{command} was refused: {error.message}", **numbers) from error
