"""Stops that a robot could make next."""

from dataclasses import dataclass

import numpy as np

from rfcompass.errors import InputError
from rfcompass.types.configuration import Configuration
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class ProposedStop(Record):
    """A stop that is reachable and free of collision, as far as the proposer can tell.

    Attributes:
        configuration: Where the robot would stand, in the frame of the configuration that it was asked from.
        seconds: Time to get there [s].
    """

    configuration: Configuration
    seconds: float

    def __post_init__(self) -> None:
        """Refuse times that cannot be."""
        if not (np.isfinite(self.seconds) and self.seconds >= 0):
            raise InputError(f"ProposedStop.seconds: {self.seconds} is not a finite number >= 0", name="seconds")
