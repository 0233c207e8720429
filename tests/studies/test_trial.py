import json

import pytest
from toy_study import METRICS, toy_trial

from rfcompass.studies.metric import Metric
from rfcompass.studies.trial import run_trial

CELL = {"noise_m": 0.1, "method": "shy"}


def test_a_trial_that_raises_becomes_a_typed_failure():
    record = run_trial("toy", toy_trial, METRICS, CELL, 3)
    assert (record.failure.kind, record.failure.message) == ("TooFewReads", "3 reads are too few")
    assert json.loads(record.failure.numbers) == {"reads": 3}
    assert not record.metrics


@pytest.mark.parametrize("values", [{}, {"x": 1.0, "y": 2.0}, {"x": float("nan")}, {"x": "one"}])
def test_metrics_other_than_declared_are_a_failure(values):
    record = run_trial("toy", lambda cell, seed, rng: values, (Metric("x"),), {}, 0)
    assert record.failure.kind == "StudyError"


def test_a_trial_depends_on_its_cell_and_seed_only():
    first = run_trial("toy", toy_trial, METRICS, CELL, 5)
    run_trial("toy", toy_trial, METRICS, {**CELL, "method": "bold"}, 4)
    assert dict(first.metrics) == dict(run_trial("toy", toy_trial, METRICS, CELL, 5).metrics)


def test_cells_of_one_seed_share_their_random_numbers():
    seen = []
    for method in ("bold", "shy"):
        run_trial("toy", lambda cell, seed, rng: seen.append(rng.bytes(8)) or {}, (), {"method": method}, 1)
    assert seen[0] == seen[1]


def test_a_trial_cannot_change_the_cell_of_others():
    run_trial("toy", lambda cell, seed, rng: cell.clear() or {}, (), CELL, 0)
    assert CELL["method"] == "shy"


def test_an_interrupt_is_no_failure_of_a_trial():
    def interrupted(cell, seed, rng):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_trial("toy", interrupted, (), {}, 0)
