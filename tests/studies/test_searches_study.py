"""The studies of whole searches: rows have what they declare, differences are those of their own row."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from simulation.pile_scenes import tiny

from rfcompass.studies import searches
from rfcompass.studies.registry import all_studies
from rfcompass.studies.search_confirm import CONFIRM_ARMS, CONFIRM_PAIRS, SEARCH_CONFIRM
from rfcompass.studies.search_figures import SEARCH_LEVELS, SEARCH_TAGS
from rfcompass.studies.search_methods import METHODS, search_method
from rfcompass.studies.searches import (
    BOUNDS,
    EVERY_ARM,
    GATE_PAIRS,
    KNOWN,
    LOST,
    PAIRS,
    SEARCHES,
    Arm,
    dealt,
    metrics_of,
    row_of,
)
from rfcompass.types import ItemSize

TARGET = ItemSize("target", np.array([0.06, 0.05, 0.04]))
FEW = {"ours": Arm("ours"), KNOWN: Arm(KNOWN), "elsewhere": Arm("fusebot", 1, "other_pile")}


@pytest.fixture(scope="module")
def row():
    patch = pytest.MonkeyPatch()
    patch.setattr(searches, "pile_scene", lambda family, seed, target_class: tiny(target_class))
    try:
        return row_of("tiny", 1, FEW, (("ours", KNOWN), ("ours", "elsewhere")))
    finally:
        patch.undo()


def test_a_row_has_what_its_metrics_declare_and_each_value_fits(row):
    declared = {metric.name: metric for metric in metrics_of(FEW, (("ours", KNOWN), ("ours", "elsewhere")))}
    assert set(row) == set(declared)
    for name, value in row.items():
        declared[name].stored(value)


def test_a_difference_is_that_of_the_actions_where_a_failure_counts_sixteen(row):
    assert row["less_ours_known"] == row["all_ours"] - row["all_known"]
    for arm in ("ours", KNOWN):
        assert row[f"all_{arm}"] == (row[f"actions_{arm}"][0] if row[f"found_{arm}"] else LOST)


def test_a_way_whose_tags_cannot_be_has_no_value_and_says_why(row):
    assert row["ended_elsewhere"] == "PileError"
    assert row["all_elsewhere"] is None
    assert row["less_ours_elsewhere"] is None


def test_grasps_are_counted_one_by_one(row):
    assert all(value in (0.0, 1.0) for value in row["grasps_ours"])
    assert len(row["said_ours"]) == len(row["grasps_ours"])
    assert all(0 <= chance <= 1 for chance in row["said_ours"])
    assert max(row["said_ours"]) > 0
    assert row["removed_ours"] == sum(row["grasps_ours"]) - row["found_ours"]  # the last one was the target


@pytest.mark.parametrize("study", [SEARCHES, SEARCH_CONFIRM, SEARCH_LEVELS, SEARCH_TAGS], ids=lambda study: study.name)
def test_no_seed_serves_for_choosing_and_reporting(study):
    assert not set(study.seeds) & set(study.tuning_seeds)
    assert min(study.seeds) >= 1000


def test_the_piles_that_confirm_are_of_no_other_study():
    for study in all_studies().values():
        shared = set(study.factors.get("family", ())) & set(SEARCH_CONFIRM.factors["family"])
        if shared and study.name != SEARCH_CONFIRM.name:
            assert not set(study.seeds) & set(SEARCH_CONFIRM.seeds), study.name
    assert len(SEARCH_CONFIRM.seeds) * len(SEARCH_CONFIRM.cells) >= 400


def test_what_is_confirmed_is_what_was_asked_before():
    assert {name: EVERY_ARM[name] for name in CONFIRM_ARMS} == CONFIRM_ARMS
    assert {name for pair in CONFIRM_PAIRS for name in pair} == set(CONFIRM_ARMS)


def test_arms_are_known_ways_and_pairs_are_of_arms():
    assert {arm.way for arm in EVERY_ARM.values()} <= {*METHODS, *BOUNDS}
    assert {name for pair in (*PAIRS, *GATE_PAIRS) for name in pair} <= set(EVERY_ARM)


def test_the_two_of_a_pair_of_gates_differ_in_the_gate_alone():
    for gated, ungated in GATE_PAIRS:
        one, other = EVERY_ARM[gated], EVERY_ARM[ungated]
        assert (one.tags, one.placement, one.share) == (other.tags, other.placement, other.share)
        with_gate, without = (search_method(arm.way, TARGET) for arm in (one, other))
        assert (with_gate.policy.gate, without.policy.gate) == (True, False)
        opened = replace(with_gate, name=without.name, policy=replace(with_gate.policy, gate=False))
        assert repr(opened) == repr(without)


def test_a_share_of_tags_is_one_of_all_distractors():
    scene = tiny()
    counts = [len(dealt(Arm("fusebot", share=share), scene, 1).tags) for share in (0.0, 0.25, 0.5)]
    assert counts == [round(share * (len(scene.items) - 1)) for share in (0.0, 0.25, 0.5)]


@pytest.mark.parametrize("name", EVERY_ARM)
def test_every_arm_has_the_tags_that_it_says_as_far_as_there_are_items_for_them(name):
    arm, scene = EVERY_ARM[name], tiny()
    tagged = [tag.number for tag in dealt(arm, scene, 1).tags]
    taggable = [item.number for item in scene.items if item.taggable and item.number != scene.target]
    asked = arm.tags + round(arm.share * (len(scene.items) - 1))
    assert len(set(tagged) - {scene.target}) == min(asked, len(taggable))
    assert (scene.target in tagged) == (arm.placement == "target") == ("_own" in name)
