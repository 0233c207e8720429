"""Slots: nobody answers twice in a turn, nothing is counted twice, and many tags share what the air can carry."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.errors import InputError
from rfcompass.simulation.gen2 import Gen2Slots, run_slots

SLOTS = Gen2Slots()


def run(T, seconds=2.0, slots=SLOTS, seed=0, power_db=None):
    power_db = np.zeros((1, T)) if power_db is None else np.array([power_db])
    rng = np.random.default_rng(seed)
    return run_slots(slots, np.array([0.0, seconds]), power_db, np.ones((1, T), bool), rng)


@settings(max_examples=20)
@given(T=st.integers(1, 30), seed=st.integers(0, 10_000))
def test_no_tag_answers_twice_in_one_turn_and_reads_do_not_overlap(T, seed):
    log = run(T, seed=seed)
    assert (np.diff(log.times_s) >= SLOTS.read_s - 1e-12).all()
    turns = log.tags[: T * (len(log.tags) // T)].reshape(-1, T)
    assert all(sorted(one) == list(range(T)) for one in turns.tolist())


def test_one_tag_alone_is_read_without_a_break():
    """Q falls to 0 within a few slots, and then every slot is a read."""
    assert len(run(1).tags) == pytest.approx(2.0 / SLOTS.read_s, rel=0.01)


@pytest.mark.parametrize("T", [8, 25, 100, 200])
def test_any_number_of_tags_shares_what_the_air_can_carry(T):
    """At the best Q each read costs e slots: itself, one empty slot and e - 2 collisions; Q in steps costs a fifth."""
    read_costs_s = SLOTS.read_s + SLOTS.empty_s + (np.e - 2) * SLOTS.collision_s
    rate = len(run(T, 5.0).tags) / 5.0
    assert 0.8 / read_costs_s < rate < 1.0 / SLOTS.read_s


def test_two_tags_that_always_collide_lose_both_answers_or_one():
    """Q = 0 and a step of 0 leave one slot: both answer in it."""
    fixed = {"start_q": 0.0, "step_q": 0.0}
    deaf = run(2, slots=Gen2Slots(**fixed))
    assert len(deaf.tags) == 0
    assert deaf.collided.tolist() == [[deaf.collided[0, 0]] * 2]
    assert deaf.collided[0, 0] > 0
    captured = run(2, slots=Gen2Slots(**fixed, capture=1.0), power_db=[0.0, 3.0])
    weak, strong = captured.collided[0]
    assert strong == 0
    assert weak - int((captured.tags == 1).sum()) in (0, 1)  # the end may cut off the last read


def test_a_tag_without_power_is_silent():
    listening = np.array([[True, False], [True, True]])
    log = run_slots(SLOTS, np.array([0.0, 1.0, 2.0]), np.zeros((2, 2)), listening, np.random.default_rng(0))
    assert set(log.tags[log.windows == 0]) == {0}
    assert set(log.tags[log.windows == 1]) == {0, 1}


@pytest.mark.parametrize("wrong", [{"read_s": 0.0}, {"empty_s": np.nan}, {"start_q": 16.0}, {"capture": -0.1}])
def test_impossible_rules_are_refused(wrong):
    with pytest.raises(InputError):
        Gen2Slots(**wrong)
