"""One connection to a robot's server: a command goes out, its answer comes back, and nothing is sent twice unasked.

When the connection breaks while a command is under way, nobody here knows whether the robot did it. The command keeps
its number; `ask_again` sends it under that number, and the server answers from memory if it was done already.
"""

import secrets
import socket
import time
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from rfcompass.errors import (
    InputError,
    RfCompassError,
    RobotFormatError,
    RobotFrameError,
    RobotLost,
    RobotRefused,
    RobotSchemaError,
)
from rfcompass.recordings.robot_link.errors_json import error_of
from rfcompass.recordings.robot_link.frames import (
    LONGEST_REPLY_BYTES,
    READ_ONLY,
    SCHEMA,
    JsonObject,
    decode_frame,
    encode_frame,
    frame_id,
    shown,
)
from rfcompass.recordings.robot_link.values import item, text

_RECEIVE_BYTES = 1 << 18


@dataclass(frozen=True, slots=True)
class Greeting:
    """What the robot's side says about itself.

    Attributes:
        robot: Name of the robot.
        joints: Names of its joints.
        capabilities: Commands that it knows.
        resumed: Whether it remembers this client, and so what it did for it last.
    """

    robot: str
    joints: tuple[str, ...]
    capabilities: tuple[str, ...]
    resumed: bool


@dataclass(frozen=True, slots=True)
class _Sent:
    """A command on its way."""

    number: int
    command: str
    frame: bytes


