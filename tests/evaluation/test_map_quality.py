"""Bits and ranks of a map: what is known of simple maps, and what scale and floor may do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import ShapeError
from rfcompass.evaluation.map_quality import map_quality
from rfcompass.types import VoxelGrid

SHAPE = (4, 4, 4)
ALL = np.ones(SHAPE, dtype=bool)
TRUE_M = np.array([0.11, 0.2, 0.3])  # voxel 1, 2, 3


def grid(values):
    return VoxelGrid(np.zeros(3), 0.1, values)


def test_an_even_map_takes_as_many_bits_as_its_voxels_need():
    quality = map_quality(grid(np.ones(SHAPE)), TRUE_M, ALL)
    assert quality.bits == pytest.approx(6.0)
    assert quality.rank == pytest.approx(0.5)


def test_a_sure_map_is_best_where_it_is_right_and_costs_the_floor_where_it_is_wrong():
    sure = np.zeros(SHAPE)
    sure[1, 2, 3] = 7.0
    right, wrong = (map_quality(grid(np.roll(sure, k, axis=0)), TRUE_M, ALL, floor=0.01) for k in (0, 1))
    assert right.bits == pytest.approx(-np.log2(0.99 + 0.01 / 64))
    assert wrong.bits == pytest.approx(np.log2(64 / 0.01))
    assert right.rank == pytest.approx(1 / 128)
    assert wrong.rank == pytest.approx((1 + 63 / 2) / 64)


@given(st.integers(0, 1000), st.floats(0.01, 100.0))
def test_the_scale_of_a_map_means_nothing(seed, scale):
    values = np.random.default_rng(seed).random(SHAPE)
    one, other = map_quality(grid(values), TRUE_M, ALL), map_quality(grid(scale * values), TRUE_M, ALL)
    assert (one.bits, one.rank) == (pytest.approx(other.bits), other.rank)


def test_a_map_with_nothing_left_is_an_even_one():
    assert map_quality(grid(-np.ones(SHAPE)), TRUE_M, ALL).bits == pytest.approx(6.0)


def test_ranks_are_counted_over_the_voxels_in_question_and_the_true_one():
    values = np.arange(64.0).reshape(SHAPE)
    none = map_quality(grid(values), TRUE_M, np.zeros(SHAPE, dtype=bool))
    assert none.rank == pytest.approx(0.5)


def test_what_does_not_fit_is_refused():
    with pytest.raises(ShapeError, match="outside"):
        map_quality(grid(np.ones(SHAPE)), np.array([0.0, 0.0, 1.0]), ALL)
    with pytest.raises(ShapeError, match="among"):
        map_quality(grid(np.ones(SHAPE)), TRUE_M, np.ones((4, 4, 5), dtype=bool))
