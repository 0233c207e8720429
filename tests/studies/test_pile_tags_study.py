"""The study of Table 5 in piles: every tag is accounted for, and scenes that are kept are those that are made."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from rfcompass.errors import PileError
from rfcompass.simulation.piles import PileFamily, make_pile, scan_pile, tag_items, write_pile
from rfcompass.studies import pile_scenes, pile_tags
from rfcompass.studies.pile_scan import wrist_way
from rfcompass.studies.pile_scenes import FOLDER_VARIABLE, pile_scene
from rfcompass.studies.pile_tags import LAYERS, MATERIALS, PILE_TAGS, tags_of_scan
from rfcompass.studies.trial import run_trial


@cache
def tiny():
    return make_pile(PileFamily("tiny", "covered", (4,)), 1, "hidden")


def numbered(seed):
    """The tiny scene under another seed."""
    return replace(tiny(), seed=seed)


@pytest.fixture
def small(monkeypatch):
    """Tiny piles in place of the families."""
    monkeypatch.setattr(pile_tags, "pile_scene", lambda family, seed: tiny())


def test_every_tag_is_counted_once_in_every_grouping(small):
    record = run_trial(PILE_TAGS.name, PILE_TAGS.trial, PILE_TAGS.metrics, PILE_TAGS.cells[0], 1)
    assert record.failure is None, record.failure
    got, count = record.metrics, int(record.metrics["tags"])
    assert len(got["located"]) == len(got["confident"]) == count
    assert len(got["nearest_m"]) == len(got["nearest_los_m"]) + len(got["nearest_nlos_m"])
    assert len(got["nearest_m"]) == len(got["nearest_confident_m"]) + len(got["nearest_unsure_m"])
    assert sum(len(got[f"read_layers_{name}"]) for name in LAYERS) == count
    assert sum(len(got[f"read_{name}"]) for name in MATERIALS) <= count
    assert all(0 <= share <= 1 for name in LAYERS for share in got[f"read_layers_{name}"])


def test_the_nearest_point_of_a_tag_is_no_farther_than_its_middle():
    scene, way = tiny(), wrist_way("one")
    world, tags = scene.world(), tag_items(scene, "any", 2, np.random.default_rng(0))
    scan = scan_pile(world, tags, way.camera_poses, way.track, np.random.default_rng(0))
    for row in tags_of_scan(world, tags, scan, way.track.positions_m):
        assert row.nearest_m is not None
        assert abs(row.height_off_m) <= row.nearest_m + pile_tags.TAG_LENGTH_M / 2


def test_a_scene_that_was_kept_is_taken_and_one_that_was_not_is_made_and_kept(tmp_path, monkeypatch):
    made = []

    def make(family, seed, target_class):
        assert target_class == "hidden"
        made.append(seed)
        return numbered(seed)

    monkeypatch.setattr(pile_scenes, "make_pile", make)
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "scenes"))
    first, again = pile_scene("tiny", 1), pile_scene("tiny", 1)
    assert made == [1]
    assert first.fingerprint == again.fingerprint


def test_a_file_of_another_scene_is_not_taken_and_a_broken_one_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(pile_scenes, "make_pile", lambda family, seed, kind: numbered(seed))
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    write_pile(numbered(2), tmp_path / "tiny_1.json")
    assert pile_scene("tiny", 1).seed == 1
    (tmp_path / "tiny_3.json").write_text("{}")
    with pytest.raises(PileError):
        pile_scene("tiny", 3)


def test_scenes_of_different_classes_are_kept_apart(tmp_path, monkeypatch):
    made = []

    def make(family, seed, target_class):
        made.append(target_class)
        return replace(tiny(), seed=seed, target_class=target_class)

    monkeypatch.setattr(pile_scenes, "make_pile", make)
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    classes = ("partly", "hidden", "open")
    for _ in range(2):
        assert [pile_scene("tiny", 1, kind).target_class for kind in classes] == list(classes)
    assert pile_scene("tiny", 1).target_class == "hidden"
    assert made == list(classes)


def test_seeds_of_the_report_are_not_those_of_tuning():
    assert not set(PILE_TAGS.seeds) & set(PILE_TAGS.tuning_seeds)
    assert min(PILE_TAGS.seeds) >= 1000
