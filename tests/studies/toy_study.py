"""A small study for the tests; worker processes import it by name."""

import time

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
