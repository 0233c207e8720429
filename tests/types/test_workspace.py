"""The box of voxels on the table."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import ShapeError
from rfcompass.types import Workspace

corners = st.tuples(*[st.floats(-2, 2)] * 3).map(np.array)
edges = st.tuples(*[st.floats(0.05, 1.0)] * 3).map(np.array)


@given(corners, edges, st.sampled_from([0.05, 0.02]))
def test_a_workspace_covers_the_box_and_not_a_voxel_more(lower_m, size_m, spacing_m):
    table = Workspace.between(lower_m, lower_m + size_m, spacing_m)
    assert (table.upper_m >= lower_m + size_m - 1e-9).all()
    assert (table.upper_m < lower_m + size_m + spacing_m).all()


@given(corners, edges, st.integers(0, 10**6))
def test_the_centre_of_a_voxel_lies_in_it(lower_m, size_m, seed):
    table = Workspace.between(lower_m, lower_m + size_m, 0.05)
    voxel = np.random.default_rng(seed).integers(0, table.shape)
    point_m = np.array([axis[n] for axis, n in zip(table.axes_m(), voxel, strict=True)])
    assert np.array_equal(table.indices(point_m[None])[0], voxel)
    assert table.contains(point_m[None]).all()
    assert not table.contains(table.upper_m[None] + 1e-6).any()
    assert np.allclose(table.grid(np.zeros(table.shape)).origin_m, table.lower_m + 0.025)


def test_workspaces_that_cannot_be_are_refused():
    with pytest.raises(ShapeError, match="not above"):
        Workspace.between([0, 0, 0], [1, 1, 0])
    for spacing_m in (0.0, -0.01, float("nan"), float("inf")):
        with pytest.raises(ShapeError, match="spacing_m"):
            Workspace([0, 0, 0], (2, 2, 2), spacing_m)
    with pytest.raises(ShapeError, match="spacing_m"):
        Workspace.between([0, 0, 0], [1, 1, 1], 0.0)
    with pytest.raises(ShapeError, match="three counts"):
        Workspace([0, 0, 0], (2, 0, 2), 0.01)
    with pytest.raises(ShapeError, match="refused") as refusal:
        Workspace.between([0, 0, 0], [10, 10, 10], 0.01)
    assert refusal.value.numbers["got"] == 10**9
    with pytest.raises(ShapeError, match="values"):
        Workspace([0, 0, 0], (2, 2, 2), 0.01).grid(np.zeros((2, 2, 3)))
