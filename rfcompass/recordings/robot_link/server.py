"""A server that puts any robot behind `rfcompass-robot-link/1`: the reference for bridges to real ones."""

import asyncio
import hashlib
import socket
import threading
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from rfcompass.errors import RfCompassError, RobotBusy, RobotFormatError, RobotLinkError, RobotSchemaError
from rfcompass.recordings.robot_link.frames import LONGEST_COMMAND_BYTES, READ_ONLY, SCHEMA, shown
from rfcompass.recordings.robot_link.served_device import (
    Command,
    Device,
    ServedDevice,
    error_frame,
    read_command,
    reply_frame,
)
from rfcompass.recordings.robot_link.values import text

# Ours: how long a stranger may be silent, how many may wait to say hello, and how long one who was refused may go on
# talking before the line is cut.
HELLO_S = 5.0
MOST_CONNECTIONS = 8
LINGER_S = 5.0

_START_S = 10.0


@dataclass(slots=True)
class _Session:
    """The one client whose commands are obeyed, and the last thing that was done for it.

    Attributes:
        token: How the client calls itself.
        writer: Its newest connection; None if it is away.
        last_id: Number of its last command.
        last_digest: What that command said.
        last_reply: What was answered, or will be.
    """

    token: str
    writer: asyncio.StreamWriter | None = None
    last_id: int = 0
    last_digest: bytes = b""
    last_reply: "asyncio.Future[bytes] | None" = None

    @property
    def working(self) -> bool:
        """True while the robot does what this client wanted."""
        return self.last_reply is not None and not self.last_reply.done()


class RobotServer:
    """Serves a robot on a TCP port, to one client at a time, in a thread of its own.

    Commands are done one after the other, in one further thread, which is the only one that touches the robot. Of each
    command the server keeps number, digest and reply until the next one, so that a client that lost the reply can ask
    again. A client that comes back while its command is under way waits for it. Memory stays bounded: a command is at
    most 1 MiB, and one reply is kept.

    There is no authentication: whoever reaches the port moves the robot. Listen on the loopback address and let SSH
    carry the port.

    Args:
        device: The robot.
        name: Its name.
        joint_names: Its joints, in the order in which it takes and reports them.
        host: Address to listen on.
        port: TCP port; any free one if 0.
    """

    def __init__(
        self, device: Device, name: str, joint_names: Sequence[str], *, host: str = "127.0.0.1", port: int = 0
    ) -> None:
        self._served = ServedDevice(device, name, tuple(joint_names))
        self.host, self.port = host, port
        self._session: _Session | None = None
        self._tasks: set[asyncio.Task[None]] = set()
        self._pool: ThreadPoolExecutor | None = None
        self._thread: threading.Thread | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._quit: asyncio.Event | None = None

    def start(self) -> None:
        """Listen; `port` is known from now on.

        Raises:
            RobotLinkError: If the port cannot be had.
        """
        started: Future[None] = Future()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve(started)), daemon=True)
        self._thread.start()
        try:
            started.result(_START_S)
        except (OSError, OverflowError, TimeoutError) as cause:
            self._thread.join(_START_S)
            self._thread = None
            message = f"{self.host}:{self.port} cannot be listened on: {cause}"
            raise RobotLinkError(message, host=self.host, port=self.port) from cause

    def stop(self) -> None:
        """Hang up and stop listening, once the robot has ended what it does; harmless if it does not listen."""
        if self._thread is None or self._loop is None or self._quit is None:
            return
        self._loop.call_soon_threadsafe(self._quit.set)
        self._thread.join()
        self._thread = self._loop = self._session = None

    def __enter__(self) -> Self:
        """Listen."""
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop."""
        self.stop()

    async def _serve(self, started: "Future[None]") -> None:
        self._loop, self._quit = asyncio.get_running_loop(), asyncio.Event()
        try:
            server = await asyncio.start_server(self._attend, self.host, self.port, limit=LONGEST_COMMAND_BYTES)
        except (OSError, OverflowError) as error:
            started.set_exception(error)
            return
        self.port = server.sockets[0].getsockname()[1]
        with ThreadPoolExecutor(max_workers=1, thread_name_prefix="robot") as self._pool:
            started.set_result(None)
            await self._quit.wait()
            server.close()
            for task in self._tasks:
                task.cancel()
            await asyncio.gather(*self._tasks, return_exceptions=True)
            await asyncio.sleep(0)  # one turn, in which the connections are closed
            if self._session is not None and self._session.last_reply is not None:
                await self._session.last_reply

    async def _attend(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """One connection, from hello to the end."""
        task = asyncio.current_task()
        if task is None or len(self._tasks) >= MOST_CONNECTIONS:
            writer.close()
            return
        self._tasks.add(task)
        try:
            _notice_death(writer)
            if (session := await self._welcomed(reader, writer)) is not None:
                await self._obey(session, reader, writer)
        except asyncio.CancelledError:  # the server stops: a client that takes no bytes must not hold it up
            writer.transport.abort()
        except (OSError, asyncio.IncompleteReadError):
            pass  # the client is gone, or came back on another connection
        finally:
            self._tasks.discard(task)
            if self._session is not None and self._session.writer is writer:
                self._session.writer = None
            writer.close()

    async def _welcomed(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> _Session | None:
        """Answer the first frame; None if it is no hello of somebody who is welcome."""
        try:
            command = read_command(await asyncio.wait_for(_line(reader), HELLO_S))
            session, resumed = self._admitted(command)
        except TimeoutError:
            return None
        except RfCompassError as error:
            await _send(writer, error_frame(0, error))
            await _hang_up(reader, writer)
            return None
        if session.writer is not None:
            session.writer.transport.abort()
        session.writer = writer
        reply = {
            "schema": SCHEMA, "robot": self._served.name, "joints": list(self._served.joint_names),
            "capabilities": list(self._served.capabilities), "resumed": resumed,
        }  # fmt: skip
        await _send(writer, reply_frame(command.number, reply))
        return session

    def _admitted(self, command: Command) -> tuple[_Session, bool]:
        """The session of a hello, and whether it is an old one.

        Raises:
            RobotFormatError: If it is no hello.
            RobotSchemaError: If it is of another version.
            RobotBusy: If somebody else is here, or the robot still does what somebody else wanted.
        """
        if command.name != "hello":
            raise RobotFormatError(f"the first command is {shown(command.name)}, not hello", key="command")
        if (schema := command.content.get("schema")) != SCHEMA:
            raise RobotSchemaError(
                f"this robot speaks {SCHEMA}, not {shown(schema)}", schema=shown(schema), expected=SCHEMA
            )
        token, held = text(command.content, "session"), self._session
        if held is not None and held.token == token:
            return held, True
        if held is not None and held.writer is not None:
            raise RobotBusy(f"{self._served.name} has another client", reason="other_client")
        if held is not None and held.working:
            raise RobotBusy(f"{self._served.name} still does what an earlier client wanted", reason="working")
        self._session = _Session(token)
        return self._session, False

    async def _obey(self, session: _Session, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer command after command; a line that is too long cannot be skipped and ends it."""
        while True:
            try:
                line = await _line(reader)
            except RobotFormatError as error:
                await _send(writer, error_frame(None, error))
                if session.writer is writer:  # others need not wait until it has hung up
                    session.writer = None
                await _hang_up(reader, writer)
                return
            if session.writer is not writer:  # the client is back on another connection: what it left here is void
                return
            frame = await self._answered(session, line)
            if session.writer is writer:
                await _send(writer, frame)

    async def _answered(self, session: _Session, line: bytes) -> bytes:
        loop = asyncio.get_running_loop()
        try:
            command = read_command(line)
            if command.name in READ_ONLY:
                return await loop.run_in_executor(self._pool, self._served.answer, command)
            fresh = _is_fresh(session, command, digest := hashlib.sha256(line).digest())
        except RobotFormatError as error:
            number = error.numbers.get("id")
            return error_frame(number if isinstance(number, int) else None, error)
        if fresh:
            session.last_id, session.last_digest = command.number, digest
            session.last_reply = loop.run_in_executor(self._pool, self._served.answer, command)
        if session.last_reply is None:  # cannot be: a command that is not fresh has been answered
            raise RuntimeError("no reply is remembered")
        return await asyncio.shield(session.last_reply)


