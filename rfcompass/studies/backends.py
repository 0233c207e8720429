"""Where trials run: joblib's backends, with worker processes that all compute the same bits."""

from contextlib import AbstractContextManager

import joblib
from joblib._parallel_backends import LokyBackend
from joblib.executor import get_memmapping_executor

from rfcompass.errors import StudyError

_IDLE_S = 300  # a worker without work ends after this time


class OneProcess(LokyBackend):  # type: ignore[misc]  # joblib has no types
    """Loky with a single worker process.

    joblib itself would run a single job in the calling process, whose linear algebra library may use more threads
    than a worker's and so sum in another order. Two slots keep the process busy while its last answer travels.
    """

    def effective_n_jobs(self, n_jobs: int) -> int:  # noqa: ARG002  # joblib asks with a number
        """Return the number of slots."""
        return 2

    def configure(self, n_jobs: int = 1, parallel: joblib.Parallel = None, **options: object) -> int:
        """Start the process and return the number of slots."""
        environment = self._prepare_worker_env(n_jobs=1)
        self._workers = get_memmapping_executor(
            1, timeout=_IDLE_S, env=environment, context_id=parallel._id, **{**self.backend_kwargs, **options}
        )
        self.parallel = parallel
        return self.effective_n_jobs(n_jobs)


def parallel_backend(backend: str, workers: int) -> AbstractContextManager[object]:
    """Let joblib use a backend and a number of workers, for the length of a `with` block.

    Raises:
        StudyError: If there is no such backend, or not even one worker.
    """
    if workers < 1:
        raise StudyError(f"{workers} workers: at least 1", workers=workers)
    if backend == "loky":
        where = "loky" if workers > 1 else OneProcess()
        return joblib.parallel_config(where, n_jobs=workers, inner_max_num_threads=1)
    if backend in ("sequential", "threading"):
        return joblib.parallel_config(backend, n_jobs=workers)
    raise StudyError(f"no backend {backend!r}; known: loky, sequential, threading", backend=backend)
