"""What is wrong with a robot's URDF."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from rfcompass.errors import RobotModelError
from rfcompass.types.record import Record

_Value = TypeVar("_Value")


@dataclass(frozen=True, slots=True)
class Defect(Record):
    """One thing that is wrong.

    Attributes:
        kind: Machine-readable, for example `"missing_mesh"`.
        where: Link, joint or file that it concerns.
        message: One sentence for a human.
        severity: `"error"`: the robot cannot be used as it is; `"warning"`: it can, but probably not as meant.
    """

    kind: str
    where: str
    message: str
    severity: str = "error"


def try_read(read: Callable[[], _Value], where: str, defects: list[Defect]) -> _Value | None:
    """Read something of a URDF; what is no number becomes a defect, and None is returned."""
    try:
        return read()
    except RobotModelError as error:
        defects.append(Defect("not_a_number", where, error.message))
        return None