def _is_fresh(session: _Session, command: Command, digest: bytes) -> bool:
    """True if a command is new, False if it is the last one once more.

    Raises:
        RobotFormatError: If its number was used for something else, or is too old to be remembered.
    """
    if command.number > session.last_id:
        return True
    if command.number == session.last_id and digest == session.last_digest:
        return False
    message = f"id {command.number} is not beyond the last one, {session.last_id}, nor the same command again"
    raise RobotFormatError(message, id=command.number, last_id=session.last_id)


async def _line(reader: asyncio.StreamReader) -> bytes:
    """One line without its end.

    Raises:
        RobotFormatError: If it is too long.
        IncompleteReadError: If the client hung up.
    """
    try:
        return (await reader.readuntil(b"\n"))[:-1]
    except asyncio.LimitOverrunError as cause:
        message = f"a command is longer than {LONGEST_COMMAND_BYTES} bytes"
        raise RobotFormatError(message, limit_bytes=LONGEST_COMMAND_BYTES) from cause


async def _send(writer: asyncio.StreamWriter, frame: bytes) -> None:
    writer.write(frame)
    await writer.drain()


async def _hang_up(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """End a connection so that the client hears what was sent last.

    A socket that is closed with bytes unread resets the connection, and the client loses what it has not read yet. So
    what it still sends is read and thrown away, for a while.
    """
    writer.write_eof()
    with suppress(TimeoutError):
        async with asyncio.timeout(LINGER_S):
            while await reader.read(1 << 16):
                pass


def _notice_death(writer: asyncio.StreamWriter) -> None:
    """Let the system find out when a client's machine is gone, so that the robot is free again after half a minute."""
    if (client := writer.get_extra_info("socket")) is None:
        return
    with suppress(OSError):
        client.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in (("TCP_KEEPIDLE", 10), ("TCP_KEEPINTVL", 5), ("TCP_KEEPCNT", 4)):
            if hasattr(socket, name):
                client.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
