"""Pile files: they come back to the last bit, what was changed is found out, and a seed is held to its word."""

import dataclasses
import json

import numpy as np
import pytest
from pile_scenes import TINY, tiny

from rfcompass.errors import PileChanged, PileError
from rfcompass.simulation.piles import open_pile, remake_pile, write_pile


@pytest.fixture
def stored(tmp_path):
    write_pile(tiny(), tmp_path / "pile.json")
    return tmp_path / "pile.json"


def test_a_scene_comes_back_to_the_last_bit(stored):
    scene = open_pile(stored)
    assert scene.fingerprint == tiny().fingerprint
    for number, state in tiny().states.items():
        assert state.tobytes() == scene.states[number].tobytes()


def test_a_scene_is_made_anew_from_its_seed(stored):
    assert remake_pile(stored, TINY).fingerprint == tiny().fingerprint


def test_a_scene_that_its_seed_does_not_give_is_found_out(tmp_path):
    scene = tiny()
    moved = {n: state + 1e-9 * (np.arange(len(state)) == 0) for n, state in scene.states.items()}
    write_pile(dataclasses.replace(scene, states=moved), tmp_path / "moved.json")
    with pytest.raises(PileChanged) as changed:
        remake_pile(tmp_path / "moved.json", TINY)
    assert changed.value.numbers["got"] == scene.fingerprint
    assert "mujoco" in changed.value.numbers["now"]


def test_the_family_of_a_foreign_scene_must_be_given(stored):
    with pytest.raises(PileError, match="no pile family 'tiny'"):
        remake_pile(stored)


def edit(path, change):
    content = json.loads(path.read_text(encoding="utf-8"))
    change(content)
    path.write_text(json.dumps(content), encoding="utf-8")


@pytest.mark.parametrize(
    "change",
    [
        lambda c: c.update(seed=2),
        lambda c: c["items"][0]["state"].__setitem__(0, 0.123),
        lambda c: c["items"][0].update(material="foam"),
        lambda c: c.update(sha256="0" * 64),
        lambda c: c.pop("sha256"),
        lambda c: c.update(schema="rfcompass-pile/9"),
        lambda c: c.pop("target"),
        lambda c: c.update(items=7),
        lambda c: c["items"][0].update(kind="sock"),
        lambda c: c["items"][0].pop("state"),
        lambda c: c["items"][0].update(state="x"),
        lambda c: c["physics"].pop("friction"),
        lambda c: c["physics"].update(glue=1.0),
        lambda c: c.update(seed="many"),
    ],
)
def test_a_file_that_was_changed_is_refused_and_named(change, stored):
    edit(stored, change)
    with pytest.raises(PileError) as refused:
        open_pile(stored)
    assert refused.value.numbers["file"] == str(stored)


@pytest.mark.parametrize("text", ["", "[]", "{", "7"])
def test_a_file_that_is_none_is_refused(text, tmp_path):
    (tmp_path / "x.json").write_text(text, encoding="utf-8")
    with pytest.raises(PileError):
        open_pile(tmp_path / "x.json")


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(PileError, match="no pile file"):
        open_pile(tmp_path / "none.json")
