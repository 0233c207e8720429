"""Cells of half-planes: against all crossings looked at one by one, and where borders fall together."""

from itertools import product

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.localization.arrangement import deepest_cells

BOUNDS_M = np.array([[-1.0, 1.0], [-1.0, 1.0]])


def random_half_planes(rng, count):
    phi = rng.uniform(-np.pi, np.pi, count)
    return np.column_stack([np.cos(phi), np.sin(phi)]), rng.uniform(-0.7, 0.7, count)


def beside_all_crossings(normals, beta_m, step_m=1e-7):
    """Slow reference: the sets met at the four sides of each crossing of two borders, edges of the bounds included.

    Every cell inside the bounds has such a corner, and it is met unless the cell is thinner than the step.
    """
    edges = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    N, r = np.vstack([normals, edges]), np.concatenate([beta_m, np.ones(4)])
    sets = set()
    for i, j in product(range(len(N)), repeat=2):
        if i < j and abs(np.linalg.det(N[[i, j]])) > 1e-9:
            for side in product((-step_m, step_m), repeat=2):
                point = np.linalg.solve(N[[i, j]], r[[i, j]] + side)
                if np.abs(point).max() <= 1.0:
                    sets.add(tuple(normals @ point <= beta_m))
    most = max(map(sum, sets))
    return most, {one for one in sets if sum(one) == most}


def as_sets(cells):
    return {tuple(one) for one in cells.sets.tolist()}


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 14))
def test_the_deepest_cells_are_those_beside_all_crossings(seed, count):
    normals, beta_m = random_half_planes(np.random.default_rng(seed), count)
    cells = deepest_cells(normals, beta_m, BOUNDS_M)
    most, sets = beside_all_crossings(normals, beta_m)
    assert cells.met == most
    assert as_sets(cells) == sets
    assert cells.complete


def test_the_sets_do_not_depend_on_the_frame():
    rng = np.random.default_rng(3)
    for _ in range(20):
        normals, beta_m = random_half_planes(rng, 40)
        R, shift = np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([3.0, -2.0])  # a quarter turn keeps the square
        turned = deepest_cells(normals @ R.T, beta_m + normals @ R.T @ shift, BOUNDS_M + shift[:, None])
        assert as_sets(turned) == as_sets(deepest_cells(normals, beta_m, BOUNDS_M))


def test_a_half_plane_and_its_opposite_never_hold_together():
    """On their common border both would; it has no area."""
    normals, beta_m = random_half_planes(np.random.default_rng(1), 10)
    both = deepest_cells(np.vstack([normals, -normals]), np.concatenate([beta_m, -beta_m]), BOUNDS_M)
    assert both.met == 10
    assert not (both.sets[:, :10] & both.sets[:, 10:]).any()


def test_the_same_half_plane_twice_counts_twice():
    normals, beta_m = random_half_planes(np.random.default_rng(2), 15)
    once = deepest_cells(normals, beta_m, BOUNDS_M)
    twice = deepest_cells(np.vstack([normals, normals]), np.concatenate([beta_m, beta_m]), BOUNDS_M)
    assert twice.met == 2 * once.met
    assert as_sets(twice) == {one + one for one in as_sets(once)}


def test_half_planes_without_a_border_are_everything_or_nothing():
    normals = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]])
    cells = deepest_cells(normals, np.array([0.1, -0.1, 0.0]), BOUNDS_M)
    assert cells.met == 2
    assert cells.sets.tolist() == [[True, False, True]]


def test_where_no_border_crosses_there_is_one_cell():
    cells = deepest_cells(np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([5.0, -5.0]), BOUNDS_M)
    assert (cells.met, cells.sets.tolist(), cells.complete) == (1, [[True, False]], True)


def test_cells_beyond_the_number_asked_for_are_owned_up_to():
    """Five stripes, in every other one of which a row holds."""
    x = np.array([-0.8, -0.4, 0.0, 0.4, 0.8])
    normals = np.column_stack([np.tile([-1.0, 1.0], 5), np.zeros(10)])
    beta_m = np.column_stack([-(x - 0.1), x + 0.1]).ravel()
    all_cells, few = deepest_cells(normals, beta_m, BOUNDS_M), deepest_cells(normals, beta_m, BOUNDS_M, max_cells=3)
    assert all_cells.met == few.met == 6
    assert (len(all_cells.sets), all_cells.complete) == (5, True)
    assert (len(few.sets), few.complete) == (3, False)


def test_a_cell_of_a_micrometre_is_found():
    """Between two borders one micrometre apart all rows hold; nothing else does better than one less."""
    normals, beta_m = np.array([[1.0, 0.0], [-1.0, 0.0], [0.6, 0.8]]), np.array([0.3 + 1e-6, -0.3, 0.5])
    assert deepest_cells(normals, beta_m, BOUNDS_M).met == 3
