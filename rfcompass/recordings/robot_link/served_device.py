"""What a robot's server does with a command: read it, let the robot do it, write the reply. Knows no sockets."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from rfcompass.errors import RfCompassError, RobotFormatError, RobotRefused
from rfcompass.interfaces import AntennaCarrier, MobileManipulator, Scanner, StateReporter
from rfcompass.recordings.robot_link.errors_json import error_json
from rfcompass.recordings.robot_link.frames import (
    LONGEST_REPLY_BYTES,
    JsonObject,
    decode_frame,
    encode_frame,
    frame_id,
    shown,
)
from rfcompass.recordings.robot_link.heard import heard_json
from rfcompass.recordings.robot_link.values import (
    item,
    joints_of,
    numbers,
    outcome_json,
    pose_json,
    pose_of,
    state_json,
    text,
)

logger = logging.getLogger(__name__)


class Device(Scanner, MobileManipulator, StateReporter, Protocol):
    """A robot that scans, moves and says what it believes about itself; it may be an `AntennaCarrier` as well."""


@dataclass(frozen=True, slots=True)
class Command:
    """A command that was read.

    Attributes:
        number: Its id.
        name: What to do.
        content: The whole frame.
    """

    number: int
    name: str
    content: JsonObject


def read_command(line: bytes) -> Command:
    """Read a command.

    Raises:
        RobotFormatError: If it is none; carries the `id` where it has one.
    """
    frame = decode_frame(line)
    number = frame_id(frame)
    try:
        return Command(number, text(frame, "command"), frame)
    except RobotFormatError as error:
        raise error.with_numbers(id=number) from error


def reply_frame(number: int, reply: object) -> bytes:
    """Write a reply."""
    return encode_frame({"id": number, "reply": reply})


def error_frame(number: int | None, error: RfCompassError) -> bytes:
    """Write a refusal."""
    return encode_frame({"id": number, "error": error_json(error)})


@dataclass(frozen=True, slots=True)
class ServedDevice:
    """A robot, and how its commands are called.

    Args:
        device: The robot.
        name: Its name.
        joint_names: Its joints, in the order in which it takes and reports them.
    """

    device: Device
    name: str
    joint_names: Sequence[str]
    _commands: dict[str, Callable[[JsonObject], Any]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """List what the robot can do."""
        commands: dict[str, Callable[[JsonObject], Any]] = {
            "state": lambda _: state_json(self.device.state(), self.joint_names),
            "scan": lambda _: self._scan(),
            "move_base": self._move_base,
            "move_arm": self._move_arm,
            "close_hand": lambda _: outcome_json(self.device.close_hand()),
        }
        if isinstance(self.device, AntennaCarrier):
            commands["use_legs"] = self._use_legs
        object.__setattr__(self, "_commands", commands)

    @property
    def capabilities(self) -> tuple[str, ...]:
        """Names of the commands that the robot knows."""
        return tuple(self._commands)

    def answer(self, command: Command) -> bytes:
        """Do it and write the reply or the refusal; raises nothing, whatever the robot does."""
        try:
            frame = reply_frame(command.number, self._done(command))
            if len(frame) > LONGEST_REPLY_BYTES:
                raise RobotRefused(f"the answer to {command.name} has {len(frame)} bytes", reason="too_long")
        except RfCompassError as error:
            return error_frame(command.number, error)
        except Exception as cause:  # the robot's driver failed: the client must hear of it, and the server goes on
            logger.exception("%s failed", command.name)
            told = f"{command.name} failed: {type(cause).__name__}: {cause}"
            return error_frame(command.number, RobotRefused(told, command=command.name, reason="failed"))
        return frame

    def _done(self, command: Command) -> object:
        if command.name not in self._commands:
            known = ", ".join(self._commands)
            raise RobotRefused(f"{self.name} cannot {shown(command.name)}; it can: {known}", reason="not_capable")
        return self._commands[command.name](command.content)

    def _scan(self) -> JsonObject:
        seen, state = self.device.scan(), self.device.state()
        believed = {
            **state_json(state, self.joint_names),
            "base": pose_json(seen.base_pose),
            "base_covariance": seen.base_covariance.tolist(),
        }
        return {"stop_id": seen.stop_id, "state": believed, "heard": heard_json(seen.scan, seen.proximity)}

    def _move_base(self, content: JsonObject) -> JsonObject:
        return {"motion": pose_json(self.device.move_base(pose_of(item(content, "goal"), "goal")))}

    def _move_arm(self, content: JsonObject) -> JsonObject:
        self.device.move_arm(joints_of(item(content, "joints"), self.joint_names))
        return {}

    def _use_legs(self, content: JsonObject) -> JsonObject:
        legs_m = numbers(item(content, "legs_m"), "legs_m", (None, 2, 3))
        if isinstance(self.device, AntennaCarrier):
            self.device.use_legs(legs_m)
        return {}
