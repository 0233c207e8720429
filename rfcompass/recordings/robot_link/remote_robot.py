"""A robot behind a socket, behind the protocols of one in this process."""

from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError, RobotFormatError, RobotFrameError, RobotModelError, RobotRefused
from rfcompass.geometry.pose2 import Pose2
from rfcompass.recordings.robot_link.heard import heard_of
from rfcompass.recordings.robot_link.link import Greeting, RobotLink
from rfcompass.recordings.robot_link.values import (
    integer,
    item,
    joints_json,
    outcome_of,
    pose_json,
    pose_of,
    state_of,
)
from rfcompass.types.grasps import GraspOutcome
from rfcompass.types.observation import Observation
from rfcompass.types.parts import Part
from rfcompass.types.robot_state import RobotState
from rfcompass.types.tags import TagLayout

if TYPE_CHECKING:
    from rfcompass.robots import Robot  # pinocchio is slow to import, and only names are needed here

LOOPBACK = "127.0.0.1"


class RemoteRobot:
    """A client of `rfcompass-robot-link/1` (`Scanner`, `MobileManipulator`, `StateReporter`, `AntennaCarrier`).

    What the robot reports are its joints and reads; forward kinematics is run here. A command is sent once. If its
    answer is lost (`RobotLost`), the robot may or may not have done it: `reconnect`, look at `state`, and let
    `repeat_unanswered` have the answer, without the robot doing it twice. To command something else gives it up.

    Args:
        host: Name or address of the robot's server.
        port: TCP port.
        robot: What kind of robot it is.
        part: What is looked for; it lies on the floor.
        layout: Which of the part's tags are on.
        timeout_s: How long connecting and `state` may take [s].
        command_s: How long a scan or a motion may take [s].

    Raises:
        RobotLinkError: If the robot cannot be reached, is busy, or speaks another protocol.
        RobotModelError: If its joints are others than those of `robot`.
    """

    def __init__(
        self,
        host: str,
        port: int,
        robot: "Robot",
        part: Part,
        layout: TagLayout,
        *,
        timeout_s: float = 5.0,
        command_s: float = 120.0,
    ) -> None:
        self._robot, self._part, self._layout = robot, part, layout
        self._timeout_s, self._command_s = timeout_s, command_s
        self._decoders: dict[str, Callable[[Any], Any]] = {
            "scan": self._observation,
            "move_base": lambda reply: pose_of(item(reply, "motion"), "motion"),
            "move_arm": lambda _: None,
            "close_hand": outcome_of,
            "use_legs": lambda _: None,
            "state": lambda reply: state_of(reply, robot.joint_names),
        }
        self._link = RobotLink(host, port, timeout_s=timeout_s)
        try:
            _check_joints(self._link.greeting, robot)
        except RobotModelError:
            self._link.close()
            raise

    @property
    def greeting(self) -> Greeting:
        """What the robot's side says about itself."""
        return self._link.greeting

    @property
    def unanswered(self) -> str | None:
        """The command whose answer was lost; None if there is none."""
        return self._link.unanswered

    def state(self) -> RobotState:
        """Ask for odometry and joints."""
        state: RobotState = self._asked("state", self._timeout_s)
        return state

    def scan(self) -> Observation:
        """Inventory all tags once; the robot's tags are where its joints say."""
        observation: Observation = self._asked("scan", self._command_s)
        return observation

    def move_base(self, T_base_goal: Pose2) -> Pose2:
        """Drive to a pose given in the present base frame; return the believed motion."""
        motion: Pose2 = self._asked("move_base", self._command_s, goal=pose_json(T_base_goal))
        return motion

    def move_arm(self, joints: FloatArray) -> None:
        """Move the joints, in the order of the robot's `joint_names`, shape (Q,)."""
        values = self._robot.configuration(joints).joints
        self._asked("move_arm", self._command_s, joints=joints_json(values, self._robot.joint_names))

    def close_hand(self) -> GraspOutcome:
        """Close the jaws and report whether something is held."""
        outcome: GraspOutcome = self._asked("close_hand", self._command_s)
        return outcome

    def use_legs(self, legs_m: FloatArray) -> None:
        """Let the antenna's carrier drive other legs from now on [m], shape (L, 2, 3)."""
        self._asked("use_legs", self._command_s, legs_m=legs_m.tolist())

    def reconnect(self) -> None:
        """Connect anew after `RobotLost`; commands nothing.

        Raises:
            RobotLinkError: If the robot cannot be reached, is busy, or speaks another protocol.
            RobotModelError: If another robot is there now.
        """
        self._link.reconnect()
        _check_joints(self._link.greeting, self._robot)

    def repeat_unanswered(self, wait_s: float | None = None) -> Pose2 | Observation | GraspOutcome | RobotState | None:
        """Ask for the answer that was lost; the robot does what it has not done, and nothing twice.

        Args:
            wait_s: How long the answer may take [s]; as long as any other if None.

        Returns:
            What the command would have returned.

        Raises:
            InputError: If every command was answered.
            RobotRefused: If the robot's side has forgotten this client, so that nobody knows what was done.
            RfCompassError: What the command would have raised.
        """
        command = self._link.unanswered
        if command is None:
            raise InputError("every command was answered: there is nothing to repeat")
        return self._decoded(command, self._link.ask_again(self._command_s if wait_s is None else wait_s))

    def close(self) -> None:
        """Hang up."""
        self._link.close()

    def __enter__(self) -> Self:
        """Use it."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Hang up."""
        self.close()

    def _asked(self, command: str, wait_s: float, **fields: object) -> Any:  # noqa: ANN401 - one of five types
        if command not in self.greeting.capabilities:
            known = ", ".join(self.greeting.capabilities)
            message = f"{self.greeting.robot} cannot {command}; it can: {known}"
            raise RobotRefused(message, command=command, reason="not_capable")
        return self._decoded(command, self._link.ask(command, wait_s, **fields))

    def _decoded(self, command: str, reply: object) -> Any:  # noqa: ANN401 - one of five types
        try:
            return self._decoders[command](reply)
        except RobotFormatError as cause:
            self._link.close()
            numbers = {**cause.numbers, "command": command}
            raise RobotFrameError(f"the answer to {command} makes no sense: {cause.message}", **numbers) from cause

    def _observation(self, reply: object) -> Observation:
        state = state_of(item(reply, "state"), self._robot.joint_names)
        anchors = self._robot.tag_positions(self._robot.configuration(state.joints, state.base))
        heard = heard_of(item(reply, "heard"), {*anchors.epcs, *self._layout.epcs})
        return Observation(
            stop_id=integer(item(reply, "stop_id"), "stop_id"),
            anchors=anchors,
            part=self._layout,
            part_tag_heights_m=self._layout.points_m[:, 2] + self._part.resting_height_m,
            scan=heard.scan,
            proximity=heard.proximity,
            base_pose=state.base,
            base_covariance=state.base_covariance,
        )


def _check_joints(greeting: Greeting, robot: "Robot") -> None:
    if set(greeting.joints) != set(robot.joint_names):
        theirs, ours = ", ".join(greeting.joints), ", ".join(robot.joint_names)
        message = f"{greeting.robot} has joints {theirs}; a {robot.name} has {ours}"
        raise RobotModelError(message, joints=list(greeting.joints), expected=list(robot.joint_names))
