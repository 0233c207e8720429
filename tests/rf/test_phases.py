import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.rf.phases import path_profile, unwrapped_phase
from rfcompass.rf.waves import wavenumber
from rfcompass.types.reads import ReadTrace

tags = st.tuples(st.floats(-0.3, 1.3), st.floats(0.3, 1.5), st.floats(-0.5, 0.5)).map(np.array)


def error_m(trace, point_m, smoothing_m):
    """Largest deviation of the path profile from the true round trip, apart from a constant."""
    gap_m = path_profile(trace, smoothing_m).path_m - trace.round_trip_m(np.atleast_2d(point_m))[0]
    return np.ptp(gap_m)


def with_channel(trace, channel):
    return ReadTrace(
        trace.epc,
        trace.antenna_positions_m,
        trace.frequencies_hz,
        channel,
        trace.read_counts,
        trace.antenna_ports,
        trace.tx_positions_m,
        trace.phase_modulus_rad,
    )


@given(tags, st.integers(0, 1000))
def test_without_smoothing_the_path_profile_is_the_round_trip(make_trace, point_m, seed):
    assert error_m(make_trace(point_m, seed=seed), point_m, 0.0) < 1e-9


@given(tags)
def test_smoothing_costs_a_centimetre_at_most(make_trace, point_m):
    assert error_m(make_trace(point_m), point_m, 0.12) < 0.01


@given(tags)
def test_a_path_around_a_corner_is_followed(make_trace, line, point_m):
    leg = line(0.6, 31)
    corner = np.concatenate([leg, leg[-1] + leg[1:][:, [1, 0, 2]] * [1.0, -1.0, 1.0]])
    beside_m = point_m + np.array([0.0, 0.2, 0.0])
    assert error_m(make_trace(beside_m, corner), beside_m, 0.12) < 0.015


@given(tags)
def test_a_fixed_transmitter_adds_a_constant_only(make_trace, line, point_m):
    tx_m = np.broadcast_to([0.5, -1.0, 0.3], (51, 3))
    trace = make_trace(point_m, line(), tx_m=tx_m)
    assert error_m(trace, point_m, 0.0) < 1e-9


@given(tags, st.integers(0, 1000))
def test_signs_that_mean_nothing_are_ignored(make_trace, line, point_m, seed):
    fine = line(1.0, 101)
    plain = path_profile(make_trace(point_m, fine)).path_m
    np.testing.assert_allclose(
        path_profile(make_trace(point_m, fine, half_turns=True, seed=seed)).path_m, plain, atol=1e-9
    )


def test_a_reader_that_hops_at_every_position_is_followed(make_trace, line):
    heard = np.zeros((101, 3), dtype=bool)
    heard[np.arange(101), np.arange(101) % 3] = True
    point_m = np.array([0.4, 0.6, 0.0])
    assert error_m(make_trace(point_m, line(1.0, 101), heard=heard), point_m, 0.12) < 0.02


def test_two_ports_have_two_constants(make_trace, line):
    ports = np.repeat([1, 2], [26, 25])
    point_m = np.array([0.4, 0.6, 0.0])
    trace = make_trace(point_m, line(), ports=ports)
    gap_m = path_profile(trace, 0.0).path_m - trace.round_trip_m(point_m[None])[0]
    assert max(np.ptp(gap_m[:26]), np.ptp(gap_m[26:])) < 1e-9
    assert abs(gap_m[0] - gap_m[-1]) > 0.01


def test_a_fade_with_random_phases_does_not_slip_a_turn(make_trace):
    point_m = np.array([0.3, 0.6, 0.0])
    trace = make_trace(point_m)
    rng = np.random.default_rng(5)
    channel = trace.channel.copy()
    channel[30:33] *= 1e-3 * np.exp(1j * rng.uniform(0, 2 * np.pi, (3, 3)))
    assert error_m(with_channel(trace, channel), point_m, 0.12) < 0.03


