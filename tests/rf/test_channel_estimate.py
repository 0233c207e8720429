"""The channel that was put into the samples comes out, with its noise."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.errors import InputError, ShapeError
from rfcompass.rf import free_space_channel
from rfcompass.rf.channel_estimate import estimate_channel

seeds = st.integers(0, 2**31)


def answer(rng, samples=256):
    """A tag that is on or off at random, as FM0 is."""
    return rng.integers(0, 2, samples).astype(float)


def noise(rng, shape, power):
    return np.sqrt(power / 2) * (rng.normal(size=shape) + 1j * rng.normal(size=shape))


@given(seed=seeds)
def test_without_noise_the_channel_of_every_frequency_and_pose_is_exact(seed):
    rng = np.random.default_rng(seed)
    poses_m, f_hz = rng.uniform(0, 1, (5, 3)), np.array([900e6, 910e6, 920e6])
    h = free_space_channel(np.array([0.5, 2.0, 0.0]), poses_m, f_hz)
    x = np.r_[1.0, answer(rng)]
    found = estimate_channel(h[..., None] * x, x)
    np.testing.assert_allclose(found.channel, h, rtol=1e-12)
    np.testing.assert_allclose(found.noise_power, 0.0, atol=1e-24)


def test_one_estimate_is_the_sum_of_a_plain_loop():
    rng = np.random.default_rng(3)
    x, y = noise(rng, 50, 1.0), noise(rng, 50, 1.0)
    correlation = sum(y_t * x_t.conjugate() for y_t, x_t in zip(y, x, strict=True))
    energy = sum(abs(x_t) ** 2 for x_t in x)
    assert estimate_channel(y, x).channel == pytest.approx(correlation / energy)
    assert estimate_channel(y, x, normalised=False).channel == pytest.approx(correlation)


def test_noise_power_and_standard_error_are_those_of_the_noise():
    """4000 channels of 64 samples: the mean of σ² is good to 0.3 %, the scatter of h to 1.2 %."""
    rng = np.random.default_rng(4)
    x, h, power = answer(rng, 64), 0.3 - 0.2j, 0.04
    found = estimate_channel(h * x + noise(rng, (4000, 64), power), x)
    assert found.noise_power.mean() == pytest.approx(power, rel=0.02)
    scatter = np.sqrt((np.abs(found.channel - h) ** 2).mean())
    assert scatter == pytest.approx(np.sqrt(power / x.sum()), rel=0.05)
    assert found.standard_error.mean() == pytest.approx(scatter, rel=0.05)
    assert abs(found.channel.mean() - h) < 4 * scatter / np.sqrt(4000)


@given(seed=seeds, carrier=st.complex_numbers(max_magnitude=100.0))
@settings(max_examples=20)
def test_the_readers_own_carrier_drops_out_if_asked(seed, carrier):
    rng = np.random.default_rng(seed)
    x, h = np.r_[0.0, 1.0, answer(rng)], 0.01 + 0.02j
    assert estimate_channel(h * x + carrier, x, offset=True).channel == pytest.approx(h, rel=1e-9, abs=1e-11)


def test_a_carrier_spoils_the_plain_estimate():
    x = np.tile([0.0, 1.0], 20)
    assert estimate_channel(0.01 * x + 1.0, x).channel == pytest.approx(1.01)


@given(seed=seeds, repeats=st.integers(2, 5))
@settings(max_examples=20)
def test_listening_longer_changes_the_printed_sum_but_not_the_channel(seed, repeats):
    rng = np.random.default_rng(seed)
    x = np.r_[1.0, answer(rng)]
    y = 0.5j * x
    longer = np.tile(y, repeats), np.tile(x, repeats)
    assert estimate_channel(*longer).channel == pytest.approx(estimate_channel(y, x).channel)
    printed = estimate_channel(y, x, normalised=False).channel
    assert estimate_channel(*longer, normalised=False).channel == pytest.approx(repeats * printed)


def test_each_element_of_a_batch_may_have_its_own_signal():
    rng = np.random.default_rng(5)
    x = noise(rng, (2, 3, 40), 1.0)
    h = noise(rng, (2, 3), 1.0)
    np.testing.assert_allclose(estimate_channel(h[..., None] * x, x).channel, h)


def test_signals_that_carry_nothing_are_refused():
    with pytest.raises(InputError, match="silent"):
        estimate_channel(np.ones(8), np.zeros(8))
    with pytest.raises(InputError, match="do not change") as caught:
        estimate_channel(np.ones((2, 8)), np.array([np.arange(8.0), np.full(8, 0.3)]), offset=True)
    assert caught.value.numbers["first"] == [1]
    with pytest.raises(InputError, match="samples"):
        estimate_channel([1.0], [1.0])
    with pytest.raises(InputError, match="samples"):
        estimate_channel([1.0, 2.0], [1.0, 0.0], offset=True)


def test_shapes_and_values_are_checked():
    with pytest.raises(ShapeError, match="fit"):
        estimate_channel(np.ones((2, 8)), np.ones(7))
    with pytest.raises(ShapeError, match="finite"):
        estimate_channel([1.0, np.nan, 1.0], np.ones(3))
    with pytest.raises(ShapeError, match="no signal"):
        estimate_channel(1.0, 1.0)
