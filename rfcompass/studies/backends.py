"""Where trials run: joblib's backends, on this machine or on a cluster."""

import itertools
import sys
import warnings
from collections.abc import Callable, Generator, Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from importlib import import_module
from typing import Any, TypeAlias

import joblib

from rfcompass.errors import StudyError

# As `joblib.delayed` makes it.
Call: TypeAlias = tuple[Callable[..., Any], tuple[Any, ...], dict[str, Any]]

# Backends whose workers are other processes; trials of the others run in this one, unless they are limited.
PROCESS_BACKENDS = ("loky", "dask", "ray")
KNOWN = ("loky", "dask", "ray", "threading", "sequential")
_WITH_SCHEDULER = ("dask", "ray")

_LISTS_ONLY = ("ray",)
_ROUND = 16  # calls for each worker in a round

_IDLE_S = 60  # a worker without work ends after this time


def parallel_backend(backend: str, workers: int, scheduler: str | None = None) -> AbstractContextManager[object]:
    """Let joblib use a backend and a number of workers, for the length of a `with` block.

    Args:
        backend: One of `KNOWN`.
        workers: Number of workers; a cluster with a `scheduler` has as many as it has.
        scheduler: Address of a cluster; `dask` and `ray` start one on this machine if None.

    Raises:
        StudyError: If there is no such backend, not even one worker, or no cluster at that address.
        MissingExtra: If the cluster's software is not installed.
    """
    if backend not in KNOWN:
        raise StudyError(f"no backend {backend!r}; known: {', '.join(KNOWN)}", backend=backend)
    if workers < 1:
        raise StudyError(f"{workers} workers: at least 1", workers=workers)
    if scheduler is not None and backend not in _WITH_SCHEDULER:
        raise StudyError(f"backend {backend} has no scheduler; dask and ray have", backend=backend, scheduler=scheduler)
    if backend == "loky":
        return joblib.parallel_config("loky", n_jobs=workers, idle_worker_timeout=_IDLE_S)
    if backend in _WITH_SCHEDULER:
        return _cluster(backend, workers, scheduler)
    return joblib.parallel_config(backend, n_jobs=workers)


def results(backend: str, calls: Iterator[Call]) -> Generator[Any, None, None]:
    """Run calls on the workers, taking each call only when there is room, and yield what they return as they finish.

    joblib has no generator on Ray: there calls go out in rounds, and a round ends with its slowest.
    """
    if backend in _LISTS_ONLY:
        with joblib.Parallel(batch_size=1) as parallel:
            while some := list(itertools.islice(calls, _ROUND * parallel.n_jobs)):
                yield from parallel(some)
        return
    found = joblib.Parallel(return_as="generator_unordered", batch_size=1)(calls)
    try:
        for result in found:  # noqa: UP028  # `yield from` would close it outside of what follows
            yield result
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # joblib's, that calls under way are lost: so is an interrupt
            found.close()


def lost_workers() -> tuple[type[Exception], ...]:
    """Return the exceptions that mean: workers were killed, and with them trials that can simply run again."""
    scheduler = sys.modules.get("distributed.scheduler")
    return (BrokenProcessPool,) if scheduler is None else (BrokenProcessPool, scheduler.KilledWorker)


@contextmanager
def _cluster(backend: str, workers: int, scheduler: str | None) -> Iterator[None]:
    module = import_module(f"rfcompass.studies.{backend}_cluster")  # an extra
    with getattr(module, f"{backend}_cluster")(workers, scheduler):
        yield
