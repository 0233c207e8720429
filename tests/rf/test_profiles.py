import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError, UnsuitablePath
from rfcompass.rf.profiles import AngularProfile

FAR_M = 60.0
angles = st.floats(0.5, np.pi - 0.5)


def far_point(angle_rad, middle_m=0.5):
    return np.array([middle_m + FAR_M * np.cos(angle_rad), FAR_M * np.sin(angle_rad), 0.0])


def peak_rad(settings, trace):
    return settings.angles_rad()[np.argmax(settings.of(trace)[0])]


@given(angles)
def test_a_far_tag_appears_under_its_angle_to_the_path(make_trace, angle_rad):
    settings_ = AngularProfile(angles=721)
    assert peak_rad(settings_, make_trace(far_point(angle_rad))) == pytest.approx(angle_rad, abs=0.01)


@given(angles)
def test_with_a_fixed_transmitter_the_angle_is_the_same(make_trace, line, angle_rad):
    tx_m = np.broadcast_to([0.2, -3.0, 0.0], (51, 3))
    trace = make_trace(far_point(angle_rad), line(), tx_m=tx_m)
    assert peak_rad(AngularProfile(angles=721), trace) == pytest.approx(angle_rad, abs=0.02)


@given(angles)
def test_a_half_turn_ambiguity_leaves_the_peak_in_place(make_trace, line, angle_rad):
    trace = make_trace(far_point(angle_rad), line(1.0, 101), half_turns=True)
    assert peak_rad(AngularProfile(angles=721), trace) == pytest.approx(angle_rad, abs=0.01)


def test_the_reversed_path_sees_the_mirrored_profile(make_trace, line):
    settings_ = AngularProfile(sub_apertures=2)
    there = settings_.of(make_trace([0.2, 0.6, 0.0], line(1.0, 50)))
    back = settings_.of(make_trace([0.2, 0.6, 0.0], line(1.0, 50)[::-1].copy()))
    np.testing.assert_allclose(back, there[::-1, ::-1], rtol=1e-6)


@given(st.floats(0.2, 0.8), st.integers(0, 2**31))
def test_phase_constants_and_loudness_drop_out(make_trace, x_m, seed):
    settings_ = AngularProfile()
    one = settings_.of(make_trace([x_m, 0.6, 0.0], seed=0))
    np.testing.assert_allclose(settings_.of(make_trace([x_m, 0.6, 0.0], seed=seed)), one, rtol=1e-9)


def test_uneven_spacing_and_missing_cells_leave_the_peak_in_place(make_trace):
    rng = np.random.default_rng(1)
    places_m = np.sort(rng.uniform(0.0, 1.0, 60))
    path = np.stack([places_m, np.zeros(60), np.zeros(60)], axis=1)
    trace = make_trace(far_point(1.1), path, heard=rng.random((60, 3)) < 0.6)
    assert peak_rad(AngularProfile(angles=721), trace) == pytest.approx(1.1, abs=0.02)


def test_the_peak_of_a_far_tag_holds_the_coherent_sum(make_trace):
    profile = AngularProfile(angles=2881, scale="none", phase_only=True).of(make_trace(far_point(1.2)))
    assert profile.max() == pytest.approx(3 * 51**2, rel=0.02)


def test_a_hann_window_lowers_the_side_lobes(make_trace):
    def far_from_peak(window):
        settings_ = AngularProfile(window=window, scale="peak")
        return settings_.of(make_trace(far_point(np.pi / 2)))[0][:60].max()

    assert far_from_peak("hann") < 0.1 * far_from_peak("none")


@pytest.mark.parametrize(("scale", "statistic"), [("mean", np.mean), ("peak", np.max)])
def test_scaled_profiles_have_mean_or_peak_one(make_trace, scale, statistic):
    profiles = AngularProfile(scale=scale, sub_apertures=3).of(make_trace([0.4, 0.5, 0.0]))
    np.testing.assert_allclose(statistic(profiles, axis=1), 1.0)


def test_amplitude_is_the_root_of_power(make_trace):
    trace = make_trace([0.4, 0.5, 0.0])
    power = AngularProfile(scale="none").of(trace)
    np.testing.assert_allclose(AngularProfile(scale="none", quantity="amplitude").of(trace) ** 2, power)


def test_phase_only_forgets_how_loud_each_cell_was(make_trace):
    trace = make_trace([0.1, 0.3, 0.0])
    assert not np.allclose(AngularProfile().of(trace), AngularProfile(phase_only=True).of(trace), rtol=0.05)


def test_a_sub_aperture_without_reads_has_no_profile(make_trace):
    heard = np.ones((51, 3), dtype=bool)
    heard[20:31] = False
    profiles = AngularProfile(sub_apertures=5).of(make_trace([0.5, 0.6, 0.0], heard=heard))
    assert np.isnan(profiles).all(axis=1).tolist() == [False, False, True, False, False]


def test_each_port_has_a_profile_of_its_own(make_trace, line):
    trace = make_trace([0.5, 0.6, 0.0], line(), ports=np.tile([1, 2], 26)[:51])
    assert AngularProfile(sub_apertures=2, angles=91).of(trace).shape == (4, 91)


def test_a_bent_path_has_no_angular_profile(make_trace, line):
    bent = line()
    bent[:, 1] = 0.2 * np.sin(np.pi * bent[:, 0])
    with pytest.raises(UnsuitablePath):
        AngularProfile().of(make_trace([0.5, 0.9, 0.0], bent))


@pytest.mark.parametrize(
    "wrong", [{"angles": 1}, {"sub_apertures": 0}, {"window": "flat"}, {"quantity": "dB"}, {"scale": "sum"}]
)
def test_parameters_out_of_range_are_refused(make_trace, wrong):
    with pytest.raises(InputError, match="profile"):
        AngularProfile(**wrong).of(make_trace([0.5, 0.6, 0.0]))
