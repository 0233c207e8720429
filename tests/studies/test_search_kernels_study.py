"""The study of kernels: both are judged on one pile, failed grasps are left out where the paper does."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from simulation.pile_scenes import tiny

from rfcompass.studies import search_kernels, searches
from rfcompass.studies.search_kernels import KERNELS, SEARCH_KERNELS
from rfcompass.studies.searches import LOST, dealt
from rfcompass.studies.trial import run_trial
from rfcompass.types import SearchResult


@pytest.fixture(scope="module")
def judged():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search_kernels, "pile_scene", lambda family, seed: tiny("partly"))
        record = run_trial(
            SEARCH_KERNELS.name, SEARCH_KERNELS.trial, SEARCH_KERNELS.metrics, SEARCH_KERNELS.cells[0], 1
        )
    assert record.failure is None, record.failure
    return record.metrics


def test_what_is_not_found_counts_sixteen_and_failed_grasps_are_left_out(judged):
    for kernel in KERNELS:
        if judged[f"found_{kernel}"]:
            assert [judged[f"all_{kernel}"]] == list(judged[f"actions_{kernel}"])
            assert 1 <= judged[f"all_held_{kernel}"] <= judged[f"all_{kernel}"]
        else:
            assert judged[f"all_{kernel}"] == judged[f"all_held_{kernel}"] == LOST


def test_differences_are_those_of_one_pile(judged):
    for metric in ("all", "all_held"):
        expected = judged[f"{metric}_deformable"] - judged[f"{metric}_spherical"]
        assert judged[f"less_{metric}"] == pytest.approx(expected)


def test_both_kernels_hear_the_same_tags_on_soft_things_alone(judged):
    soft = sum(thing.deformable for thing in tiny("partly").items)
    assert judged["located_deformable"] == judged["located_spherical"] <= soft
    numbers = {thing.number: thing.deformable for thing in tiny("partly").items}
    for arm in KERNELS.values():
        tags = dealt(arm, tiny("partly"), 1).tags
        assert tags
        assert all(numbers[tag.number] for tag in tags)


def test_a_search_that_blows_up_has_no_value_and_says_why(judged, monkeypatch):
    monkeypatch.setattr(search_kernels, "pile_scene", lambda family, seed: tiny("partly"))

    def stopped(arm, scene, tags, seed):
        return SearchResult("arm_stopped", "blew up", (), 1.0, 1.0, 0)

    monkeypatch.setattr(searches, "run_arm", stopped)
    row = SEARCH_KERNELS.trial(SEARCH_KERNELS.cells[0], 1, np.random.default_rng(0))
    assert set(row) == set(judged)
    assert row["ended_spherical"] == "arm_stopped"
    assert row["less_all"] is None


def test_seeds_of_the_report_are_not_those_of_tuning():
    assert not set(SEARCH_KERNELS.seeds) & set(SEARCH_KERNELS.tuning_seeds)
    assert min(SEARCH_KERNELS.seeds) >= 1000