def test_a_gap_longer_than_a_quarter_wavelength_is_bridged_by_the_slope(make_trace):
    point_m = np.array([3.0, 2.0, 0.0])
    heard = np.ones((51, 3), dtype=bool)
    heard[20:32] = False
    trace = make_trace(point_m, heard=heard)
    assert error_m(trace, point_m, 0.12) < 0.02
    phase = unwrapped_phase(trace) / wavenumber(trace.frequencies_hz)
    gap_m = phase - trace.round_trip_m(point_m[None])[0][:, None]
    assert np.ptp(gap_m, axis=0).max() < 0.03


def test_long_paths_are_treated_in_blocks_without_a_trace(make_trace, monkeypatch):
    heard = np.random.default_rng(2).random((51, 3)) < 0.5
    trace = make_trace([0.3, 0.6, 0.0], heard=heard)
    whole = path_profile(trace).path_m
    monkeypatch.setattr("rfcompass.rf.phases.BLOCK", 7)
    np.testing.assert_allclose(path_profile(trace).path_m, whole, rtol=1e-12, atol=1e-15)


def test_a_tag_heard_once_has_no_path(make_trace):
    heard = np.zeros((51, 3), dtype=bool)
    heard[7, 0] = True
    trace = make_trace([0.3, 0.6, 0.0], heard=heard)
    assert np.isnan(path_profile(trace).path_m).all()
    assert np.isnan(unwrapped_phase(trace)).all()


def test_reads_without_amplitude_have_no_path(make_trace):
    trace = make_trace([0.3, 0.6, 0.0])
    assert np.isnan(path_profile(with_channel(trace, np.zeros_like(trace.channel))).path_m).all()


def test_an_antenna_that_stands_still_has_no_path(make_trace):
    assert np.isnan(path_profile(make_trace([0.3, 0.6, 0.0], np.zeros((4, 3)))).path_m).all()


@given(tags, st.integers(0, 1000))
def test_the_unwrapped_phase_is_the_lag_of_each_channel_less_its_median(make_trace, point_m, seed):
    trace = make_trace(point_m, seed=seed)
    lag = np.outer(trace.round_trip_m(point_m[None])[0], wavenumber(trace.frequencies_hz))
    np.testing.assert_allclose(unwrapped_phase(trace), lag - np.median(lag, axis=0), atol=1e-8)


def test_missing_cells_of_the_unwrapped_phase_are_interpolated(make_trace):
    point_m = np.array([0.3, 0.6, 0.0])
    heard = np.random.default_rng(2).random((51, 3)) < 0.7
    trace = make_trace(point_m, heard=heard)
    phase = unwrapped_phase(trace)
    np.testing.assert_allclose(np.median(np.where(heard, phase, np.nan)[heard[:, 0], 0]), 0.0, atol=1e-9)
    assert np.isfinite(phase).all()
    lag = np.outer(trace.round_trip_m(point_m[None])[0], wavenumber(trace.frequencies_hz))
    gap = phase - lag
    assert np.ptp(gap, axis=0).max() < 0.2


def test_a_channel_heard_once_has_no_unwrapped_phase(make_trace):
    heard = np.ones((51, 3), dtype=bool)
    heard[1:, 1] = False
    phase = unwrapped_phase(make_trace([0.3, 0.6, 0.0], heard=heard))
    assert np.isnan(phase).all(axis=0).tolist() == [False, True, False]


@pytest.mark.parametrize("smoothing_m", [0.0, 0.06, 0.12, 0.2])
def test_the_path_profile_has_mean_zero_where_the_tag_was_heard(make_trace, smoothing_m):
    heard = np.random.default_rng(2).random((51, 3)) < 0.3
    profile = path_profile(make_trace([0.3, 0.6, 0.0], heard=heard), smoothing_m)
    assert profile.path_m[profile.heard].mean() == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_array_equal(profile.heard, heard.any(axis=1))
