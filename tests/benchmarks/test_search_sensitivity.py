"""How much constants matter: every value reaches the search, pairs are those of one pile, no report seed is touched."""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from simulation.pile_scenes import tiny

from benchmarks import search_sensitivity
from benchmarks.search_sensitivity import DEFAULT, VALUES, main, method_of, task_of, tuning_seeds
from rfcompass.errors import NoPile, StudyError
from rfcompass.studies.pile_scan import PILE_SAR
from rfcompass.studies.search_methods import search_method
from rfcompass.studies.searches import LOST
from rfcompass.studies.searching import SPACING_M

MOVED = [(name, value) for name, values in VALUES.items() for value in values]


@pytest.fixture
def stubbed(monkeypatch):
    """A stub in place of scenes and searches: tells of a search by its constants and seed."""

    def stub(answer):
        monkeypatch.setattr(search_sensitivity, "pile_scene", lambda family, seed: family)
        monkeypatch.setattr(search_sensitivity, "search", answer)

    return stub


def found(actions):
    return SimpleNamespace(found=True, actions=actions, outcome="found")


def ran(capsys, *argv):
    assert main([*argv, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_default_is_the_literal_method_of_the_studies():
    task = task_of(DEFAULT, tiny(), 1)
    assert method_of(DEFAULT, task.tags.target_size) == search_method("fusebot", task.tags.target_size)
    assert (task.surveyor, task.spacing_m) == (PILE_SAR, SPACING_M)


@pytest.mark.parametrize(("name", "value"), MOVED)
def test_every_value_is_another_search_of_the_same_pile_with_the_same_tags(name, value):
    moved = replace(DEFAULT, **{name: value})
    tasks = [task_of(constants, tiny(), 1) for constants in (DEFAULT, moved)]
    target = tasks[0].tags.target_size
    parts = [
        (method_of(constants, target), task.spacing_m, task.surveyor)
        for constants, task in zip((DEFAULT, moved), tasks, strict=True)
    ]
    assert sum(one != other for one, other in zip(*parts, strict=True)) == 1
    assert [tag.epc for tag in tasks[0].tags.tags] == [tag.epc for tag in tasks[1].tags.tags]


@pytest.mark.parametrize("text", ["1000:1012", "999:1001", "5:5", "-1:3", "3", "a:b"])
def test_seeds_of_the_report_and_what_is_no_range_are_refused_with_what_was_asked(text):
    with pytest.raises(StudyError) as caught:
        tuning_seeds(text)
    assert caught.value.numbers["seeds"]
    with pytest.raises(StudyError):
        main(["--seeds", text] if not text.startswith("-") else [f"--seeds={text}"])


def test_a_difference_is_that_of_the_same_piles_and_a_lost_target_counts_sixteen(stubbed, capsys):
    def answer(constants, scene, seed):
        if constants.gamma == 0.95:
            return SimpleNamespace(found=False, actions=15, outcome="too_many_actions")
        return found(5 + seed + (constants.gamma == 0.3))

    stubbed(answer)
    got = ran(capsys, "--seeds", "0:3", "--family", "covered_1p10", "--only", "gamma")
    low, high = got["moved"]
    assert (low["constant"], low["value"], low["default"], low["pairs"]) == ("gamma", 0.3, DEFAULT.gamma, 3)
    assert low["difference"] == low["low"] == low["high"] == 1.0
    assert (low["changed"], low["found"], low["default_found"]) == (1.0, 1.0, 1.0)
    assert high["actions"] == LOST
    assert high["found"] == 0.0
    assert high["low"] < high["difference"] < high["high"]
    assert high["difference"] == pytest.approx(LOST - 6)


def test_a_search_that_blows_up_and_a_pile_that_cannot_be_made_are_no_pair(stubbed, monkeypatch, capsys):
    def answer(constants, scene, seed):
        if (seed, constants.tau) in ((0, DEFAULT.tau), (1, 0.25)):
            return SimpleNamespace(found=False, actions=2, outcome="arm_stopped")
        return found(4)

    def scene(family, seed):
        if seed == 3:
            raise NoPile("none", seed=seed)
        return family

    stubbed(answer)
    monkeypatch.setattr(search_sensitivity, "pile_scene", scene)
    got = ran(capsys, "--seeds", "0:4", "--family", "covered_1p10", "--only", "tau")
    assert [(moved["value"], moved["pairs"]) for moved in got["moved"]] == [(0.25, 1), (0.75, 2)]
    assert [moved["low"] for moved in got["moved"]] == [None, 0.0]  # one pile has no interval


def test_several_families_are_judged_each_and_together_and_the_table_has_a_line_for_each(stubbed, capsys):
    stubbed(lambda constants, scene, seed: found(4 + (scene == "poured_1p10") * (constants.cluster == 0.6)))
    families = ("covered_1p10", "poured_1p10")
    assert main(["--seeds", "0:2", "--only", "cluster", "--family", *families]) == 0
    lines = capsys.readouterr().out.splitlines()[2:]
    assert [line.split(" | ")[0] for line in lines] == [f"| {name}" for name in (*families, "all") for _ in range(2)]
    assert "0.3 → 0.6 | 4 | 4.00 → 4.50 | 0.50 (" in lines[-1]


def test_a_search_with_other_constants_comes_to_an_end():
    moved = replace(DEFAULT, gamma=0.3, tau=0.75, tau_xyz=2.0, cluster=0.6, spacing_m=0.02, amplitude=0.5)
    actions = search_sensitivity.actions(moved, tiny("open"), 1)
    assert actions is not None
    assert 1 <= actions <= LOST
