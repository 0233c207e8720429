"""Poses, joints, states and outcomes as JSON, and back. Everything that comes from outside is checked here."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rfcompass.arrays import FloatArray, Shape
from rfcompass.errors import InputError, RobotFormatError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.recordings.robot_link.frames import JsonObject, shown
from rfcompass.types.grasps import Failure, GraspOutcome
from rfcompass.types.robot_state import RobotState


def item(content: object, key: str) -> Any:  # noqa: ANN401 - JSON
    """One value of an object.

    Raises:
        RobotFormatError: If `content` is no object, or lacks the key.
    """
    if not isinstance(content, Mapping):
        raise RobotFormatError(f"a {type(content).__name__} stands where an object with {key} is due", key=key)
    if key not in content:
        raise RobotFormatError(f"{key} is missing (found: {shown(list(content))})", key=key)
    return content[key]


def text(content: object, key: str) -> str:
    """One value that is text.

    Raises:
        RobotFormatError: If it is missing or something else.
    """
    if not isinstance(value := item(content, key), str):
        raise RobotFormatError(f"{key}: {shown(value)} is no text", key=key)
    return value


def number(value: object, key: str) -> float:
    """A finite number.

    Raises:
        RobotFormatError: If it is something else.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        raise RobotFormatError(f"{key}: {shown(value)} is no finite number", key=key)
    return float(value)


def integer(value: object, key: str) -> int:
    """An integer of 64 bits.

    Raises:
        RobotFormatError: If it is something else.
    """
    if isinstance(value, bool) or not isinstance(value, int) or not -(1 << 63) <= value < 1 << 63:
        raise RobotFormatError(f"{key}: {shown(value)} is no integer of 64 bits", key=key)
    return value


def numbers(value: object, key: str, shape: Shape) -> FloatArray:
    """Nested lists of finite numbers as an array.

    Args:
        value: The lists.
        key: What to call them in an error.
        shape: Expected shape; `None` leaves an axis free.

    Raises:
        RobotFormatError: If they are ragged, or hold anything but numbers.
    """
    return np.asarray(_array(value, key, shape, "if"), dtype=np.float64)


def _array(value: object, key: str, shape: Shape, kinds: str) -> Any:  # noqa: ANN401 - integers or floats
    try:
        array = np.asarray(value)
    except (ValueError, OverflowError) as cause:
        raise RobotFormatError(f"{key}: the lists are ragged", key=key) from cause
    if not array.size:  # an empty list tells neither the type of what it lacks nor the other axes
        array = np.zeros([have or 0 for have in shape])
    if array.ndim != len(shape) or any(want not in (None, have) for want, have in zip(shape, array.shape, strict=True)):
        raise RobotFormatError(f"{key}: the shape is {array.shape}, not {shape}", key=key)
    if array.size and (array.dtype.kind not in kinds or not np.isfinite(array).all()):
        raise RobotFormatError(f"{key}: holds something that is no finite number, or no integer", key=key)
    return array


def integers(value: object, key: str, shape: Shape) -> Any:  # noqa: ANN401 - an array of integers
    """Nested lists of integers as an array; otherwise like `numbers`."""
    return _array(value, key, shape, "i").astype(np.int64)


def pose_json(pose: Pose2) -> list[float]:
    """Write a pose as [x_m, y_m, theta_rad]."""
    return [pose.x_m, pose.y_m, pose.theta_rad]


def pose_of(value: object, key: str) -> Pose2:
    """Read [x_m, y_m, theta_rad].

    Raises:
        RobotFormatError: If it is not that.
    """
    return Pose2(*numbers(value, key, (3,)).tolist())


def joints_json(joints: FloatArray, names: Sequence[str]) -> dict[str, float]:
    """Write joint values under their names."""
    return dict(zip(names, np.asarray(joints, dtype=np.float64).tolist(), strict=True))


def joints_of(value: object, names: Sequence[str]) -> FloatArray:
    """Read the values of all joints, in the order of `names`, shape (Q,).

    Raises:
        RobotFormatError: If a joint is missing or unknown, or a value is no finite number.
    """
    given = value if isinstance(value, Mapping) else {}
    if missing := [name for name in names if name not in given]:
        raise RobotFormatError(f"joints: {', '.join(missing)} missing", key="joints", missing=missing)
    if unknown := sorted(set(given) - set(names)):
        raise RobotFormatError(f"joints: {', '.join(unknown)} unknown", key="joints", unknown=unknown)
    return np.array([number(given[name], f"joints.{name}") for name in names])


def state_json(state: RobotState, names: Sequence[str]) -> JsonObject:
    """Write what a robot believes about itself."""
    return {
        "base": pose_json(state.base),
        "base_covariance": state.base_covariance.tolist(),
        "joints": joints_json(state.joints, names),
    }


def state_of(content: object, names: Sequence[str]) -> RobotState:
    """Read what a robot believes about itself; its joints come in the order of `names`.

    Raises:
        RobotFormatError: If something is missing, or is not possible.
    """
    joints = joints_of(item(content, "joints"), names)
    covariance = numbers(item(content, "base_covariance"), "base_covariance", (3, 3))
    try:
        return RobotState(joints, pose_of(item(content, "base"), "base"), covariance)
    except RobotFormatError:
        raise
    except InputError as cause:
        raise RobotFormatError(cause.message, key="state") from cause


def outcome_json(outcome: GraspOutcome) -> JsonObject:
    """Write what came of closing the hand."""
    failure = outcome.failure
    told = None if failure is None else {"kind": failure.kind, "message": failure.message, "numbers": failure.numbers}
    return {"success": outcome.success, "failure": told}


def outcome_of(content: object) -> GraspOutcome:
    """Read what came of closing the hand.

    Raises:
        RobotFormatError: If something is missing or of the wrong kind.
    """
    success, told = item(content, "success"), item(content, "failure")
    if not isinstance(success, bool):
        raise RobotFormatError(f"success: {shown(success)} is neither true nor false", key="success")
    if told is None:
        return GraspOutcome(success)
    return GraspOutcome(success, Failure(text(told, "kind"), text(told, "message"), _evidence(told.get("numbers", []))))


def _evidence(pairs: object) -> tuple[tuple[str, float | str], ...]:
    if not isinstance(pairs, list) or not all(isinstance(pair, list) and len(pair) == 2 for pair in pairs):
        raise RobotFormatError("numbers: no list of pairs", key="numbers")
    return tuple(
        (str(name), value if isinstance(value, str) else number(value, f"numbers.{name}")) for name, value in pairs
    )
