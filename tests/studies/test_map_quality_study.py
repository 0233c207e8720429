"""The study of maps: all of them are judged, exact tags and uniform maps give what they must."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from rfcompass.simulation.piles import PileFamily, make_pile
from rfcompass.studies import map_quality
from rfcompass.studies.map_quality import GAINS, MAP_QUALITY, NAMES
from rfcompass.studies.pile_scan import workspace
from rfcompass.studies.trial import run_trial

TINY = PileFamily("tiny", "covered", (6,))


@pytest.fixture(scope="module")
def judged():
    scene = make_pile(TINY, 1, "hidden")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(map_quality, "pile_scene", lambda family, seed: scene)
        record = run_trial(MAP_QUALITY.name, MAP_QUALITY.trial, MAP_QUALITY.metrics, MAP_QUALITY.cells[0], 1)
    assert record.failure is None, record.failure
    return record.metrics


def test_every_map_has_bits_and_a_rank_or_neither(judged):
    for name in NAMES:
        bits, rank = judged[f"bits_{name}"], judged[f"rank_{name}"]
        assert (bits is None) == (rank is None)
        if bits is not None:
            assert bits > 0
            assert 0 <= rank <= 1


def test_a_uniform_map_knows_nothing(judged):
    assert judged["bits_uniform"] == pytest.approx(np.log2(np.prod(workspace().shape)))
    assert judged["rank_uniform"] == judged["rank_c"] == pytest.approx(0.5)


def test_what_cameras_see_is_worth_bits(judged):
    assert judged["bits_c"] < judged["bits_uniform"] - 3
    assert judged["bits_posterior_0"] < judged["bits_uniform"] - 3


def test_gains_are_differences_of_bits(judged):
    for name, without in GAINS.items():
        if judged[f"bits_{name}"] is None:
            assert judged[f"gain_{name}"] is None
        else:
            expected = judged[f"bits_{without}"] - judged[f"bits_{name}"]
            assert judged[f"gain_{name}"] == pytest.approx(expected)


def test_seeds_of_the_report_are_not_those_of_tuning():
    assert not set(MAP_QUALITY.seeds) & set(MAP_QUALITY.tuning_seeds)
    assert min(MAP_QUALITY.seeds) >= 1000
