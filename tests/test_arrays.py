import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from rfcompass.arrays import read_only
from rfcompass.errors import ShapeError


def test_a_record_array_cannot_be_written_to():
    frozen = read_only([1.0, 2.0], "x", (2,))
    with pytest.raises(ValueError, match="read-only"):
        frozen[0] = 3.0


def test_a_record_array_is_a_copy():
    mine = np.zeros(3)
    frozen = read_only(mine, "x", (3,))
    mine[0] = 1.0
    assert frozen[0] == 0.0


@given(hnp.arrays(np.float64, hnp.array_shapes(max_dims=3), elements=st.floats(-1e6, 1e6)))
def test_values_survive_unchanged(values):
    assert np.array_equal(read_only(values, "x", (None,) * values.ndim), values)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_refused_unless_allowed(bad):
    with pytest.raises(ShapeError, match="1 of 2 values are not finite"):
        read_only([0.0, bad], "x", (2,))
    assert len(read_only([0.0, bad], "x", (2,), finite=False)) == 2


@pytest.mark.parametrize(("value", "shape"), [([1.0], (2,)), ([[1.0]], (1,)), (1.0, (1,)), ([[1, 2]], (None, 3))])
def test_a_wrong_shape_is_named(value, shape):
    with pytest.raises(ShapeError, match="antenna: expected shape"):
        read_only(value, "antenna", shape)


@pytest.mark.parametrize("value", [[1.5], ["a"], [None], [[1], [1, 2]]])
def test_a_lossy_cast_to_integers_is_refused(value):
    with pytest.raises(ShapeError):
        read_only(value, "index", (None,), np.int64)
