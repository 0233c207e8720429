"""The scripts that write result pages ask for what studies measure, and find their places on the pages.

They run for hours of studies: what is wrong with them should not show at the end only.
"""

import importlib
from pathlib import Path

import numpy as np
import pytest

from rfcompass.studies.registry import study

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def script(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    return importlib.import_module


def test_every_ordering_is_asked_of_arms_that_a_study_has(script):
    orderings = script("write_orderings")
    pairs = [pair for ordering in orderings.ORDERINGS for pair in (ordering.asked, *ordering.beside)]
    for pair in pairs:
        asked = study(pair.study)
        measured = {metric.name for metric in asked.metrics}
        assert {pair.measure.format(pair.one), pair.measure.format(pair.other)} <= measured, pair
        assert pair.family is None or pair.family in asked.factors["family"], pair
    assert {pair.study for pair in pairs} == set(orderings.STUDIES)


@pytest.mark.parametrize(
    ("low", "high", "higher", "said"),
    [
        (-2.0, -1.0, False, "*shown*"),
        (1.0, 2.0, False, "*reversed*"),
        (1.0, 2.0, True, "*shown*"),
        (-2.0, -1.0, True, "*reversed*"),
        (-1.0, 1.0, True, "*not shown*"),
        (0.0, 1.0, True, "*not shown*"),
        (-1.0, 0.0, False, "*not shown*"),
        (np.nan, np.nan, False, "–"),
    ],
)
def test_an_ordering_is_shown_if_its_interval_lies_on_the_right_side_of_0(script, low, high, higher, said):
    assert script("write_orderings").verdict(low, high, higher=higher) == said


def test_differences_are_of_piles_where_both_have_a_value(script):
    import pyarrow as pa  # noqa: PLC0415

    orderings = script("write_orderings")
    rows = pa.table(
        {
            "family": ["a", "a", "b", "b"],
            "found_x": [True, False, None, True],
            "found_y": [False, False, True, True],
            "time_s_x": [[3.0], [], [1.0], None],
            "time_s_y": [[1.0], [2.0], [], [4.0]],
        }
    )
    found = orderings.Pair("x", "y", orderings.FOUND)
    assert orderings.values_of(rows, found).tolist() == [100.0, 0.0, 0.0]
    assert orderings.values_of(rows, found._replace(family="b")).tolist() == [0.0]
    assert orderings.values_of(rows, found._replace(measure=orderings.TIME)).tolist() == [2.0]
    assert orderings.shown(np.array([-0.001, 0.0]), orderings.ACTIONS) == "0.00 (0.00 … 0.00), 2"


def test_every_table_of_the_page_on_searches_has_its_place(script):
    text = (DOCS / "search_studies.md").read_text(encoding="utf-8")
    for name in (*script("write_search_studies").STUDIES, "orderings", "search-results"):
        assert text.count(f"<!-- {name} -->") == text.count(f"<!-- /{name} -->") == 1, name
