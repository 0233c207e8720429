"""Which tag answers when: slotted ALOHA as in Gen2 [EPC-Gen2], with the Q algorithm of its annex D.

A round offers 2^Q slots; every tag that has power draws one. A slot with one answer is a read, one with several a
collision, one with none passes quickly. Collisions raise Q, empty slots lower it, by a step C in a floating Qfp; as
soon as Qfp rounds to another Q, the tags that wait draw anew from 2^Q slots (QueryAdjust). A tag that was read waits
until all have been read; then all take part again. So the reads each tag gets fall with the number of tags.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numba
import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.errors import InputError
from rfcompass.types.record import Record

_MAX_Q = 15


@dataclass(frozen=True, slots=True, kw_only=True)
class Gen2Slots(Record):
    """How long slots last and how Q moves.

    With the defaults, one tag alone is read about 400 times a second, 13 to 200 together about 280 times; ours.

    Attributes:
        read_s: Slot with one answer: query, RN16, acknowledgement, EPC [s].
        empty_s: Slot without an answer [s].
        collision_s: Slot with several answers [s].
        start_q: Q of the first round.
        step_q: C, how far one slot moves Qfp.
        capture: Chance that the strongest of several answers is read all the same.
    """

    read_s: float = 2.5e-3
    empty_s: float = 0.3e-3
    collision_s: float = 0.8e-3
    start_q: float = 2.0
    step_q: float = 0.3
    capture: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        for key in ("read_s", "empty_s", "collision_s"):
            if not (np.isfinite(value := getattr(self, key)) and value > 0):
                raise InputError(f"Gen2Slots.{key}: {value} is not a duration above 0 s", key=key, got=value)
        for key, high in (("start_q", float(_MAX_Q)), ("step_q", 1.0), ("capture", 1.0)):
            if not 0 <= (value := getattr(self, key)) <= high:
                raise InputError(f"Gen2Slots.{key}: {value} is not in [0, {high:g}]", key=key, got=value)


class SlotLog(NamedTuple):
    """Reads in the order of time, and what became of the other slots.

    Attributes:
        windows: Window in which each read fell, shape (R,).
        tags: Tag that was read, shape (R,).
        times_s: When it was read, from the start [s], shape (R,).
        collided: Answers of each tag in each window that were lost in a collision, shape (W, T).
    """

    windows: IntArray
    tags: IntArray
    times_s: FloatArray
    collided: IntArray


def run_slots(
    slots: Gen2Slots, starts_s: FloatArray, power_db: FloatArray, listening: BoolArray, rng: np.random.Generator
) -> SlotLog:
    """Run the inventory through windows of time in which who has power does not change.

    Args:
        slots: Durations and rules.
        starts_s: Start of each window and end of the last, ascending [s], shape (W + 1,).
        power_db: Strength of each tag's answer in each window, which decides captures, shape (W, T).
        listening: Whether a tag has power in a window, shape (W, T).
        rng: Source of the slots that tags draw.
    """
    rules = np.array([slots.read_s, slots.empty_s, slots.collision_s, slots.start_q, slots.step_q, slots.capture])
    most = int((starts_s[-1] - starts_s[0]) / slots.read_s) + len(starts_s) + 1
    log = np.empty((most, 3))
    collided = np.zeros(listening.shape, dtype=np.int64)
    count = _run(rules, starts_s, np.asarray(power_db), listening, rng, log, collided)
    return SlotLog(log[:count, 0].astype(np.int64), log[:count, 1].astype(np.int64), log[:count, 2].copy(), collided)


@numba.njit(cache=True)
def _run(
    rules: FloatArray,
    starts_s: FloatArray,
    power_db: FloatArray,
    listening: BoolArray,
    rng: np.random.Generator,
    log: FloatArray,
    collided: IntArray,
) -> int:
    """Fill `log` with (window, tag, time) and return how many reads there are."""
    T = listening.shape[1]
    waiting, slot_of = np.ones(T, np.bool_), np.full(T, -1)
    now, qfp, q, slot, last, count = starts_s[0], rules[3], 0, 0, 0, 0
    for window in range(len(starts_s) - 1):
        now = max(now, starts_s[window])
        while now < starts_s[window + 1]:
            if slot >= last:
                _new_round(listening[window], waiting)
                q = round(qfp)
                last, slot = _draw_slots(q, waiting, slot_of, rng), 0
            tag, answers = _who(slot, slot_of, waiting & listening[window], power_db[window])
            if answers > 1:
                tag = tag if rng.random() < rules[5] else -1
                _note_collision(slot, slot_of, waiting & listening[window], tag, collided[window])
            now += rules[1] if answers == 0 else (rules[0] if tag >= 0 else rules[2])
            if tag >= 0 and count < len(log) and now < starts_s[window + 1]:
                log[count, 0], log[count, 1], log[count, 2] = window, tag, now
                count, waiting[tag] = count + 1, False
            qfp = _moved_q(qfp, answers, rules[4])
            slot = slot + 1 if round(qfp) == q else last
    return count


@numba.njit(cache=True)
def _new_round(listening: BoolArray, waiting: BoolArray) -> None:
    """If nobody with power is left to be read, let all take part again."""
    for t in range(len(waiting)):
        if waiting[t] and listening[t]:
            return
    waiting[:] = True


@numba.njit(cache=True)
def _draw_slots(q: int, waiting: BoolArray, slot_of: IntArray, rng: np.random.Generator) -> int:
    """Let every waiting tag draw one of 2^q slots; return their number."""
    slots = 1 << q
    for t in range(len(waiting)):
        slot_of[t] = int(rng.random() * slots) if waiting[t] else -1
    return slots


@numba.njit(cache=True)
def _who(slot: int, slot_of: IntArray, active: BoolArray, power_db: FloatArray) -> tuple[int, int]:
    """Strongest tag that answers in a slot, -1 if none does, and how many do."""
    tag, answers = -1, 0
    for t in range(len(slot_of)):
        if active[t] and slot_of[t] == slot:
            answers += 1
            if tag < 0 or power_db[t] > power_db[tag]:
                tag = t
    return tag, answers


@numba.njit(cache=True)
def _note_collision(slot: int, slot_of: IntArray, active: BoolArray, captured: int, collided: IntArray) -> None:
    """Count the answers that were lost: all but the one that was captured."""
    for t in range(len(slot_of)):
        if active[t] and slot_of[t] == slot and t != captured:
            collided[t] += 1


@numba.njit(cache=True)
def _moved_q(qfp: float, answers: int, step: float) -> float:
    """Qfp after a slot: up by C after a collision, down after an empty one."""
    if answers == 1:
        return qfp
    return min(15.0, qfp + step) if answers > 1 else max(0.0, qfp - step)
