"""A Ray cluster as joblib's backend: the one at an address, or one on this machine."""

from collections.abc import Iterator
from contextlib import contextmanager

import joblib

from rfcompass.errors import MissingExtra, StudyError

try:
    import ray
    from ray.util.joblib import register_ray
except ImportError as error:
    raise MissingExtra("backend ray needs Ray: pip install 'rfcompass[ray]'", extra="ray", name=error.name) from error


@contextmanager
def ray_cluster(workers: int, scheduler: str | None) -> Iterator[None]:
    """Let joblib send its work to a Ray cluster.

    Args:
        workers: Worker processes of a cluster on this machine.
        scheduler: Address of a cluster, for example `ray://192.0.2.7:10001` or `auto`; one on this machine if None.

    Raises:
        StudyError: If there is no cluster at that address.
    """
    register_ray()
    try:
        if scheduler is None:
            ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False)
        else:
            ray.init(address=scheduler, log_to_driver=False)
    except (ConnectionError, ValueError, RuntimeError) as error:
        raise StudyError(f"no Ray cluster at {scheduler}: {error}", scheduler=scheduler) from error
    try:
        with joblib.parallel_config("ray", n_jobs=workers if scheduler is None else -1):
            yield
    finally:
        ray.shutdown()
