"""What maps would take: asking changes no search, every rule answers every question, shares are shares."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from simulation.pile_scenes import tiny

from benchmarks import map_choices
from benchmarks.map_choices import LEAST_SHARE, RULES, Asked, Rule, asked_in, line, main
from planners.extraction.projection import MaskColumns
from planners.search_beliefs import PaperBelief
from rfcompass.errors import NoPile, StudyError
from rfcompass.studies.search_methods import search_method
from rfcompass.studies.searching import SearchRun, SearchTask, tagged_items_of
from rfcompass.types import VoxelGrid

COLUMNS = MaskColumns(np.array([[1, 1, 2], [0, 2, 2]]), np.array([[0.05, 0.05, 0.03], [np.nan, 0.03, 0.03]]))


def grid(values):
    return VoxelGrid(origin_m=np.zeros(3), spacing_m=0.01, values=np.asarray(values, dtype=float))


def row(rule, *, first, share, later):
    return Asked("covered_1p10", 0, later, rule, first, share, 0.1)


def test_asking_changes_no_search_and_every_rule_answers_every_question():
    scene = tiny()
    tags = tagged_items_of(scene, "none", 0, scene.seed)
    plain = SearchRun.of(SearchTask(scene, tags, scene.seed), search_method("fusebot_equal", tags.target_size)).run()
    rows = asked_in("tiny", scene)
    answers = [[asked for asked in rows if asked.rule == rule.name] for rule in RULES]
    assert len({len(of) for of in answers}) == 1
    assert 1 <= len(answers[0]) <= plain.actions
    assert not answers[0][0].later
    assert all(0 <= asked.share <= 1 for asked in rows)


@given(seed=st.integers(0, 1000), power=st.sampled_from([0.3, 1.0]), gamma=st.sampled_from([0.3, 0.7, 1.0]))
def test_shares_sum_to_one_and_do_not_depend_on_the_scale_of_a_map(seed, power, gamma):
    values = np.random.default_rng(seed).uniform(0.1, 1, (2, 3, 6))
    rule = Rule(name="any", belief=PaperBelief(), power=power, gamma=gamma)
    shares = rule.shares(grid(values), COLUMNS, np.array([1, 2]))
    assert shares.sum() == pytest.approx(1)
    assert rule.shares(grid(7 * values), COLUMNS, np.array([1, 2])) == pytest.approx(shares)


def test_all_of_a_map_under_one_thing_is_its_share_and_less_trust_levels_shares():
    values = np.zeros((2, 3, 6))
    values[0, 0, 0] = 1.0
    rule = Rule(name="any", belief=PaperBelief())
    assert rule.shares(grid(values), COLUMNS, np.array([1, 2])).tolist() == [1, 0]
    values[1, 1, 0] = 1e-3
    trusting, doubting = (
        asked.shares(grid(values), COLUMNS, np.array([1, 2])) for asked in (rule, replace(rule, power=0.3))
    )
    assert 0.5 < doubting[0] < trusting[0] < 1


def test_a_line_tells_the_first_decision_and_later_ones_apart():
    rows = [row("paper", first=True, share=0.5, later=False), row("paper", first=False, share=0.0, later=True)]
    bits = -np.log2(LEAST_SHARE)
    expected = f"1.00 · 1.00 · 10.0, 1 | 0.00 · {bits:.2f} · 10.0, 1 | 0.50 · {(1 + bits) / 2:.2f} · 10.0, 2 |"
    assert line("paper", rows) == f"| paper | {expected}"
    assert line("posterior", rows) == "| posterior | – | – | – |"


def test_report_seeds_are_refused_and_a_pile_that_cannot_be_made_is_left_out(monkeypatch, capsys):
    with pytest.raises(StudyError):
        main(["--seeds", "1000:1002"])

    def scene(family, seed):
        if seed == 0:
            raise NoPile("none", seed=seed)
        return seed

    monkeypatch.setattr(map_choices, "pile_scene", scene)
    monkeypatch.setattr(
        map_choices, "asked_in", lambda family, seed: [row("paper", first=True, share=0.5, later=False)]
    )
    assert main(["--seeds", "0:3", "--family", "covered_1p10", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)) == 2
    assert main(["--seeds", "0:3", "--family", "covered_1p10"]) == 0
    assert "| paper | 1.00 · 1.00 · 10.0, 2 | – |" in capsys.readouterr().out
