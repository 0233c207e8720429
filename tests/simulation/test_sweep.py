import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import ShapeError
from rfcompass.rf.waves import SPEED_OF_LIGHT_M_S
from rfcompass.simulation import SweepScene, simulate_sweep

RAIL = np.column_stack([np.linspace(0, 1, 40), np.zeros(40), np.zeros(40)])


def scene(**changes):
    fields = {
        "tags_m": {"a": np.array([0.4, 0.7, 0.0]), "b": np.array([0.6, 0.7, 0.0])},
        "antenna_positions_m": RAIL,
        "frequencies_hz": np.array([920e6, 924e6]),
        "reflection": 0.0,
        "phase_noise_rad": 0.0,
        "read_probability": 1.0,
    }
    return SweepScene(**{**fields, **changes})


def phases(reads, epc, frequency_hz):
    return np.unwrap([read.phase_rad for read in reads if read.epc == epc and read.freq_hz == frequency_hz])


def test_every_tag_answers_everywhere_if_nothing_is_missed():
    reads = simulate_sweep(scene(), np.random.default_rng(0))
    assert len(reads) == 40 * 2 * 2
    assert {read.epc for read in reads} == {"a", "b"}


def test_without_walls_the_phase_grows_by_4_pi_over_lambda_for_each_metre():
    reads = simulate_sweep(scene(), np.random.default_rng(0))
    distance_m = np.linalg.norm(RAIL - [0.4, 0.7, 0.0], axis=1)
    expected = 4 * np.pi * 920e6 / SPEED_OF_LIGHT_M_S * (distance_m - distance_m[0])
    measured = phases(reads, "a", 920e6)
    assert np.allclose(measured - measured[0], expected, atol=1e-9)


def test_without_walls_the_power_falls_with_the_fourth_power_of_distance():
    reads = [read for read in simulate_sweep(scene(), np.random.default_rng(0)) if read.epc == "a"]
    one = np.array([read.rssi_dbm for read in reads if read.freq_hz == 920e6])
    distance_m = np.linalg.norm(RAIL - [0.4, 0.7, 0.0], axis=1)
    assert np.allclose(one + 40 * np.log10(distance_m), one[0] + 40 * np.log10(distance_m[0]))


def test_a_wall_changes_what_is_heard():
    free = simulate_sweep(scene(), np.random.default_rng(0))
    walled = simulate_sweep(scene(reflection=-0.5), np.random.default_rng(0))
    assert np.std([a.phase_rad - b.phase_rad for a, b in zip(free, walled, strict=True)]) > 0.01


@given(st.integers(0, 1000))
def test_the_same_seed_hears_the_same(seed):
    world = scene(phase_noise_rad=0.2, read_probability=0.7)
    heard = [simulate_sweep(world, np.random.default_rng(seed)) for _ in range(2)]
    assert heard[0] == heard[1]


def test_a_scene_is_finite():
    with pytest.raises(ShapeError):
        scene(tags_m={"a": np.array([np.nan, 0, 0])})
