"""What a study declares: factors, seeds, one trial, its metrics and the values it is compared with."""

import hashlib
import itertools
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from rfcompass.errors import StudyError
from rfcompass.evaluation.records import CellValue, MetricValue
from rfcompass.studies.metric import Metric

if TYPE_CHECKING:  # a trial needs neither
    import pyarrow as pa
    from matplotlib.figure import Figure

Cell: TypeAlias = Mapping[str, CellValue]
Trial: TypeAlias = Callable[[Cell, int, np.random.Generator], Mapping[str, MetricValue]]
Applies: TypeAlias = Callable[[Cell, int], bool]
Draws: TypeAlias = Callable[["pa.Table"], Mapping[str, "Figure"]]

RESERVED_COLUMNS = (
    "study",
    "cell",
    "seed",
    "failure_kind",
    "failure_message",
    "failure_numbers",
    "runtime_s",
    "versions",
)


@dataclass(frozen=True, slots=True)
class PaperValue:
    """A value to stand beside ours.

    Attributes:
        metric: Name of the metric.
        summary: Which summary of it, for example `"median"`.
        value: The printed value, in the unit the metric is stored in.
        source: Where it is printed, for example `"[Wang2013] Fig. 10"`.
        differs: What differs from our setting, in one sentence; empty if nothing does.
        cell: Values of some factors; the value belongs to every cell that has them.
    """

    metric: str
    summary: str
    value: float
    source: str
    differs: str = ""
    cell: Cell = field(default_factory=dict)

    def belongs_to(self, cell: Cell) -> bool:
        """Tell whether the value is to be shown for this cell."""
        return all(cell.get(name) == value for name, value in self.cell.items())


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """A grid of settings, each tried with the same seeds.

    One trial is one cell of the grid (a value for each factor) with one seed, and one row of the table.

    Attributes:
        name: Short name for the command line; also where all random numbers start from.
        title: Title of the report.
        kind: Whether the numbers come from simulated or from measured reads.
        factors: Values of each factor; the grid is their product.
        seeds: Seeds of the report, for example `range(100)`; each is tried in every cell.
        trial: Function of the module it stands in: (cell, seed, rng) → value of each metric.
        metrics: What the trial returns.
        paper: Values to compare with.
        tuning_seeds: Seeds on which constants may be chosen; never those of the report.
        applies: Says which trials exist where the grid is not full, for example for sets of unequal size.
        note: What the report says about model and constants.
        draws: Makes the figures of the report from all rows, by caption.

    Raises:
        StudyError: If the declaration contradicts itself.
    """

    name: str
    title: str
    kind: Literal["simulated", "measured"]
    factors: Mapping[str, tuple[CellValue, ...]]
    seeds: Sequence[int]
    trial: Trial
    metrics: tuple[Metric, ...]
    paper: tuple[PaperValue, ...] = ()
    tuning_seeds: Sequence[int] = ()
    applies: Applies | None = None
    note: str = ""
    draws: Draws | None = None

    def __post_init__(self) -> None:
        """Freeze the factors and check that names, values and seeds are consistent."""
        factors = MappingProxyType({name: tuple(values) for name, values in self.factors.items()})
        object.__setattr__(self, "factors", factors)
        self._check_names()
        for name, values in factors.items():
            _check_factor(name, values)
        self._check_seeds(self.seeds)
        self._check_paper()

    @property
    def cells(self) -> tuple[dict[str, CellValue], ...]:
        """All cells of the grid; the last factor varies fastest."""
        return tuple(
            dict(zip(self.factors, values, strict=True)) for values in itertools.product(*self.factors.values())
        )

    def metric(self, name: str) -> Metric:
        """Return a metric by its name."""
        return next(metric for metric in self.metrics if metric.name == name)

    def paper_value(self, cell: Cell, metric: str, summary: str) -> PaperValue | None:
        """Return what is to stand beside our value, or None.

        Raises:
            StudyError: If two values claim the same place.
        """
        found = [v for v in self.paper if (v.metric, v.summary) == (metric, summary) and v.belongs_to(cell)]
        if len(found) > 1:
            raise StudyError(f"study {self.name}: {len(found)} paper values for {metric}, {summary} in {dict(cell)}")
        return found[0] if found else None

    def first_seeds(self, trials: int | None = None) -> Sequence[int]:
        """Return the first `trials` seeds, all if None; a `range` goes on beyond its end.

        Raises:
            StudyError: If there are not as many seeds, or if they run into the tuning seeds.
        """
        if trials is None:
            return self.seeds
        if trials < 1:
            raise StudyError(f"{trials} trials for each cell: at least 1", trials=trials)
        seeds = self.seeds
        if isinstance(seeds, range):
            seeds = range(seeds.start, seeds.start + trials * seeds.step, seeds.step)
        if len(seeds) < trials:
            raise StudyError(f"study {self.name} has {len(seeds)} seeds, not {trials}", trials=trials, seeds=len(seeds))
        self._check_seeds(seeds)
        return seeds[:trials]

    def on_tuning_seeds(self) -> "Study":
        """Return the same study on its tuning seeds, under a name of its own.

        Raises:
            StudyError: If it declares none.
        """
        return replace(self, name=f"{self.name}-tuning", seeds=self.tuning_seeds, tuning_seeds=())

    def _check_names(self) -> None:
        if not re.fullmatch(r"[a-z][a-z0-9-]*", self.name):
            raise StudyError(f"study name {self.name!r}: lower-case letters, digits and hyphens", name=self.name)
        columns = [*RESERVED_COLUMNS, *self.factors, *(metric.name for metric in self.metrics)]
        for column in columns:
            if not re.fullmatch(r"[a-z][a-zA-Z0-9_]*", column) or columns.count(column) > 1:
                raise StudyError(f"study {self.name}: column {column!r} is ill-named or stands twice", column=column)

    def _check_seeds(self, seeds: Sequence[int]) -> None:
        if not seeds or min(seeds) < 0 or (not isinstance(seeds, range) and len(set(seeds)) < len(seeds)):
            raise StudyError(f"study {self.name}: seeds must be different numbers from 0 up, at least one")
        shared = [seed for seed in self.tuning_seeds if seed in seeds]
        if shared:
            raise StudyError(f"study {self.name}: seed {shared[0]} is for tuning and report at once", seeds=shared)

    def _check_paper(self) -> None:
        summaries = {(metric.name, summary) for metric in self.metrics for summary in metric.summaries}
        for value in self.paper:
            if (value.metric, value.summary) not in summaries:
                raise StudyError(f"study {self.name}: paper value for {value.metric}, {value.summary}, not reported")
            if not any(value.belongs_to(cell) for cell in self.cells):
                raise StudyError(f"study {self.name}: paper value for {dict(value.cell)}, which is no cell")
        for cell, (metric, summary) in itertools.product(self.cells, summaries):
            self.paper_value(cell, metric, summary)


def trial_rng(study: str, seed: int) -> np.random.Generator:
    """Return the random numbers of a seed: the same in every cell, in every process and on every machine.

    Common random numbers make two methods meet the same difficulty, so that their difference is sharper.
    """
    start = int.from_bytes(hashlib.sha256(study.encode()).digest()[:16], "big")
    return np.random.default_rng(np.random.SeedSequence((start, seed)))


def _check_factor(name: str, values: tuple[CellValue, ...]) -> None:
    types = {float if type(value) is int else type(value) for value in values if value is not None}
    if len(types) != 1 or not types <= {str, bool, float}:
        raise StudyError(f"factor {name!r}: needs values of one type, text, number or truth value", factor=name)
    if len(set(values)) < len(values):
        raise StudyError(f"factor {name!r}: a value stands twice in {values}", factor=name)
