"""A polygon falls into its legs, also with noisy positions; a curve does not."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rfcompass.errors import UnsuitablePath
from rfcompass.rf.path_legs import bend_m, spans_two_directions, straight_legs

TOLERANCE_M = 0.02  # λ/16 at 920 MHz
STEP_M = 0.04
angles = st.floats(np.pi / 4, np.pi * 0.9)
lengths = st.floats(0.4, 3.0)


def polygon(lengths_m, turns_rad):
    """Positions every 4 cm along legs that turn by the given angles; and the leg of each position."""
    points, leg_of, here, heading = [np.zeros(2)], [0], np.zeros(2), 0.0
    for leg, (length_m, turn_rad) in enumerate(zip(lengths_m, [0.0, *turns_rad], strict=True)):
        heading += turn_rad
        along = STEP_M * np.arange(1, round(length_m / STEP_M) + 1)
        points += list(here + np.outer(along, [np.cos(heading), np.sin(heading)]))
        leg_of += [leg] * len(along)
        here = points[-1]
    return np.column_stack([np.array(points), np.zeros(len(points))]), np.array(leg_of)


def arc(radius_m, angle_rad, step_m=STEP_M):
    angle = np.arange(0.0, angle_rad, step_m / radius_m)
    return np.column_stack([radius_m * np.cos(angle), radius_m * np.sin(angle), np.zeros(angle.size)])


@settings(max_examples=50)
@example(legs=[1.0, 1.0, 1.625], turns=[2.125, 2.5625, 1.0], left=[False] * 3, seed=668)  # cut on both sides of a tip
@example(legs=[1.0, 1.0, 1.625], turns=[1.125, 2.5625, 1.0], left=[False] * 3, seed=667)
@given(
    legs=st.lists(lengths, min_size=2, max_size=4),
    turns=st.lists(angles, min_size=3, max_size=3),
    left=st.lists(st.booleans(), min_size=3, max_size=3),
    seed=st.integers(0, 1000),
)
def test_a_polygon_falls_into_its_legs_whatever_the_noise_of_its_positions(legs, turns, left, seed):
    signed = [turn if side else -turn for turn, side in zip(turns, left, strict=True)]
    positions_m, leg_of = polygon(legs, signed[: len(legs) - 1])
    noise_m = np.random.default_rng(seed).normal(0.0, 0.002, positions_m.shape)
    found = straight_legs(positions_m + noise_m, TOLERANCE_M)
    assert len(found) == len(legs)
    assert np.concatenate(found).tolist() == list(range(len(positions_m)))
    wrong = sum(int((leg_of[rows] != leg).sum()) for leg, rows in enumerate(found))
    assert wrong <= len(legs) - 1  # the position on a corner may go to either leg


def test_a_line_is_one_leg_however_often_it_is_driven():
    there = np.column_stack([np.linspace(0, 1, 26), np.zeros(26), np.zeros(26)])
    (rows,) = straight_legs(np.concatenate([there, there[::-1], there]), TOLERANCE_M)
    assert rows.tolist() == list(range(78))


def test_a_square_that_starts_in_the_middle_of_a_side_has_five_legs():
    positions_m, _ = polygon([0.5, 1.0, 1.0, 1.0, 0.46], [np.pi / 2] * 4)
    assert [len(rows) for rows in straight_legs(positions_m, TOLERANCE_M)] == pytest.approx([13, 25, 25, 25, 12], abs=1)


def test_two_parallel_lines_are_two_legs():
    low = np.column_stack([np.linspace(0, 1, 26), np.zeros(26), np.zeros(26)])
    high = low + np.array([0.0, 0.0, 0.5])
    found = straight_legs(np.concatenate([low, high]), TOLERANCE_M)
    assert [rows.tolist() for rows in found] == [list(range(26)), list(range(26, 52))]


def test_a_gap_in_a_leg_does_not_cut_it():
    positions_m, leg_of = polygon([1.0, 1.0], [np.pi / 2])
    kept = (np.arange(len(positions_m)) < 5) | (np.arange(len(positions_m)) > 10)
    found = straight_legs(positions_m[kept], TOLERANCE_M)
    assert [len(rows) for rows in found] == pytest.approx([np.sum(leg_of[kept] == leg) for leg in (0, 1)], abs=1)


@given(radius_m=st.floats(0.2, 3.0), angle_rad=st.floats(0.8, 2 * np.pi), seed=st.integers(0, 1000))
def test_a_curve_has_no_legs(radius_m, angle_rad, seed):
    path_m = arc(radius_m, angle_rad, step_m=min(STEP_M, radius_m / 8))
    path_m = path_m + np.random.default_rng(seed).normal(0.0, 0.001, path_m.shape)
    if bend_m(path_m) <= TOLERANCE_M:
        return
    with pytest.raises(UnsuitablePath, match="straight") as caught:
        straight_legs(path_m, TOLERANCE_M)
    assert caught.value.numbers["bend_m"] > TOLERANCE_M


def test_waiting_at_each_position_changes_neither_legs_nor_curves():
    """As for a reader whose transmitters take turns at each place."""
    square_m, _ = polygon([1.0, 1.0], [np.pi / 2])
    once, twice = (straight_legs(path_m, TOLERANCE_M) for path_m in (square_m, np.repeat(square_m, 2, axis=0)))
    assert [2 * len(leg) for leg in once] == pytest.approx([len(leg) for leg in twice], abs=2)
    with pytest.raises(UnsuitablePath):
        straight_legs(np.repeat(arc(0.5, np.pi), 2, axis=0), TOLERANCE_M)


def test_a_step_aside_is_no_leg():
    positions_m = np.column_stack([np.linspace(0, 1, 26), np.zeros(26), np.zeros(26)])
    positions_m[12, 1] = 0.1
    with pytest.raises(UnsuitablePath):
        straight_legs(positions_m, TOLERANCE_M)


def test_only_a_path_with_width_spans_two_directions():
    assert not spans_two_directions(polygon([3.0], [])[0])
    assert not spans_two_directions(np.zeros((5, 3)))
    assert spans_two_directions(polygon([3.0, 3.0], [np.pi / 2])[0])
    assert spans_two_directions(polygon([3.0, 0.6], [np.pi / 2])[0])
