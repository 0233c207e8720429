"""Every example runs as it stands, fast, without a display, and leaves its picture."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("[0-9]*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_leaves_a_picture(example, tmp_path, capsys):
    result = runpy.run_path(str(example))["main"](fast=True, out=tmp_path / "out")
    assert result is not None
    pictures = [path for path in (tmp_path / "out").iterdir() if path.suffix in (".png", ".html")]
    told = capsys.readouterr().out
    assert pictures
    for picture in pictures:
        assert picture.name in told


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_says_what_one_will_see_and_is_short(example):
    lines = example.read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith('"""')
    assert any("You will see" in line for line in lines[:12])
    assert len(lines) <= 150


def test_the_ladder_has_no_missing_rung():
    assert [int(path.name[:2]) for path in EXAMPLES] == list(range(len(EXAMPLES)))


def test_examples_use_public_names_only():
    for example in EXAMPLES:
        assert " import _" not in example.read_text(encoding="utf-8"), example
