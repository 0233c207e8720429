"""One trial, as a worker runs it. Imports stay light: a worker pays for nothing that its trials do not use."""

import time
from collections.abc import Mapping

from rfcompass.errors import StudyError
from rfcompass.evaluation.records import MetricValue, TrialFailure, TrialRecord
from rfcompass.studies.limits import OUT_OF_MEMORY
from rfcompass.studies.metric import Metric
from rfcompass.studies.study import Cell, Trial, trial_rng
from rfcompass.studies.versions import software_versions


def run_trial(study: str, trial: Trial, metrics: tuple[Metric, ...], cell: Cell, seed: int) -> TrialRecord:
    """Run one trial and record what came of it; an exception becomes a failure, whatever its kind.

    The arguments are the parts of a study that a worker needs, so that little travels to it.

    Args:
        study: Name of the study.
        trial: Its trial function.
        metrics: What the function must return.
        cell: Value of each factor.
        seed: Seed of the trial.
    """
    failure, values = None, {}
    start = time.perf_counter()
    try:
        values = _checked(metrics, trial(dict(cell), seed, trial_rng(study, seed)))
    except MemoryError as error:  # libraries have kinds of their own
        failure = TrialFailure(OUT_OF_MEMORY, str(error))
    except Exception as error:  # the study goes on
        failure = TrialFailure.of(error)
    runtime_s = time.perf_counter() - start
    return TrialRecord(study, cell, seed, values, failure, runtime_s, software_versions())


def _checked(metrics: tuple[Metric, ...], values: Mapping[str, MetricValue]) -> dict[str, MetricValue]:
    names = {metric.name for metric in metrics}
    if set(values) != names:
        missing, unknown = sorted(names - set(values)), sorted(set(values) - names)
        raise StudyError(f"trial returned no {missing} and undeclared {unknown}", missing=missing, unknown=unknown)
    return {metric.name: metric.stored(values[metric.name]) for metric in metrics}
