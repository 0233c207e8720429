"""A small study for the tests; worker processes import it by name."""

import contextlib
import json
import mmap
import os
import re
import signal
import time
from pathlib import Path

import numpy as np

from rfcompass.errors import TooFewReads
from rfcompass.studies.metric import Metric
from rfcompass.studies.study import PaperValue, Study

CENTIMETRES = {"unit": "cm", "scale": 100.0}
METRICS = (
    Metric("error_m", ("median", "p90"), title="error", **CENTIMETRES),
    Metric("right", ("share",), "bool", unit="%", scale=100.0, digits=0),
    Metric("tag_errors_m", ("median",), "samples", **CENTIMETRES),
    Metric("remark", column="text"),
)


def toy_trial(cell, seed, rng):
    if seed % 5 == 3 and cell["method"] == "shy":
        raise TooFewReads(f"{seed} reads are too few", reads=np.int64(seed))
    noise = cell["noise_m"] * rng.normal(size=20_000)
    error_m = float(noise @ noise) / 20_000  # a long dot product: its last bits depend on the number of threads
    tags = rng.exponential(cell["noise_m"], size=seed % 4)
    return {
        "error_m": error_m,
        "right": bool(rng.random() < 0.7) if seed % 7 else None,
        "tag_errors_m": tags,
        "remark": f"{cell['method']} says {seed}",
    }


def slow_toy_trial(cell, seed, rng):
    time.sleep(0.02)
    return toy_trial(cell, seed, rng)


def killing_toy_trial(cell, seed, rng):
    """Kill the worker that waits for this trial, then, in another try, this very process; each once for each seed."""
    marks = Path(os.environ["TOY_MARKS"])
    killed = seed % 3 == 1 and cell == {"noise_m": 0.1, "method": "bold"}
    for victim in (os.getppid(), os.getpid()) if killed else ():
        with contextlib.suppress(FileExistsError):
            (marks / f"{seed}-{victim == os.getpid()}").touch(exist_ok=False)
            os.kill(victim, signal.SIGKILL)
            time.sleep(60.0)
    return toy_trial(cell, seed, rng)


def surroundings_trial(cell, seed, rng):
    names = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS")
    return {"remark": json.dumps({"process": os.getpid(), **{name: os.environ.get(name) for name in names}})}


def short_work(number):
    time.sleep(0.005)
    return number


def hostile_toy_trial(cell, seed, rng):
    """What goes wrong follows from the seed; everything else is a toy trial."""
    mischief = {2: spin_in_compiled_code, 4: hoard, 5: crash, 6: exit_quietly, 7: hoard_shared}
    if cell["method"] == "bold" and seed in mischief:
        mischief[seed]()
    return toy_trial(cell, seed, rng)


def rarely_hostile_toy_trial(cell, seed, rng):
    mischief = {50: crash, 90: exit_quietly, 91: crash, 150: spin_in_compiled_code}
    if seed in mischief:
        mischief[seed]()
    return toy_trial({**cell, "method": "bold"}, seed, rng)


def spin_in_compiled_code():
    """Hold the interpreter for minutes, where no Python signal handler and no Python thread gets its turn."""
    re.match(r"(a|aa)+$", "a" * 60 + "b")


def hoard():
    kept = []
    while True:
        kept.append(np.ones(50_000_000))


def hoard_shared():
    """Take memory that no limit of the system counts."""
    shared = np.frombuffer(mmap.mmap(-1, 2_000_000_000), dtype=np.uint8)
    for start in range(0, len(shared), 40_000_000):
        shared[start : start + 40_000_000] = 1
        time.sleep(0.01)


def crash():
    os.kill(os.getpid(), signal.SIGSEGV)


def exit_quietly():
    os._exit(3)


def toy_study(**changes):
    declared = {
        "name": "toy",
        "title": "A toy",
        "kind": "simulated",
        "factors": {"noise_m": (0.1, 0.5), "method": ("bold", "shy")},
        "seeds": range(8),
        "trial": toy_trial,
        "metrics": METRICS,
        "paper": (PaperValue("error_m", "median", 0.02, "[Toy] Fig. 1", "another | room", {"noise_m": 0.1}),),
        "tuning_seeds": (100, 101),
    }
    return Study(**{**declared, **changes})
