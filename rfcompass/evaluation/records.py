"""The record of one trial: one row of a study's table."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from rfcompass.errors import RfCompassError

CellValue: TypeAlias = str | int | float | bool | None
MetricValue: TypeAlias = float | bool | str | Sequence[float] | None


@dataclass(frozen=True, slots=True)
class TrialFailure:
    """Why a trial has no metrics.

    Attributes:
        kind: Name of the exception, for example `"TagNeverHeard"`.
        message: Its sentence.
        numbers: Its evidence as a JSON object, `"{}"` for exceptions that are not ours.
    """

    kind: str
    message: str
    numbers: str = "{}"

    @classmethod
    def of(cls, error: Exception) -> "TrialFailure":
        """Record an exception; ours keep their numbers."""
        if isinstance(error, RfCompassError):
            return cls(error.kind, error.message, json.dumps(error.numbers, default=_plain, sort_keys=True))
        return cls(type(error).__name__, str(error))


@dataclass(frozen=True, slots=True)
class TrialRecord:
    """One trial: what was asked, what came out, and at what cost.

    Attributes:
        study: Name of the study.
        cell: Value of each factor.
        seed: Seed of the trial; trials of one seed share their random numbers over all cells.
        metrics: Value of each metric, None where it is not observable; empty if the trial failed.
        failure: Why there are no metrics, or None.
        runtime_s: Wall-clock time of the trial [s].
        versions: The software that computed it, one line.
    """

    study: str
    cell: Mapping[str, CellValue]
    seed: int
    metrics: Mapping[str, MetricValue]
    failure: TrialFailure | None = None
    runtime_s: float = 0.0
    versions: str = ""

    def __post_init__(self) -> None:
        """Freeze the mappings."""
        object.__setattr__(self, "cell", MappingProxyType(dict(self.cell)))
        object.__setattr__(self, "metrics", MappingProxyType(dict(self.metrics)))

    def __reduce__(self) -> tuple[object, ...]:
        """Rebuild through the constructor: a mapping proxy cannot be pickled."""
        metrics, cell = dict(self.metrics), dict(self.cell)
        return TrialRecord, (self.study, cell, self.seed, metrics, self.failure, self.runtime_s, self.versions)


def _plain(value: object) -> object:
    """Turn what JSON does not know, above all numpy's numbers and arrays, into what it does."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
