"""The climb ends at the top of a lobe, or at the border below it."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.rf.image_slopes import Slopes, climb_to_top
from rfcompass.types.volumes import SearchVolume

BOX = SearchVolume([-1.0, -1.0, 0.3], [1.0, 1.0, 0.3])
WIDTHS_M = np.array([0.05, 0.3, 1.0])
inside = st.floats(-0.9, 0.9)


def hill(top_m):
    """Logarithm of a Lorentzian hill: not a parabola, and curved the other way far from its top."""

    def at(point_m):
        u = (point_m - top_m) / WIDTHS_M
        size = 1.0 + u @ u
        slope = -2.0 * u / WIDTHS_M / size
        bend = -2.0 * np.diag(1.0 / WIDTHS_M**2) / size + np.outer(slope, slope)
        return Slopes(-float(np.log(size)), slope, bend)

    return at


@given(x=inside, y=inside, dx=st.floats(-0.09, 0.09), dy=st.floats(-0.09, 0.09))
def test_it_finds_the_top_to_the_last_bit(x, y, dx, dy):
    top_m = np.array([x, y, 0.3])
    found = climb_to_top(hill(top_m), BOX, top_m + np.array([dx, dy, 0.0]), 0.3)
    np.testing.assert_allclose(found, top_m, atol=1e-9)


@given(x=inside, beyond=st.floats(0.01, 0.2))
def test_a_top_beyond_the_border_is_met_at_the_border(x, beyond):
    found = climb_to_top(hill(np.array([x, 1.0 + beyond, 0.3])), BOX, np.array([x, 0.9, 0.3]), 0.3)
    np.testing.assert_allclose(found, [x, 1.0, 0.3], atol=1e-9)


def test_a_height_that_is_known_is_kept():
    found = climb_to_top(hill(np.array([0.1, 0.2, 0.8])), BOX, np.array([0.12, 0.1, 0.3]), 0.3)
    assert found[2] == 0.3


def test_where_nothing_is_known_it_stays():
    def flat(_):
        return Slopes(0.0, np.zeros(3), np.zeros((3, 3)))

    assert climb_to_top(flat, BOX, np.array([0.1, 0.2, 0.3]), 0.3).tolist() == [0.1, 0.2, 0.3]
