"""What a benchmark reports: our time beside a peer's, both from one run, and how far the answers agree."""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import TypeVar

import numpy as np

from rfcompass.arrays import FloatArray

Problem = TypeVar("Problem")
Answer = TypeVar("Answer")


@dataclass(frozen=True, slots=True)
class Timing:
    """One line of a benchmark.

    Attributes:
        name: What was computed, with its size.
        ours_s: Our CPU time, best of several [s].
        peer: Who computed the same.
        peer_s: CPU time of the peer, best of several [s].
        agreement: Largest difference of the answers, relative to the largest answer.
        threads: Threads that either side used.
    """

    name: str
    ours_s: float
    peer: str
    peer_s: float
    agreement: float
    threads: int = 1

    @property
    def ratio(self) -> float:
        """How many times faster we are."""
        return self.peer_s / self.ours_s

    def as_dict(self) -> dict[str, float | int | str]:
        """All numbers under their names, for JSON."""
        return {**asdict(self), "ratio": self.ratio}

    def cells(self) -> tuple[str, ...]:
        """Name, our time, peer, its time, ratio and agreement as text."""
        times = _shown(self.ours_s), self.peer, _shown(self.peer_s)
        return self.name, *times, f"{self.ratio:.1f}x", f"{self.agreement:.0e}"


def _shown(seconds: float) -> str:
    return f"{seconds * 1e3:.1f} ms" if seconds >= 1e-3 else f"{seconds * 1e6:.1f} us"


def best_of(repeats: int, compute: Callable[[], Answer]) -> tuple[float, Answer]:
    """Least CPU time of several calls [s], and the answer of the last; call once before to compile."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        answer = compute()
        times.append(time.process_time() - start)
    return min(times), answer


def times_of(solve: Callable[[Problem], Answer], problems: Sequence[Problem]) -> tuple[FloatArray, list[Answer]]:
    """CPU time of each solve [s], shape (P,), and all answers; the first problem is solved once before, to compile."""
    solve(problems[0])
    times, answers = [], []
    for problem in problems:
        start = time.process_time()
        answers.append(solve(problem))
        times.append(time.process_time() - start)
    return np.array(times), answers


def median_of(solve: Callable[[Problem], Answer], problems: Sequence[Problem]) -> tuple[float, list[Answer]]:
    """Median CPU time of one solve [s], and all answers."""
    times, answers = times_of(solve, problems)
    return float(np.median(times)), answers


def show(timings: Sequence[Timing]) -> None:
    """Print a table."""
    for row in (("what", "ours", "peer", "peer's", "ratio", "differ by"), *(timing.cells() for timing in timings)):
        print("{:44s} {:>10s}  {:26s} {:>10s} {:>7s} {:>9s}".format(*row))
