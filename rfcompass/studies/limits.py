"""How long a trial may take and how much memory, and the failures of those that want more."""

import json
import math
from dataclasses import dataclass

from rfcompass.errors import StudyError
from rfcompass.evaluation.records import TrialFailure

TIMED_OUT = "timed_out"
OUT_OF_MEMORY = "out_of_memory"


@dataclass(frozen=True, slots=True)
class TrialLimits:
    """Limits of each trial.

    Attributes:
        seconds: Wall-clock time [s]; None for any.
        megabytes: Memory beyond what the trial's process held before [10⁶ bytes]; None for any.

    Raises:
        StudyError: If a limit is not a positive number.
    """

    seconds: float | None = None
    megabytes: float | None = None

    def __post_init__(self) -> None:
        """Check that both can be met."""
        for name in ("seconds", "megabytes"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise StudyError(f"a limit of {value} {name} for a trial: must be positive", **{name: value})

    def __bool__(self) -> bool:
        """Tell whether anything is limited."""
        return self.seconds is not None or self.megabytes is not None

    @property
    def bytes(self) -> int | None:
        """The limit of memory in bytes."""
        return None if self.megabytes is None else round(self.megabytes * 1e6)

    def timed_out(self) -> TrialFailure:
        """Failure of a trial that took too long."""
        return TrialFailure(
            TIMED_OUT, f"stopped after {self.seconds:g} s", json.dumps({"seconds": self.seconds})
        )  # fmt: skip

    def out_of_memory(self) -> TrialFailure:
        """Failure of a trial that took too much memory."""
        return TrialFailure(
            OUT_OF_MEMORY, f"took more than {self.megabytes:g} MB", json.dumps({"megabytes": self.megabytes})
        )


NO_LIMITS = TrialLimits()