class RobotLink:
    """A connection on which both sides have greeted each other.

    Args:
        host: Name or address of the robot's server.
        port: TCP port.
        timeout_s: How long connecting and the greeting may take [s].
        longest_reply_bytes: What is longer is no answer but a fault.

    Raises:
        RobotLost: If there is no connection, or no greeting in time.
        RobotBusy: If the robot has another client.
        RobotSchemaError: If the other side speaks another version.
    """

    def __init__(
        self, host: str, port: int, *, timeout_s: float = 5.0, longest_reply_bytes: int = LONGEST_REPLY_BYTES
    ) -> None:
        self._peer: dict[str, Any] = {"host": host, "port": port}
        self._timeout_s, self._longest_bytes = timeout_s, longest_reply_bytes
        self._session = secrets.token_hex(8)
        self._last_id = 0
        self._socket: socket.socket | None = None
        self._buffer = bytearray()
        self._unanswered: _Sent | None = None
        self._forgotten = False
        self.greeting = self._connected()

    @property
    def unanswered(self) -> str | None:
        """The command whose answer was lost; None if there is none."""
        return None if self._unanswered is None else self._unanswered.command

    def ask(self, command: str, wait_s: float, **fields: object) -> Any:  # noqa: ANN401 - JSON
        """Send a command and return the value of its reply.

        Args:
            command: Name of the command.
            wait_s: How long the answer may take [s].
            **fields: What the command needs.

        Raises:
            RobotLost: If the connection is gone, or no answer comes in time; the connection is closed then.
            RobotFrameError: If the answer is none.
            RfCompassError: What the robot refused it with.
        """
        frame = encode_frame({"id": self._last_id + 1, "command": command, **fields})
        if self._socket is None:
            raise RobotLost(f"{self._name} was lost before {command}: reconnect first", command=command, **self._peer)
        self._last_id += 1
        sent = _Sent(self._last_id, command, frame)
        if command in READ_ONLY:  # to look does not give up what is unanswered
            return self._exchanged(sent, wait_s)
        self._unanswered, self._forgotten = sent, False
        return self._answer(sent, wait_s)

    def ask_again(self, wait_s: float) -> Any:  # noqa: ANN401 - JSON
        """Send the unanswered command once more, under its old number: it is done once, however often it is asked.

        Raises:
            InputError: If every command was answered.
            RobotRefused: If the robot's side has forgotten this client, so that nobody knows what was done.
            RfCompassError: As for `ask`.
        """
        if self._unanswered is None:
            raise InputError("every command was answered: there is nothing to ask again")
        if self._forgotten:
            message = f"{self._name} has started anew or served others: it may have done {self.unanswered} or not"
            raise RobotRefused(message, command=self.unanswered, reason="forgotten", **self._peer)
        return self._answer(self._unanswered, wait_s)

    def reconnect(self) -> None:
        """Connect anew, as the same client as before; commands nothing.

        Raises:
            RobotLinkError: As for a first connection.
        """
        self.close()
        self.greeting = self._connected()
        self._forgotten |= not self.greeting.resumed

    def close(self) -> None:
        """Hang up; harmless if that was done before."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
        self._buffer.clear()

    @property
    def _name(self) -> str:
        return f"{self._peer['host']}:{self._peer['port']}"

    def _connected(self) -> Greeting:
        try:
            self._socket = socket.create_connection((self._peer["host"], self._peer["port"]), self._timeout_s)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except (OSError, OverflowError) as cause:  # a port beyond 65535 overflows
            raise RobotLost(f"{self._name} cannot be reached: {cause}", **self._peer) from cause
        hello = encode_frame({"id": 0, "command": "hello", "schema": SCHEMA, "session": self._session})
        try:
            return self._greeted(self._exchanged(_Sent(0, "hello", hello), self._timeout_s))
        except BaseException:
            self.close()
            raise

    def _greeted(self, reply: JsonObject) -> Greeting:
        if (schema := reply.get("schema") if isinstance(reply, dict) else None) != SCHEMA:
            message = f"{self._name} speaks {shown(schema)}, not {SCHEMA}"
            raise RobotSchemaError(message, schema=shown(schema), expected=SCHEMA, **self._peer)
        try:
            joints, capabilities = (tuple(map(str, item(reply, key))) for key in ("joints", "capabilities"))
            return Greeting(text(reply, "robot"), joints, capabilities, bool(item(reply, "resumed")))
        except (RobotFormatError, TypeError) as cause:
            raise RobotFrameError(f"{self._name} greets in a way that makes no sense: {cause}", **self._peer) from cause

    def _answer(self, sent: _Sent, wait_s: float) -> Any:  # noqa: ANN401 - JSON
        try:
            reply = self._exchanged(sent, wait_s)
        except RobotLost:
            raise
        except RfCompassError:
            self._unanswered = None
            raise
        self._unanswered = None
        return reply

    def _exchanged(self, sent: _Sent, wait_s: float) -> Any:  # noqa: ANN401 - JSON
        """Send a frame and take the reply; a fault closes the connection."""
        context = {"command": sent.command, "id": sent.number, **self._peer}
        try:
            frame = decode_frame(self._round_trip(sent, wait_s))
            nameless = frame.get("id") is None and "error" in frame  # it could not even read our number
            if not nameless and (got := frame_id(frame)) != sent.number:
                raise RobotFormatError(f"an answer to command {got} came, not to {sent.number}")
            reply = None if "error" in frame else item(frame, "reply")
        except RobotFormatError as cause:
            self.close()
            raise RobotFrameError(f"{self._name}: {cause.message}", **{**cause.numbers, **context}) from cause
        except OSError as cause:
            self.close()
            raise RobotLost(f"{self._name} was lost during {sent.command}: {cause}", **context) from cause
        except BaseException:  # Ctrl-C: the answer would be taken for that of the next command
            self.close()
            raise
        if "error" in frame:
            raise error_of(frame["error"], **self._peer, command=sent.command)
        return reply

    def _round_trip(self, sent: _Sent, wait_s: float) -> bytes:
        """Send a frame and receive one line.

        Raises:
            OSError: If the connection is gone or the time is over.
            RobotFormatError: If the line is too long.
        """
        if self._socket is None:
            raise ConnectionError("there is no connection, reconnect first")
        deadline_s = time.monotonic() + wait_s
        self._socket.settimeout(wait_s)
        with suppress(BrokenPipeError, ConnectionResetError):  # whoever hung up may have said why: read that first
            self._socket.sendall(sent.frame)
        searched = 0
        while (end := self._buffer.find(b"\n", searched)) < 0:
            searched = len(self._buffer)
            if searched > self._longest_bytes:
                raise RobotFormatError(f"an answer is longer than {self._longest_bytes} bytes", bytes=searched)
            self._receive(deadline_s - time.monotonic(), wait_s)
        line = bytes(self._buffer[:end])
        del self._buffer[: end + 1]
        return line

    def _receive(self, left_s: float, wait_s: float) -> None:
        if self._socket is None or left_s <= 0:
            raise TimeoutError(f"no answer within {wait_s} s")
        self._socket.settimeout(left_s)
        try:
            received = self._socket.recv(_RECEIVE_BYTES)
        except TimeoutError as cause:
            raise TimeoutError(f"no answer within {wait_s} s") from cause
        if not received:
            raise ConnectionError("the robot's side hung up")
        self._buffer += received
