"""The study of target classes: each cell gets piles of its class, and a target in sight is grasped at once."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from simulation.pile_scenes import tiny

from rfcompass.simulation.piles import TARGET_CLASSES
from rfcompass.studies import searches
from rfcompass.studies.search_classes import BY_CLASS, SEARCH_CLASSES
from rfcompass.studies.search_methods import search_method
from rfcompass.studies.searching import SearchRun, SearchTask, tagged_items_of
from rfcompass.types import SearchResult


@pytest.mark.parametrize("cell", SEARCH_CLASSES.cells, ids=lambda cell: "-".join(cell.values()))
def test_each_cell_is_searched_in_piles_of_its_own_class_and_family(cell, monkeypatch):
    asked = []

    def asks(family, seed, target_class):
        asked.append({"family": family, "target_class": target_class})
        return tiny()

    def stopped(arm, scene, tags, seed):
        return SearchResult("arm_stopped", "blew up", (), 1.0, 1.0, 0)

    monkeypatch.setattr(searches, "pile_scene", asks)
    monkeypatch.setattr(searches, "run_arm", stopped)
    row = SEARCH_CLASSES.trial(cell, 1, np.random.default_rng(0))
    assert asked == [cell]
    assert set(row) == {metric.name for metric in SEARCH_CLASSES.metrics}
    assert {row[f"ended_{arm}"] for arm in BY_CLASS} == {"arm_stopped"}


def first_step(target_class):
    """What X-Ray does first: of the three methods it has the least to compute."""
    scene = tiny(target_class)
    tags = tagged_items_of(scene, "any", 0, 1)
    return next(SearchRun.of(SearchTask(scene, tags, 1), search_method("xray", tags.target_size)).search.steps())


def test_a_target_in_the_open_is_grasped_first():
    assert first_step("open").on_target


def test_the_colour_of_a_target_that_is_partly_covered_says_where_to_go_and_no_map_does():
    assert first_step("partly").grid is None


def test_every_class_is_asked_for_in_every_family():
    assert SEARCH_CLASSES.factors["target_class"] == TARGET_CLASSES
    assert len(SEARCH_CLASSES.cells) == 9


def test_seeds_of_the_report_are_not_those_of_tuning():
    assert not set(SEARCH_CLASSES.seeds) & set(SEARCH_CLASSES.tuning_seeds)
    assert min(SEARCH_CLASSES.seeds) >= 1000
