"""The folder of a search is whole or not there, and never replaces what it did not write."""

import json

import pytest

from rfcompass.errors import TraceError
from rfcompass.recordings import is_run
from rfcompass.recordings.search_folder import StoredSearch, is_search, write_search

STORED = StoredSearch({"command": "search"}, {"outcome": "found"}, [{"action": 1}, {"action": 2}])


def test_what_was_asked_and_what_came_of_it_is_told(tmp_path):
    write_search(STORED, tmp_path / "run")
    asked, told = (
        json.loads((tmp_path / "run" / name).read_text(encoding="utf-8")) for name in ("run.json", "search.json")
    )
    assert (asked["command"], told["outcome"]) == ("search", "found")
    assert not is_run(tmp_path / "run")
    assert len((tmp_path / "run" / "events.jsonl").read_text(encoding="utf-8").splitlines()) == 2
    assert is_search(tmp_path / "run")


def test_a_search_is_replaced_only_if_asked(tmp_path):
    write_search(STORED, tmp_path / "run")
    with pytest.raises(TraceError, match="overwriting was not asked for"):
        write_search(STORED, tmp_path / "run")
    write_search(StoredSearch({}, {"outcome": "lost"}, []), tmp_path / "run", overwrite=True)
    assert json.loads((tmp_path / "run" / "search.json").read_text(encoding="utf-8"))["outcome"] == "lost"


@pytest.mark.parametrize("name", ["notes.txt", "data"])
def test_what_is_no_search_is_never_replaced(tmp_path, name):
    write_search(STORED, tmp_path / "run")
    (tmp_path / "run" / name).write_text("mine", encoding="utf-8")
    with pytest.raises(TraceError, match="something else than a search"):
        write_search(STORED, tmp_path / "run", overwrite=True)
    assert (tmp_path / "run" / name).read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("text", ["{", "[]", '{"schema": "other"}'])
def test_another_file_of_that_name_is_no_search(tmp_path, text):
    (tmp_path / "search.json").write_text(text, encoding="utf-8")
    assert not is_search(tmp_path)


def test_a_picture_that_fails_leaves_nothing(tmp_path):
    def broken(path):
        raise OSError("the disk is full")

    with pytest.raises(TraceError, match="disk is full"):
        write_search(StoredSearch({}, {}, [], {"view.html": broken}), tmp_path / "run")
    assert list(tmp_path.iterdir()) == []


def test_numbers_that_json_cannot_hold_are_refused(tmp_path):
    with pytest.raises(ValueError, match="JSON"):
        write_search(StoredSearch({}, {"elapsed_s": float("nan")}, []), tmp_path / "run")
    assert list(tmp_path.iterdir()) == []
