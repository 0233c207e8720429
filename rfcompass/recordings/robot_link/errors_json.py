"""An error as JSON, and back: what a robot refuses in our own words comes out of the socket as the same error."""

from collections.abc import Mapping

from rfcompass import errors
from rfcompass.arrays import plain
from rfcompass.errors import RfCompassError, RobotLost, RobotRefused
from rfcompass.recordings.robot_link.frames import JsonObject


def error_json(error: RfCompassError) -> JsonObject:
    """Write kind, message and numbers."""
    return {"kind": error.kind, "message": error.message, "numbers": plain(error.numbers)}


def error_of(content: object, **context: object) -> RfCompassError:
    """Read an error; a kind that we do not have is a `RobotRefused` with that kind as its `reason`.

    Args:
        content: The object `error` of a reply.
        **context: Evidence to add: `host`, `port`, `command`.
    """
    told = content if isinstance(content, Mapping) else {}
    kind, message = str(told.get("kind", "unknown")), str(told.get("message", content))
    numbers = told.get("numbers")
    numbers = numbers if isinstance(numbers, Mapping) else {}
    evidence = {str(key): value for key, value in numbers.items() if key not in ("self", "message")}
    cls = getattr(errors, kind, None)
    if isinstance(cls, type) and issubclass(cls, RfCompassError) and not issubclass(cls, RobotLost):
        return cls(message, **{**evidence, **context})
    return RobotRefused(message, **{**evidence, **context, "reason": kind})
