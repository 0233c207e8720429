"""Where one part tag can be: values as slow sums give them, bounds that hold, and no likelihood lost."""

import numpy as np
import pytest
from scipy import stats

from rfcompass.localization.tag_kernels import (
    comparison_log_likelihood,
    effective_count,
    range_log_likelihood,
    tag_cells,
)

BOUNDS_M = np.array([[-1.0, 1.2], [-1.1, 1.0]])
LIMITS = np.array([0.32, 1.25e-3, 12.0, 20.0])


def ranges(rng, M=11, odometry=True):
    """Distances of a tag at (0.2, -0.1), 0.1 m below most anchors."""
    anchors = np.column_stack([rng.uniform(-0.6, 0.6, (M, 2)), rng.uniform(0.0, 0.3, M)])
    d = np.linalg.norm(anchors - np.array([0.2, -0.1, 0.0]), axis=1)
    v, w = (rng.uniform(0, 1e-3, (2, M))) * odometry
    noise = np.column_stack([np.full(M, 0.02**2), np.full(M, 0.05**2), v, w, rng.uniform(-0.3, 0.3, (M, 2))])
    return np.column_stack([anchors, d + 0.03 * rng.normal(size=M), noise])


def comparisons(rng, M=23, odometry=True):
    i, j = rng.uniform(-0.6, 0.6, (2, M, 3))
    t = np.array([0.2, -0.1, 0.0])
    swap = np.linalg.norm(i - t, axis=1) > np.linalg.norm(j - t, axis=1)
    i[swap], j[swap] = j[swap], i[swap].copy()
    v, w = (rng.uniform(0, 1e-3, (2, M))) * odometry
    fixed = np.column_stack([np.linalg.norm(i - j, axis=1), np.full(M, 0.03**2), np.full(M, 0.05), np.full(M, 0.5)])
    return np.column_stack([i, j, fixed, v, w, rng.uniform(-0.3, 0.3, (M, 2))])


def slow_ranges(rows, x, y):
    total = 0.0
    for ax, ay, az, r, alpha2, beta2, v, w, cx, cy in rows:
        d = np.sqrt((x - ax) ** 2 + (y - ay) ** 2 + az**2)
        s = np.sqrt(alpha2 + beta2 * d**2 + v + w * ((x - cx) ** 2 + (y - cy) ** 2))
        total += stats.t.logpdf((r - d) / s, 4) - np.log(s) - stats.t.logpdf(0.0, 4)
    return total


def slow_comparisons(rows, x, y):
    p, total = np.array([x, y, 0.0]), 0.0
    for row in rows:
        i, j, (_, s2, lapse, weight, v, w, cx, cy) = row[:3], row[3:6], row[6:]
        di, dj = np.linalg.norm(p - i), np.linalg.norm(p - j)
        turn = (p - i)[:2] / di - (p - j)[:2] / dj
        s = np.sqrt(s2 + (v + w * ((x - cx) ** 2 + (y - cy) ** 2)) * (turn @ turn))
        total += weight * np.log(lapse / 2 + (1 - lapse) / (1 + np.exp(-(dj - di) / s)))
    return total


KINDS = [
    pytest.param(ranges, range_log_likelihood, slow_ranges, id="distances"),
    pytest.param(comparisons, comparison_log_likelihood, slow_comparisons, id="comparisons"),
]
every_kind = pytest.mark.parametrize(("rows_of", "fast", "slow"), KINDS)


@every_kind
def test_the_value_is_that_of_a_slow_sum(rows_of, fast, slow):
    rng = np.random.default_rng(0)
    rows = rows_of(rng)
    for x, y in rng.uniform(-0.8, 0.8, (20, 2)):
        assert fast(rows, x, y, 0.0)[0] == pytest.approx(slow(rows, x, y), abs=1e-6)


@every_kind
@pytest.mark.parametrize("half_m", [0.01, 0.1, 0.5])
def test_the_bound_holds_everywhere_in_the_cell_and_closes_in_on_the_value(rows_of, fast, slow, half_m):
    rng = np.random.default_rng(1)
    rows, exact = rows_of(rng), rows_of(rng, odometry=False)
    for x, y in rng.uniform(-0.8, 0.8, (20, 2)):
        _, bound = fast(rows, x, y, np.sqrt(2.0) * half_m)
        inside = [fast(rows, x + half_m * u, y + half_m * v, 0.0)[0] for u, v in rng.uniform(-1, 1, (40, 2))]
        assert max(inside) <= bound + 1e-9
        value, tight = fast(exact, x, y, 1e-9)
        assert tight == pytest.approx(value, abs=1e-4)


@every_kind
def test_the_cells_hold_the_likelihood_that_a_dense_grid_finds(rows_of, fast, slow):
    rng = np.random.default_rng(2)
    rows = rows_of(rng)
    cells, value, side = tag_cells(rows_of is ranges, rows, BOUNDS_M, LIMITS, 4000)
    step = 0.005
    x, y = (np.arange(low + step / 2, high, step) for low, high in BOUNDS_M)
    dense = np.array([[fast(rows, a, b, 0.0)[0] for b in y] for a in x])
    mass, kept = np.exp(dense - dense.max()), np.exp(value - dense.max())
    assert kept.sum() * side**2 == pytest.approx(mass.sum() * step**2, rel=0.03)
    mean = np.array([(mass.sum(axis=1) @ x), (mass.sum(axis=0) @ y)]) / mass.sum()
    assert kept @ cells / kept.sum() == pytest.approx(mean, abs=0.003)
    assert value.max() >= dense.max() - 0.1


@every_kind
def test_cells_tile_and_do_not_overlap(rows_of, fast, slow):
    cells, _, side = tag_cells(rows_of is ranges, rows_of(np.random.default_rng(3)), BOUNDS_M, LIMITS, 4000)
    steps = (cells - BOUNDS_M[:, 0]) / side - 0.5
    assert steps == pytest.approx(np.round(steps), abs=1e-6)
    assert len(np.unique(np.round(steps), axis=0)) == len(cells)


def test_the_number_of_cells_is_limited():
    rows = ranges(np.random.default_rng(4))
    cells, _, _ = tag_cells(True, rows, BOUNDS_M, np.array([0.32, 1e-6, 12.0, 1e9]), 800)
    assert len(cells) <= 800


def test_weight_on_n_cells_counts_n():
    assert effective_count(np.full(7, -300.0)) == pytest.approx(7.0)
    assert effective_count(np.array([0.0, -800.0])) == pytest.approx(1.0)
