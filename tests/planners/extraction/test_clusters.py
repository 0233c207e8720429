"""Where to look: parts of a map that hang together."""

import numpy as np
import pytest

from planners.extraction import best_cluster, clusters_of
from rfcompass.errors import InputError, NothingHidden, ShapeError
from rfcompass.types import VoxelGrid


def grid_of(values):
    return VoxelGrid(np.array([1.0, 2.0, 0.005]), 0.01, values)


def two_piles():
    """A small likely one of 4 columns, a wide one of 64 that is half as likely."""
    values = np.zeros((20, 20, 5))
    values[2:4, 2:4, 1:3] = 1.0
    values[10:18, 10:18, 0] = 1.0
    return grid_of(values)


def heaviest(grid):
    return max(clusters_of(grid), key=lambda cluster: cluster.mass)


def test_the_likeliest_cluster_is_not_the_heaviest():
    best, wide = best_cluster(two_piles()), heaviest(two_piles())
    assert best.columns.sum() == 4
    assert best.mean == 2.0
    assert wide.columns.sum() == 64
    assert wide.mass == 64.0


def test_the_point_is_above_the_middle_at_the_top():
    assert np.allclose(best_cluster(two_piles()).point_m, [1.025, 2.025, 0.03])
    assert np.allclose(heaviest(two_piles()).point_m, [1.135, 2.135, 0.01])


def test_what_is_below_the_threshold_neither_counts_nor_joins_clusters():
    grid = two_piles()
    values = grid.values.copy()
    values[3:11, 3, 0] = 0.1
    assert best_cluster(grid_of(values)).columns.sum() == 4
    assert len(clusters_of(grid_of(values))) == 2
    assert len(clusters_of(grid_of(values + 1e-3), 0.0)) == 1


def test_clusters_touch_also_at_corners():
    values = np.zeros((4, 4, 1))
    values[0, 0], values[1, 1], values[3, 3] = 1.0, 1.0, 1.0
    assert [int(cluster.columns.sum()) for cluster in clusters_of(grid_of(values))] == [2, 1]


def test_an_empty_map_and_a_wrong_threshold_are_named():
    with pytest.raises(NothingHidden):
        best_cluster(grid_of(np.zeros((3, 3, 2))))
    with pytest.raises(InputError):
        best_cluster(two_piles(), 1.0)
    for shape in ((0, 0, 0), (3, 3, 0)):
        with pytest.raises(ShapeError, match="no voxel"):
            grid_of(np.zeros(shape))
