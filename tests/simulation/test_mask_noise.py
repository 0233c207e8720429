"""Errors of segmentation: each at its chance, and none where none is asked for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError
from rfcompass.simulation import MaskNoise
from rfcompass.types import InstanceMasks

TILES = InstanceMasks(np.kron(np.arange(1, 13).reshape(3, 4), np.ones((8, 8), np.int64)))
ISLANDS = InstanceMasks(
    np.where(
        (np.indices((60, 60)) % 20 < 8).all(axis=0),
        np.kron(np.arange(1, 10).reshape(3, 3), np.ones((20, 20), np.int64)),
        0,
    )
)


@given(st.integers(0, 10**6))
def test_no_noise_changes_nothing(seed):
    assert np.array_equal(MaskNoise(0, 0, 0).apply(TILES, np.random.default_rng(seed)).labels, TILES.labels)


@given(st.integers(0, 10**6), st.floats(0, 1), st.floats(0, 1), st.floats(0, 1))
def test_background_never_becomes_an_object(seed, merge, split, drop):
    noisy = MaskNoise(merge, split, drop).apply(ISLANDS, np.random.default_rng(seed))
    assert not noisy.labels[ISLANDS.labels == 0].any()


@given(st.integers(0, 10**6))
def test_certain_errors_happen(seed):
    rng = np.random.default_rng(seed)
    assert MaskNoise(0, 0, 1).apply(TILES, rng).count == 0
    assert MaskNoise(0, 1, 0).apply(TILES, rng).count == 24
    assert MaskNoise(1, 0, 0).apply(TILES, rng).count < 7
    assert MaskNoise(1, 0, 0).apply(ISLANDS, rng).count == 9  # nobody has a neighbour


def test_errors_come_as_often_as_told():
    rng = np.random.default_rng(5)
    noises = {"drop": MaskNoise(0.0, 0.0, 0.12), "split": MaskNoise(0.0, 0.08, 0.0)}
    counts = {name: np.mean([noise.apply(ISLANDS, rng).count for _ in range(400)]) for name, noise in noises.items()}
    assert counts["drop"] == pytest.approx(9 * 0.88, abs=0.2)
    assert counts["split"] == pytest.approx(9 * 1.08, abs=0.2)


def test_equal_generators_make_equal_errors():
    one, other = (MaskNoise().apply(TILES, np.random.default_rng(7)).labels for _ in range(2))
    assert np.array_equal(one, other)


def test_what_is_no_chance_is_refused():
    for name in ("merge", "split", "drop"):
        for wrong in (-0.1, 1.1, float("nan")):
            with pytest.raises(InputError, match=name):
                MaskNoise(**{name: wrong})
