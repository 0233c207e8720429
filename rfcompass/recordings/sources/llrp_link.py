"""One LLRP connection: frames in, frames out. The bytes are llrpkit's business, the socket is ours.

A plain socket, read in the caller's thread: while the caller is busy, unread bytes wait in the system's buffers and
TCP slows the reader down, so that memory stays bounded and nothing is dropped on our side.
"""

import socket
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress

from llrpkit.constants import MESSAGE_HEADER_LEN
from llrpkit.exceptions import LLRPError
from llrpkit.protocol import LLRPMessage, decode_message, enums, messages

from rfcompass.errors import LinkLost, MalformedFrame, ReaderRefused

# Reports are some hundred bytes and capabilities some thousand; a longer frame is a broken length field (ours).
LONGEST_FRAME_BYTES = 1 << 20

_RECEIVE_BYTES = 1 << 16


class LlrpLink:
    """A connection on which the reader has greeted us.

    Args:
        host: Name or address of the reader.
        port: TCP port.
        timeout_s: How long connecting, the greeting and each answer may take [s].

    Raises:
        LinkLost: If there is no connection, or nobody on it speaks LLRP, or the reader is busy with another client.
    """

    def __init__(self, host: str, port: int, timeout_s: float) -> None:
        self._peer = {"host": host, "port": port}
        self._timeout_s = timeout_s
        self._next_id = 0
        self._buffer = bytearray()
        self._arrived: deque[LLRPMessage] = deque()
        self._fault: LinkLost | None = None
        try:
            self._socket = socket.create_connection((host, port), timeout=timeout_s)
        except OSError as cause:
            raise LinkLost(f"{host}:{port} cannot be reached: {cause}", **self._peer) from cause
        self._heard_s = self._emptied_s = time.monotonic()
        try:
            self._await_greeting()
        except BaseException:
            self.close()
            raise

    @property
    def silent_s(self) -> float:
        """Time since the last byte from the reader [s]."""
        return time.monotonic() - self._heard_s

    @property
    def unread_s(self) -> float:
        """Time since nothing was waiting: how old what `receive` takes next may be [s]."""
        return time.monotonic() - self._emptied_s

    def receive(self, wait_s: float) -> Sequence[LLRPMessage]:
        """Take everything that has arrived; keep-alives are answered on the way.

        Args:
            wait_s: How long to wait if nothing has [s]; with 0, what has arrived is taken all the same.

        Returns:
            Messages in the order of their arrival, none if the time passed without any.

        Raises:
            LinkLost: If the connection is gone and all that came before has been taken.
            MalformedFrame: If what comes next is no LLRP.
        """
        if not self._arrived and self._fault is None:
            self._fill(wait_s)
        if not self._arrived and self._fault is not None:
            raise self._fault
        taken = tuple(self._arrived)
        self._arrived.clear()
        return taken

    def request(self, message: LLRPMessage) -> LLRPMessage:
        """Send a message and return the reader's answer; what arrives meanwhile is left for `receive`.

        Raises:
            LinkLost: If no answer comes in time.
            ReaderRefused: If the reader answers with an error; carries `status` and `request`.
        """
        self._next_id += 1
        self.send(message, self._next_id)
        answer = self._first(lambda arrived: arrived.message_id == self._next_id and not _is_unasked(arrived))
        if answer is not None:
            return self._accepted(answer, message)
        name = type(message).__name__
        raise LinkLost(f"{self._name()} did not answer {name} within {self._timeout_s} s", request=name, **self._peer)

    def send(self, message: LLRPMessage, message_id: int = 0) -> None:
        """Send a message without waiting for an answer.

        Raises:
            LinkLost: If it cannot be sent.
        """
        try:
            self._socket.settimeout(self._timeout_s)
            self._socket.sendall(message.to_bytes(message_id=message_id))
        except OSError as cause:
            raise LinkLost(f"{self._name()} was lost: {cause}", **self._peer) from cause

    def close(self) -> None:
        """Close the socket; harmless if it is closed already."""
        self._socket.close()

    def _name(self) -> str:
        return f"{self._peer['host']}:{self._peer['port']}"

    def _first(self, wanted: Callable[[LLRPMessage], bool]) -> LLRPMessage | None:
        """The first message that is wanted, None if it does not come in time; the others are left for `receive`."""
        deadline_s, aside, found = time.monotonic() + self._timeout_s, deque[LLRPMessage](), list[LLRPMessage]()
        try:
            while not found and (left_s := deadline_s - time.monotonic()) > 0:
                for message in self.receive(left_s):
                    (found if not found and wanted(message) else aside).append(message)
        finally:
            self._arrived.extendleft(reversed(aside))
        return found[0] if found else None

    def _await_greeting(self) -> None:
        greeting = self._first(lambda message: _attempt_status(message) is not None)
        if greeting is None:
            raise LinkLost(f"{self._name()} sent no LLRP greeting within {self._timeout_s} s", **self._peer)
        status = _attempt_status(greeting)
        if status != enums.ConnectionAttemptStatusType.Success:
            message = f"{self._name()} turned the connection down (status {status}): it may have another client"
            raise LinkLost(message, status=status, **self._peer)

    def _accepted(self, answer: LLRPMessage, message: LLRPMessage) -> LLRPMessage:
        status = getattr(answer, "llrp_status", None)
        if status is None or int(status.status_code) == enums.StatusCode.M_Success:
            return answer
        code, name = int(status.status_code), type(message).__name__
        text = f"{self._name()} refused {name}: status {code} {status.error_description}".rstrip()
        raise ReaderRefused(text, status=code, request=name, **self._peer)

    def _fill(self, wait_s: float) -> None:
        """Receive once, or until one whole frame is there; remember a fault for after the good frames."""
        deadline_s, left_s = time.monotonic() + wait_s, wait_s
        while not self._arrived and self._fault is None and left_s >= 0.0:
            try:
                self._socket.settimeout(left_s)
                received = self._socket.recv(_RECEIVE_BYTES)
            except (TimeoutError, BlockingIOError):  # nothing came, or nothing was there and we were not to wait
                self._emptied_s = time.monotonic()
                return
            except OSError as cause:
                self._fault = LinkLost(f"{self._name()} was lost: {cause}", **self._peer)
                return
            self._accept(received)
            left_s = deadline_s - time.monotonic()

    def _accept(self, received: bytes) -> None:
        if not received:
            self._fault = LinkLost(f"{self._name()} closed the connection", **self._peer)
            return
        self._heard_s = time.monotonic()
        if len(received) < _RECEIVE_BYTES:
            self._emptied_s = self._heard_s
        self._buffer += received
        try:
            self._split()
        except LinkLost as fault:
            self._fault = fault

    def _split(self) -> None:
        """Cut whole frames off the buffer."""
        start = 0
        try:
            while len(self._buffer) - start >= MESSAGE_HEADER_LEN:
                length = int.from_bytes(self._buffer[start + 2 : start + 6], "big")
                if not MESSAGE_HEADER_LEN <= length <= LONGEST_FRAME_BYTES:
                    raise MalformedFrame(f"{self._name()} sent a frame of {length} bytes", bytes=length, **self._peer)
                if len(self._buffer) - start < length:
                    break
                self._take(bytes(self._buffer[start : start + length]))
                start += length
        finally:
            del self._buffer[:start]

    def _take(self, frame: bytes) -> None:
        message = self._decoded(frame)
        if isinstance(message, messages.KEEPALIVE):
            # A reader that has hung up takes no answer, yet what it said before is still to be read.
            with suppress(LinkLost):
                self.send(messages.KEEPALIVE_ACK(), message.message_id)
        else:
            self._arrived.append(message)

    def _decoded(self, frame: bytes) -> LLRPMessage:
        # Whatever a decoder raises on bytes from a network means the same: these bytes are no LLRP.
        try:
            return decode_message(frame)
        except (LLRPError, ArithmeticError, LookupError, TypeError, ValueError, RecursionError) as cause:
            kind = int.from_bytes(frame[:2], "big") & 0x3FF
            message = f"{self._name()} sent a frame of type {kind} that cannot be decoded: {cause}"
            raise MalformedFrame(message, bytes=len(frame), type=kind, **self._peer) from cause


def _is_unasked(message: LLRPMessage) -> bool:
    return isinstance(message, messages.RO_ACCESS_REPORT | messages.READER_EVENT_NOTIFICATION)


def _attempt_status(message: LLRPMessage) -> int | None:
    """Status of the reader's greeting; None if the message is something else."""
    if not isinstance(message, messages.READER_EVENT_NOTIFICATION):
        return None
    event = message.reader_event_notification_data.connection_attempt_event
    return None if event is None else int(event.status)
