import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.geometry import angle_difference, circular_mean, wrap_to_pi

angles = st.floats(-50, 50)


@given(angles)
def test_wrapping_keeps_the_direction(angle):
    wrapped = float(wrap_to_pi(angle))
    assert -np.pi <= wrapped < np.pi
    assert np.isclose(np.exp(1j * wrapped), np.exp(1j * angle), atol=1e-9)


@given(angles, angles, st.integers(-3, 3))
def test_a_difference_ignores_whole_periods(a, b, turns):
    for period in (np.pi, 2 * np.pi):
        shifted = angle_difference(a + turns * period, b, period) - angle_difference(a, b, period)
        assert min(abs(shifted), abs(abs(shifted) - period)) < 1e-9


@given(st.lists(st.floats(-1, 1), min_size=1, max_size=5), angles)
def test_the_mean_direction_turns_with_the_angles(spread, turn):
    shift = angle_difference(circular_mean(np.array(spread) + turn), circular_mean(spread) + turn)
    assert abs(shift) < 1e-9


def test_directions_that_cancel_have_no_mean():
    assert np.isnan(circular_mean([0.0, np.pi]))
    assert np.isnan(circular_mean([]))
