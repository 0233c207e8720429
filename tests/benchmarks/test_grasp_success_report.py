"""What is said of executed grasps: whether anything rose, and whether what was meant did, side by side."""

import numpy as np
import pytest

from benchmarks.grasp_success import report, rose
from planners.grasp_number_kernels import CLOSING


def row(log_odds, outcome, *, own, seed=0, way="best"):
    return {
        "family": "covered_1p10", "seed": seed, "state": 0, "way": way, "kind": 1, "numbers": np.zeros(len(CLOSING)),
        "log_odds": log_odds, "item": "box", "outcome": outcome, "own": own,
    }  # fmt: skip


# The better a grasp looks, the surer something rises; but what the best-looking ones lift is something else.
ROWS = [
    *(row(-1.0, "slipped", own=False, seed=seed) for seed in (0, 1)),
    *(row(1.0, "held", own=True, seed=seed) for seed in (0, 1)),
    *(row(3.0, "held", own=False, seed=seed, way="random") for seed in (0, 1)),
]


def test_what_rose_by_mistake_did_not_rise_as_meant():
    ends = rose(ROWS)
    assert ends["held"].tolist() == [False, False, True, True, True, True]
    assert ends["own"].tolist() == [False, False, True, True, False, False]


@pytest.mark.parametrize(
    ("line", "held", "own"),
    [
        ("all ", "held 0.67 AUC 1.00 [1.00, 1.00]", "own 0.33 AUC 0.50 [0.50, 0.50]"),
        ("quality 0.90..1.00", "held 1.00 [1.00, 1.00]", "own 0.00 [0.00, 0.00]"),
        ("best grasp of a state", "held 1.00 [1.00, 1.00]", "own 1.00 [1.00, 1.00]"),
    ],
)
def test_the_report_tells_both(line, held, own, capsys):
    report(ROWS)
    (said,) = (said for said in capsys.readouterr().out.splitlines() if said.startswith(line))
    assert said.split(" | ")[1:] == [held, own]
