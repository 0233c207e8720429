"""What the runner of studies costs, beside plain joblib and beside the trials, with trials of ten milliseconds.

Ours writes every row to the disk, keeps every trial in a process that may crash, and can be resumed; the peer is a
bare `joblib.Parallel` over the same function with the same random numbers, which keeps its answers in memory.

Run `python -m benchmarks.bench_runner`; about two minutes, or ten seconds with `--fast`. Two workers are timed by the
wall clock, which includes waiting for work, and in turns, best of several. The last line is CPU time of one worker and
its runner, all processes taken together, less that of the trials, and beside it that of the trials: 20 times as much
means that the runner costs 5 %. It leaves out the start, which the line before shows.
"""

import argparse
import resource
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import joblib
import numpy as np
from joblib.externals.loky import get_reusable_executor

from benchmarks.runner_trial import ten_milliseconds
from benchmarks.timing import Timing, show
from rfcompass.arrays import FloatArray
from rfcompass.studies.folder import read_rows
from rfcompass.studies.metric import Metric
from rfcompass.studies.runner import run_study
from rfcompass.studies.study import Study, trial_rng

STUDY = Study(
    name="bench-runner",
    title="Trials of ten milliseconds",
    kind="simulated",
    factors={"only": ("one",)},
    seeds=range(1000),
    trial=ten_milliseconds,
    metrics=(Metric("norm"), Metric("cpu_s")),
)

_IDLE_S = 60  # as our runner asks for; otherwise joblib would start new workers for each of the two


def run(fast: bool = False) -> list[Timing]:
    """Run the study with our runner and with joblib's, in turns."""
    trials, repeats = (40, 1) if fast else (1000, 2)
    return [
        _beside_joblib(f"{trials} trials of 10 ms, 2 workers, wall clock", trials, lambda: None, repeats),
        _beside_joblib("2 trials by 2 new workers, wall clock", 2, _stop_workers, repeats),
        _beside_trials(trials),
    ]


def _beside_joblib(name: str, trials: int, prepare: Callable[[], None], repeats: int) -> Timing:
    ours_s, peers_s = [], []
    ours, peers = _ours(trials, workers=2)[0], _peers(trials)  # also starts the workers
    for _ in range(repeats):
        for call, times_s in ((lambda: _ours(trials, workers=2), ours_s), (lambda: _peers(trials), peers_s)):
            prepare()
            start = time.perf_counter()
            call()
            times_s.append(time.perf_counter() - start)
    agreement = float(np.abs(ours - peers).max() / peers.max())
    return Timing(name, min(ours_s), f"joblib {joblib.__version__}", min(peers_s), agreement, threads=2)


def _beside_trials(trials: int) -> Timing:
    few = trials // 10  # their run costs the start too, so that the difference is what the other trials cost
    (few_s, few_own_s), (all_s, all_own_s) = (_spent_s(count) for count in (few, trials))
    own_s = all_own_s - few_own_s
    name = f"the runner of {trials - few} more trials of 10 ms, CPU"
    return Timing(name, all_s - few_s - own_s, "the trials", own_s, agreement=0.0)


def _spent_s(trials: int) -> tuple[float, float]:
    """CPU time of a run with one worker, and of its trials alone [s]."""
    start_s = _used_s()
    _, own_s = _ours(trials, workers=1)
    return _used_s() - start_s, own_s


def _ours(trials: int, workers: int) -> tuple[FloatArray, float]:
    """Run the study; return the answers and the trials' own CPU time [s]."""
    with tempfile.TemporaryDirectory() as folder:
        run_study(STUDY, Path(folder), trials=trials, workers=workers)
        rows = read_rows(folder)
    return np.asarray(rows.column("norm")), float(np.sum(rows.column("cpu_s")))


def _peers(trials: int) -> FloatArray:
    with joblib.parallel_config("loky", n_jobs=2, idle_worker_timeout=_IDLE_S):
        answers = joblib.Parallel()(joblib.delayed(_trial)(seed) for seed in range(trials))
    return np.array([answer["norm"] for answer in answers])


def _trial(seed: int) -> dict[str, float]:
    return ten_milliseconds({"only": "one"}, seed, trial_rng(STUDY.name, seed))


def _stop_workers() -> None:
    get_reusable_executor().shutdown(wait=True)


def _used_s() -> float:
    """CPU time of this process and of all that it has started and seen end [s]."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in used)


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fast", action="store_true", help="few trials, to see that it works")
    show(run(parser.parse_args(argv).fast))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
