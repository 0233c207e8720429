"""Looks from several places at one stop, and which of them to believe.

A posterior can be sure of a wrong place: what an antenna hears along two tracks may be an echo. Looks from different
tracks seldom hear the same one, so that before the first drive a second look has to agree with the first.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planners.worth_driving import LOST_M
from rfcompass.types.observation import Observation
from rfcompass.types.record import Record

if TYPE_CHECKING:
    from planners.fetch import FetchStep

AGREE_M = 0.5  # ours: two looks that place the part no further apart mean the same place


@dataclass(frozen=True, slots=True)
class Look(Record):
    """One look, from one place of the antenna.

    Attributes:
        step: What it told.
        observations: The stops that it rests on.
    """

    step: "FetchStep"
    observations: tuple[Observation, ...]

    @property
    def is_sure(self) -> bool:
        """Whether it is worth a drive, as far as it knows."""
        return self.step.doubt_m <= LOST_M


def surest(looks: Sequence[Look]) -> Look:
    """The look with the least doubt, the newest of equals."""
    return min(reversed(looks), key=lambda look: look.step.doubt_m)


def confirmed(looks: Sequence[Look]) -> Look | None:
    """The surest of the newest look and the earlier ones that mean the same place; None if no two sure ones do.

    One alone is believed, and the others are its witnesses: all that is heard along a track of the antenna shares its
    errors, so that looks along several tracks contradict each other by more than a posterior of them all allows.

    Args:
        looks: All from one pose of the base, the newest last.
    """
    *earlier, newest = looks
    same = [look for look in earlier if look.is_sure and _apart_m(look, newest) <= AGREE_M]
    return surest([*same, newest]) if newest.is_sure and same else None


def _apart_m(one: Look, other: Look) -> float:
    return float(np.linalg.norm(one.step.estimate.centre_m - other.step.estimate.centre_m))
