"""The frames of `rfcompass-robot-link/1`: one JSON object on each line, see `docs/robot_link.md`.

Python writes a float so that reading it gives the same float, to the last bit; so do most JSON writers.
"""

import json
import reprlib
from collections.abc import Mapping
from typing import Any, TypeAlias

from rfcompass.errors import RobotFormatError

SCHEMA = "rfcompass-robot-link/1"

# A command is some hundred bytes. A scan of a dozen tags at 300 antenna positions on 50 carriers is 9 MB. Ours.
LONGEST_COMMAND_BYTES = 1 << 20
LONGEST_REPLY_BYTES = 1 << 26

# Commands that change nothing: answered under any number, and not remembered.
READ_ONLY = frozenset({"state"})

JsonObject: TypeAlias = dict[str, Any]


def encode_frame(content: Mapping[str, Any]) -> bytes:
    """Write one frame, newline included.

    Raises:
        RobotFormatError: If a value is no JSON, such as NaN.
    """
    try:
        return json.dumps(content, allow_nan=False, separators=(",", ":")).encode("ascii") + b"\n"
    except (TypeError, ValueError, RecursionError) as cause:
        raise RobotFormatError(f"a frame cannot be written: {cause}") from cause


def decode_frame(line: bytes) -> JsonObject:
    """Read one frame.

    Raises:
        RobotFormatError: If it is no JSON object in UTF-8, or nested beyond reason.
    """
    try:
        content = json.loads(line.decode("utf-8"), parse_constant=_reject_constant)
    except (ValueError, RecursionError) as cause:
        raise RobotFormatError(f"a frame is no JSON: {cause}", bytes=len(line)) from cause
    if not isinstance(content, dict):
        raise RobotFormatError(f"a frame holds a {type(content).__name__}, not an object", bytes=len(line))
    return content


def _reject_constant(name: str) -> float:
    raise ValueError(f"{name} is no JSON number")


def frame_id(frame: Mapping[str, Any]) -> int:
    """Number of the command that a frame is, or answers.

    Raises:
        RobotFormatError: If there is none.
    """
    number = frame.get("id")
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < 1 << 53:
        raise RobotFormatError(f"id: {shown(number)} is no integer from 0 to 2^53", key="id")
    return number


def shown(value: object) -> str:
    """A value for an error's message, cut short: what comes from outside may be long or nested deeply."""
    return reprlib.repr(value)
