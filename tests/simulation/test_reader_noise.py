"""A reader's noise is as large as it says, phases lie in their circle, and seeds compare across models."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError
from rfcompass.simulation import NOISES, NoiseModel
from rfcompass.simulation.reader_noise import NOISE_NONE

ONES = np.ones(100_000, dtype=np.complex128)


def heard(model, h=ONES, seed=0):
    return model.heard(h, np.random.default_rng(seed))


def test_a_reader_without_noise_hears_the_channel():
    h = np.array([[1e-3 + 2e-3j, -4e-5j]])
    assert np.array_equal(heard(NOISE_NONE, h), h)


@given(phase_rad=st.floats(0.01, 0.4))
def test_phase_noise_spreads_the_phase_and_keeps_the_size(phase_rad):
    h = heard(NoiseModel(phase_rad=phase_rad))
    assert np.angle(h).std() == pytest.approx(phase_rad, rel=0.02)
    np.testing.assert_allclose(np.abs(h), 1.0)


@given(floor_dbm=st.floats(-100.0, -40.0))
def test_thermal_noise_has_the_power_it_says(floor_dbm):
    noise = heard(NoiseModel(thermal_dbm=floor_dbm), 0.0 * ONES)
    assert 10 * np.log10((np.abs(noise) ** 2).mean()) == pytest.approx(floor_dbm, abs=0.05)


def test_two_equal_noises_are_three_decibels_louder_than_one():
    one = NoiseModel(thermal_dbm=-90.0)
    assert replace(one, self_jammer_dbm=-90.0).floor_dbm == pytest.approx(-90.0 + 10 * np.log10(2))
    assert NOISE_NONE.floor_dbm == -np.inf


def test_what_is_decoded_lies_above_the_floor_by_the_ratio():
    assert NoiseModel(thermal_dbm=-95.0, decode_snr_db=10.0).sensitivity_dbm == pytest.approx(-85.0)
    assert NoiseModel(thermal_dbm=-95.0).sensitivity_dbm == -np.inf


@pytest.mark.parametrize("share", [0.05, 0.5])
def test_half_turns_and_outliers_come_as_often_as_they_say(share):
    flipped = heard(NoiseModel(flip_probability=share)).real < 0
    assert flipped.mean() == pytest.approx(share, abs=5 * np.sqrt(share / len(ONES)))
    astray = np.abs(np.angle(heard(NoiseModel(outlier_probability=share)))) > 1e-9
    assert astray.mean() == pytest.approx(share, abs=5 * np.sqrt(share / len(ONES)))


@given(angle_rad=st.floats(-10.0, 10.0), step_rad=st.sampled_from([0.0, 2 * np.pi / 4096, 0.1]))
def test_reported_phases_lie_in_the_circle_and_within_half_a_step_of_the_truth(angle_rad, step_rad):
    model = NoiseModel(phase_step_rad=step_rad)
    raw = float(model.reported_phase_rad(np.array([np.exp(1j * angle_rad)]))[0])
    assert 0.0 <= raw < 2 * np.pi
    off = np.angle(np.exp(1j * (raw + angle_rad)))  # the raw phase grows with distance, arg h falls
    assert abs(off) <= step_rad / 2 + 1e-9 or (step_rad == 0.1 and raw == 0.0)  # 2π is no whole number of 0.1


@given(dbm=st.floats(-90.0, 0.0), step_db=st.sampled_from([0.0, 0.01, 0.5]))
def test_reported_power_lies_within_half_a_step_of_the_truth(dbm, step_db):
    said = float(NoiseModel(rssi_step_db=step_db).reported_rssi_dbm(np.array([10 ** (dbm / 20) + 0j]))[0])
    assert abs(said - dbm) <= step_db / 2 + 1e-9


def test_seeds_compare_across_models():
    """The same draws stand behind every model: twice the noise is the same noise, twice."""
    one, other = heard(NoiseModel(phase_rad=0.1)), heard(NoiseModel(phase_rad=0.2))
    np.testing.assert_allclose(np.angle(other), 2 * np.angle(one), atol=1e-12)


def test_presets_get_worse_in_their_order():
    spread = [np.angle(heard(NOISES[name], 1e-2 * ONES)).std() for name in ("none", "usrp", "r420", "bad")]
    assert spread == sorted(spread)


@pytest.mark.parametrize(
    "wrong",
    [{"phase_rad": -0.1}, {"flip_probability": 1.5}, {"thermal_dbm": np.nan}, {"rssi_step_db": np.inf}],
)
def test_noise_that_cannot_be_is_refused(wrong):
    with pytest.raises(InputError):
        NoiseModel(**wrong)
