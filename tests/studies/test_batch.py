"""Batches hold every pending trial once, in the order of the grid, and learn how many fit into one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from toy_study import toy_study

from rfcompass.evaluation.records import TrialRecord
from rfcompass.studies.batch import BATCH_SECONDS, BATCH_TRIALS, Schedule

STUDY = toy_study()
CELLS = len(STUDY.cells)


def ran(batch, runtime_s):
    return [
        TrialRecord("toy", cell, seed, {}, runtime_s=runtime_s)
        for cell, seed in zip(batch.cells, batch.seeds, strict=True)
    ]


def run(schedule, runtime_s):
    """Run all batches as one worker would, and return them."""
    batches = []
    for batch in schedule.batches():
        for number, record in zip(batch.numbers, ran(batch, runtime_s), strict=True):
            schedule.tick(number, record)
        batches.append(batch)
    return batches


@given(st.lists(st.booleans(), min_size=8 * CELLS, max_size=8 * CELLS), st.sampled_from([0.0, 0.01, 0.1, 10.0]))
def test_every_pending_trial_is_in_one_batch(pending, runtime_s):
    pending = np.array(pending).reshape(8, CELLS)
    numbers = np.flatnonzero(pending).tolist()
    schedule = Schedule(STUDY, range(8), pending.copy())
    batches = run(schedule, runtime_s)
    assert [number for batch in batches for number in batch.numbers] == numbers
    assert not schedule
    for batch in batches:
        for number, cell, seed in zip(batch.numbers, batch.cells, batch.seeds, strict=True):
            assert (seed, cell) == (number // CELLS, STUDY.cells[number % CELLS])


def test_what_was_lost_is_in_the_next_round():
    schedule = Schedule(STUDY, (5, 3), np.ones((2, CELLS), dtype=bool))
    first, lost = list(schedule.batches())[:2]
    schedule.tick(first.numbers[0], ran(first, 1.0)[0])
    again = [number for batch in schedule.batches() for number in batch.numbers]
    assert again == list(range(1, 2 * CELLS))
    assert lost.numbers[0] in again
    assert (first.seeds, lost.seeds) == ((5,), (5,))


@pytest.mark.parametrize(("runtime_s", "trials"), [(0.0, BATCH_TRIALS), (BATCH_SECONDS / 20, 20), (3.0, 1)])
def test_batches_become_as_long_as_they_should(runtime_s, trials):
    seeds = range(1000)
    sizes = [len(batch) for batch in run(Schedule(STUDY, seeds, np.ones((1000, CELLS), dtype=bool)), runtime_s)]
    assert sizes[0] == 1
    assert set(sizes[CELLS:-1]) <= {trials - 1, trials}


def test_a_slow_cell_does_not_hide_in_a_batch_of_fast_ones():
    schedule = Schedule(STUDY, range(200), np.ones((200, CELLS), dtype=bool))
    for number in range(CELLS):
        schedule.tick(number, TrialRecord("toy", {}, 0, {}, runtime_s=1.0 if number == 2 else 1e-4))
    assert max(sum(number % CELLS == 2 for number in batch.numbers) for batch in schedule.batches()) == 1


def test_the_rest_of_a_batch_is_what_comes_after():
    batch = next(Schedule(STUDY, range(3), np.ones((3, CELLS), dtype=bool)).batches())
    assert batch.after(0) == batch
    assert len(batch.after(1)) == len(batch) - 1
