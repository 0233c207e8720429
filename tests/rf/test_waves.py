import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.rf.waves import SPEED_OF_LIGHT_M_S, free_space_channel, wavelength, wavenumber

coordinates = st.floats(-2.0, 2.0)
points = st.tuples(coordinates, coordinates, st.floats(0.3, 2.0)).map(np.array)
PATH_M = np.stack([np.linspace(0, 1, 7), np.zeros(7), np.zeros(7)], axis=1)
FREQUENCIES_HZ = np.array([865.7e6, 915e6])


def test_a_wave_of_the_speed_of_light_in_hertz_is_one_metre_long():
    assert wavelength(SPEED_OF_LIGHT_M_S) == 1.0
    assert wavenumber(SPEED_OF_LIGHT_M_S) == 2 * np.pi


@given(points)
def test_the_phase_lag_is_the_wavenumber_times_the_round_trip(point_m):
    h = free_space_channel(point_m, PATH_M, FREQUENCIES_HZ)
    round_trip_m = 2 * np.linalg.norm(PATH_M - point_m, axis=1)
    expected = np.exp(-2j * np.pi * round_trip_m[:, None] * FREQUENCIES_HZ / SPEED_OF_LIGHT_M_S)
    np.testing.assert_allclose(h / np.abs(h), expected, atol=1e-9)


@given(points)
def test_moving_the_tag_and_the_antennas_together_changes_nothing(point_m):
    shift_m = np.array([0.3, -0.2, 0.1])
    h = free_space_channel(point_m, PATH_M, FREQUENCIES_HZ)
    np.testing.assert_allclose(free_space_channel(point_m + shift_m, PATH_M + shift_m, FREQUENCIES_HZ), h, rtol=1e-9)


@given(points)
def test_a_bistatic_rig_with_both_antennas_in_one_place_is_monostatic(point_m):
    bistatic = free_space_channel(point_m, PATH_M, FREQUENCIES_HZ, tx_positions_m=PATH_M)
    np.testing.assert_allclose(bistatic, free_space_channel(point_m, PATH_M, FREQUENCIES_HZ), rtol=1e-12)


@given(points, points)
def test_sender_and_receiver_may_be_exchanged(point_m, tx_m):
    tx = np.broadcast_to(tx_m + np.array([0.0, 0.0, 3.0]), PATH_M.shape)
    there = free_space_channel(point_m, PATH_M, FREQUENCIES_HZ, tx_positions_m=tx)
    back = free_space_channel(point_m, tx, FREQUENCIES_HZ, tx_positions_m=PATH_M)
    np.testing.assert_allclose(there, back, rtol=1e-12)


def test_twice_the_distance_costs_a_quarter_of_the_monostatic_amplitude():
    near = free_space_channel(np.array([0.0, 1.0, 0.0]), np.zeros((1, 3)), FREQUENCIES_HZ)
    far = free_space_channel(np.array([0.0, 2.0, 0.0]), np.zeros((1, 3)), FREQUENCIES_HZ)
    np.testing.assert_allclose(np.abs(far), np.abs(near) / 4)


@pytest.mark.parametrize("distance_m", [0.5, 4.0])
def test_without_spreading_the_amplitude_is_one(distance_m):
    h = free_space_channel(np.array([0.0, distance_m, 0.0]), PATH_M, FREQUENCIES_HZ, spreading=False)
    np.testing.assert_allclose(np.abs(h), 1.0)
