"""A Dask cluster as joblib's backend: the one at an address, or one on this machine."""

import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import joblib

from rfcompass.errors import MissingExtra, StudyError

try:
    from distributed import CancelledError, Client, LocalCluster
    from distributed.comm import CommClosedError, get_address_host_port, parse_address
    from distributed.comm.registry import get_backend
    from joblib._dask import DaskDistributedBackend
except ImportError as error:
    raise MissingExtra(
        "backend dask needs Dask: pip install 'rfcompass[dask]'", extra="dask", name=error.name
    ) from error

_CONNECT_S = 10.0
_WORKERS_S = 30.0  # a queue that grants a worker later than this is for the user to wait for


class DaskWorkers(DaskDistributedBackend):  # type: ignore[misc]  # joblib has no types
    """joblib's Dask backend, which also sends the work away when the cluster has a single worker."""

    def effective_n_jobs(self, n_jobs: int) -> int:
        """Return the number of slots; joblib would run a single one in this process instead."""
        return max(2, super().effective_n_jobs(n_jobs))


@contextmanager
def dask_cluster(workers: int, scheduler: str | None) -> Iterator[None]:
    """Let joblib send its work to a Dask cluster.

    Args:
        workers: Worker processes of a cluster on this machine.
        scheduler: Address of a cluster, for example `tcp://192.0.2.7:8786`; one on this machine if None.

    Raises:
        StudyError: If the address is none, nothing answers there, the cluster has no worker, or its scheduler is lost.
    """
    with _client(workers, scheduler) as client:
        _await_worker(client, scheduler)
        try:
            with joblib.parallel_config(DaskWorkers(client=client), n_jobs=-1):
                yield
        except (CancelledError, CommClosedError) as error:
            raise StudyError(
                "the Dask scheduler was lost; all rows that arrived are kept, resume to go on", scheduler=scheduler
            ) from error


@contextmanager
def _client(workers: int, scheduler: str | None) -> Iterator[Client]:
    if scheduler is not None:
        with _connected(scheduler) as client:
            yield client
        return
    with (
        LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0") as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield client


def _connected(scheduler: str) -> Client:
    _check_that_something_listens(scheduler)
    try:
        return Client(scheduler, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise StudyError(f"no Dask scheduler answers at {scheduler}: {error}", scheduler=scheduler) from error


def _check_that_something_listens(scheduler: str) -> None:
    """Knock at the door first: a Dask client that fails to connect complains again and again, up to the end."""
    try:
        scheme, _ = parse_address(scheduler)
        get_backend(scheme)
        host, port = get_address_host_port(scheduler)
    except ValueError as error:
        raise StudyError(f"{scheduler!r} is no address of a scheduler: {error}", scheduler=scheduler) from error
    if scheme not in ("tcp", "tls"):
        return
    try:
        socket.create_connection((host, port), timeout=_CONNECT_S).close()
    except OSError as error:
        raise StudyError(f"no Dask scheduler answers at {scheduler}: {error}", scheduler=scheduler) from error


def _await_worker(client: Client, scheduler: str | None) -> None:
    with suppress(TimeoutError):
        client.wait_for_workers(1, timeout=_WORKERS_S)
        return
    where = "on this machine" if scheduler is None else f"at {scheduler}"
    raise StudyError(f"the Dask cluster {where} has no worker after {_WORKERS_S:g} s", scheduler=scheduler)
