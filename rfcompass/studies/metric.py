"""One thing that a trial measures: how it is stored, summarised and shown."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from rfcompass.errors import StudyError
from rfcompass.evaluation.records import MetricValue
from rfcompass.evaluation.statistics import quantile_of

Column: TypeAlias = Literal["float", "bool", "text", "samples"]

# A share is the part of trials (or of samples 0 and 1) that is true.
SHARE = "share"


@dataclass(frozen=True, slots=True)
class Metric:
    """A column of the table and its lines in the report.

    Attributes:
        name: Column name, with the unit as suffix, for example `error_m`.
        summaries: What the report shows: `"median"`, `"mean"`, `"sd"`, `"p90"`, `"max10"`, `"share"`; none for a
            column that is only kept.
        column: `float`, `bool` or `text`: one value for each trial. `samples`: any number of values for each trial,
            pooled in the report, with intervals that keep the samples of a trial together.
        title: Heading in the report; the name if empty.
        unit: Unit in the report.
        scale: Factor from the stored value to the shown one, for example 100 for m → cm.
        digits: Digits after the point in the report.

    Raises:
        StudyError: If column and summaries do not fit.
    """

    name: str
    summaries: tuple[str, ...] = ()
    column: Column = "float"
    title: str = ""
    unit: str = ""
    scale: float = 1.0
    digits: int = 1

    def __post_init__(self) -> None:
        """Check that the summaries exist for this kind of column."""
        allowed = {"float": "statistics", "bool": SHARE, "text": "", "samples": f"statistics {SHARE}"}[self.column]
        for summary in self.summaries:
            if summary != SHARE:
                quantile_of(summary)
            if ("statistics" if summary != SHARE else SHARE) not in allowed.split():
                raise StudyError(f"metric {self.name}: {summary!r} of a {self.column} column", metric=self.name)

    def stored(self, value: MetricValue) -> MetricValue:
        """Check what a trial returned and bring it to the type of the column; None stays None.

        Raises:
            StudyError: If it is of another type, or not finite: what is not observable is None, never NaN.
        """
        if value is None:
            return None
        try:
            return self._cast(value)
        except (TypeError, ValueError) as error:
            raise StudyError(
                f"metric {self.name}: {value!r} is no {self.column} value ({error})", metric=self.name
            ) from error

    def shown(self, value: float | None) -> str:
        """Format a stored value for the report."""
        return "–" if value is None else f"{value * self.scale:.{self.digits}f}"

    def _cast(self, value: object) -> MetricValue:
        if self.column == "samples" and isinstance(value, Iterable) and not isinstance(value, str):
            samples = tuple(_finite(sample) for sample in value)
            if SHARE in self.summaries and not set(samples) <= {0.0, 1.0}:
                raise ValueError("a share needs samples 0 and 1")
            return samples
        if self.column == "bool" and isinstance(value, bool | np.bool_):
            return bool(value)
        if self.column == "text" and isinstance(value, str):
            return str(value)
        if self.column == "float":
            return _finite(value)
        raise TypeError(f"{type(value).__name__} is not {self.column}")


def _finite(value: object) -> float:
    number = float(value)  # type: ignore[arg-type]  # float's own TypeError is the check
    if isinstance(value, str) or not math.isfinite(number):
        raise ValueError(f"{value!r} is no finite number")
    return number
