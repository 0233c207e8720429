import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import ShapeError
from rfcompass.evaluation.metrics import (
    TIE_M,
    angle_error_rad,
    order_comparisons,
    position_error_m,
    triplet_comparisons,
)

seeds = st.integers(0, 10_000)


def slow_triplets(epcs, m, positions_m):
    """Readable reference: all answered triplets as (correct, gap)."""
    found = []
    for a, epc in enumerate(epcs):
        for i in range(len(epcs)):
            for j in range(i + 1, len(epcs)):
                if a in (i, j) or any(epcs[k] not in positions_m for k in (a, i, j)):
                    continue
                d_i, d_j = (float(np.linalg.norm(positions_m[epc] - positions_m[epcs[k]])) for k in (i, j))
                if abs(d_i - d_j) > TIE_M and not np.isnan(m[a, i] + m[a, j]):
                    found.append(((m[a, i] < m[a, j]) == (d_i < d_j) and m[a, i] != m[a, j], abs(d_i - d_j)))
    return found


@given(seeds, st.integers(0, 7))
def test_triplets_agree_with_the_slow_reference(seed, n):
    rng = np.random.default_rng(seed)
    epcs = [f"tag{k}" for k in range(n)]
    positions_m = {epc: rng.integers(0, 4, size=2) * 0.1 for epc in epcs if rng.random() < 0.9}
    m = rng.integers(0, 5, size=(n, n)).astype(float)
    m[rng.random((n, n)) < 0.1] = np.nan
    judged = triplet_comparisons(epcs, m, positions_m)
    expected = slow_triplets(epcs, m, positions_m)
    assert judged.correct.tolist() == [correct for correct, _ in expected]
    assert np.allclose(judged.gap_m, [gap for _, gap in expected])


@given(seeds)
def test_true_distances_order_every_triplet_and_their_opposite_none(seed):
    rng = np.random.default_rng(seed)
    p = rng.normal(size=(6, 3))
    distance = np.linalg.norm(p[:, None] - p[None, :], axis=2)
    positions_m = {str(k): p[k] for k in range(6)}
    assert triplet_comparisons(tuple(positions_m), distance, positions_m).share == 1.0
    assert triplet_comparisons(tuple(positions_m), -distance, positions_m).share == 0.0


def test_an_even_row_has_ties_and_rounding_does_not_break_them():
    positions_m = {str(k): np.array([0.08 * k, 0.6]) for k in range(8)}
    judged = triplet_comparisons(tuple(positions_m), np.zeros((8, 8)), positions_m)
    assert judged.gap_m.min() > 0.07
    assert judged.share == 0.0  # a meter that says nothing is never right


def test_gap_bins_part_the_comparisons():
    rng = np.random.default_rng(1)
    positions_m = {str(k): rng.random(2) for k in range(7)}
    judged = triplet_comparisons(tuple(positions_m), rng.random((7, 7)), positions_m)
    bins = [judged.within(0.0, 0.1), judged.within(0.1, 0.2), judged.within(0.2)]
    assert sum(len(part.correct) for part in bins) == len(judged.correct) == 7 * 15
    assert sum(part.correct.sum() for part in bins) == judged.correct.sum()
    assert judged.within(5.0).share is None


@given(st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), max_size=8))
def test_orders_agree_with_the_slow_reference(pairs):
    estimates, truth = ([pair[k] for pair in pairs] for k in (0, 1))
    expected = [
        ((estimates[i] < estimates[j]) == (truth[i] < truth[j]) and estimates[i] != estimates[j])
        for i in range(len(pairs))
        for j in range(i + 1, len(pairs))
        if abs(truth[i] - truth[j]) > TIE_M
    ]
    assert order_comparisons(estimates, truth).correct.tolist() == expected


@given(seeds)
def test_a_position_error_does_not_depend_on_the_frame(seed):
    rng = np.random.default_rng(seed)
    a, b, shift = rng.normal(size=(3, 5, 2))
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    assert np.allclose(position_error_m(a, b), position_error_m(a @ turn.T + shift[0], b @ turn.T + shift[0]))
    assert np.allclose(position_error_m(a, a[0]), np.hypot(*(a - a[0]).T))


@given(st.floats(-20, 20), st.floats(-20, 20), st.integers(1, 6), st.integers(-3, 3))
def test_an_angle_error_ignores_turns_that_look_the_same(a, b, symmetry, turns):
    error = angle_error_rad(a, b, symmetry)
    assert 0.0 <= error <= np.pi / symmetry + 1e-12
    assert np.isclose(error, angle_error_rad(b + turns * 2 * np.pi / symmetry, a, symmetry), atol=1e-9)


def test_arrays_that_do_not_fit_are_refused():
    with pytest.raises(ShapeError):
        order_comparisons([0.0, 1.0], [0.0])
    with pytest.raises(ShapeError):
        triplet_comparisons(("a", "b"), np.zeros((2, 3)), {})
    with pytest.raises(ShapeError):
        angle_error_rad(0.0, 0.0, 0)
