"""The trial of `bench_runner`, in a module of its own so that worker processes can import it."""

import time
from collections.abc import Mapping

import numpy as np

_NUMBERS = 4096
_SWEEPS_IN_10_MS = 1000


def ten_milliseconds(cell: Mapping[str, object], seed: int, rng: np.random.Generator) -> dict[str, float]:
    """Compute for about ten milliseconds on one thread; say how much CPU time it was, and what came out."""
    del cell, seed
    start_s = time.process_time()
    x = rng.normal(size=_NUMBERS)
    for _ in range(_SWEEPS_IN_10_MS):
        x = np.sqrt(x * x + 1.0) - 0.5
    return {"norm": float(np.abs(x).sum()), "cpu_s": time.process_time() - start_s}
