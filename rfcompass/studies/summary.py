"""From rows to the numbers of a report: one value with its interval for each cell, metric and summary."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.evaluation.statistics import Interval, bootstrap_interval, sample_statistic, wilson_interval
from rfcompass.studies.metric import SHARE, Metric
from rfcompass.studies.rows import failures_by_kind
from rfcompass.studies.study import Cell, PaperValue, Study


@dataclass(frozen=True, slots=True)
class SummaryRow:
    """One line of a report. Values are in the unit the metric is stored in.

    Attributes:
        cell: Value of each factor.
        metric: Name of the metric.
        summary: What is reported of it, for example `"median"`.
        trials: Trials of the cell, failed ones included.
        failures: Failed trials. They have no value; in a share of trials they count as "no".
        n: Values behind the summary; more than trials where a trial has many samples.
        value: Our value; None if there is nothing to summarise.
        interval: Its 95 % interval; None for fewer than two values.
        paper: Value to compare with, or None.
    """

    cell: Cell
    metric: str
    summary: str
    trials: int
    failures: int
    n: int
    value: float | None
    interval: Interval | None
    paper: PaperValue | None


@dataclass(frozen=True, slots=True)
class RunFacts:
    """What a report says about the rows as a whole.

    Attributes:
        trials: Number of rows.
        seeds: Number of different seeds.
        failures: Number of failed trials, by kind.
        versions: Every software that computed a row, one line each.
        runtime_s: Sum over all trials [s].
    """

    trials: int
    seeds: int
    failures: dict[str, int]
    versions: tuple[str, ...]
    runtime_s: float


@dataclass(frozen=True, slots=True)
class _Values:
    """Values of one metric in one cell, shape (n,), and the trial that each comes from, shape (n,)."""

    values: FloatArray
    trial: IntArray


def summarise(study: Study, table: pa.Table) -> tuple[SummaryRow, ...]:
    """Summarise the rows of a study, in the order of its cells and metrics.

    Intervals: Wilson's for a share of trials, the percentile bootstrap for all else. Samples of one trial stay
    together in the bootstrap; where there is one trial only, its samples are taken as independent. A share of
    samples gets the hull of both, since a bootstrap of "always" has no width. The result depends on the rows only.

    Args:
        study: The study.
        table: Its rows, as `read_rows` returns them; cells without any row are left out.
    """
    starts = np.searchsorted(table.column("cell").to_numpy(), np.arange(len(study.cells) + 1))
    return tuple(
        row
        for index, cell in enumerate(study.cells)
        if starts[index + 1] > starts[index]
        for row in _cell_rows(study, cell, table.slice(starts[index], starts[index + 1] - starts[index]))
    )


def run_facts(table: pa.Table) -> RunFacts:
    """Collect what is to be said about all rows of a run."""
    return RunFacts(
        trials=table.num_rows,
        seeds=len(pc.unique(table.column("seed"))),
        failures=failures_by_kind(table),
        versions=tuple(sorted(pc.unique(table.column("versions")).to_pylist())),
        runtime_s=float(pc.sum(table.column("runtime_s")).as_py()),
    )


def _cell_rows(study: Study, cell: Cell, table: pa.Table) -> Iterator[SummaryRow]:
    failed = pc.is_valid(table.column("failure_kind")).to_numpy()
    for metric in study.metrics:
        if not metric.summaries:
            continue
        values = _values(metric, table, failed)
        for summary in metric.summaries:
            yield SummaryRow(
                cell=cell,
                metric=metric.name,
                summary=summary,
                trials=table.num_rows,
                failures=int(failed.sum()),
                n=len(values.values),
                value=_value(values, summary),
                interval=_interval(metric, values, summary, _rng(study, cell, metric, summary)),
                paper=study.paper_value(cell, metric.name, summary),
            )


def _values(metric: Metric, table: pa.Table, failed: np.ndarray) -> _Values:
    column = table.column(metric.name)
    if metric.column == "samples":
        chunk = column.combine_chunks()
        return _Values(pc.list_flatten(chunk).to_numpy(), pc.list_parent_indices(chunk).to_numpy())
    numbers = column.cast(pa.float64()).to_numpy()
    if metric.column == "bool":
        numbers = np.where(failed, 0.0, numbers)
    seen = ~np.isnan(numbers)  # null, that is not observable
    return _Values(numbers[seen], np.flatnonzero(seen))


def _value(values: _Values, summary: str) -> float | None:
    if not len(values.values):
        return None
    return sample_statistic(values.values, "mean" if summary == SHARE else summary)


def _interval(metric: Metric, values: _Values, summary: str, rng: np.random.Generator) -> Interval | None:
    n = len(values.values)
    if n < 2:
        return None
    if metric.column == "bool":
        return wilson_interval(int(values.values.sum()), n)
    several = len(np.unique(values.trial)) > 1
    statistic = "mean" if summary == SHARE else summary
    bootstrap = bootstrap_interval(values.values, statistic, rng, clusters=values.trial if several else None)
    return bootstrap.hull(wilson_interval(round(values.values.sum()), n)) if summary == SHARE else bootstrap


def _rng(study: Study, cell: Cell, metric: Metric, summary: str) -> np.random.Generator:
    """Random numbers of one line, so that it does not depend on which other lines there are."""
    line = repr((study.name, sorted(cell.items()), metric.name, summary))
    return np.random.default_rng(int.from_bytes(hashlib.sha256(line.encode()).digest()[:16], "big"))
