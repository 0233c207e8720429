"""The folder of a search is whole or not there, and never replaces what it did not write."""

import json
import os

import pytest

from rfcompass.errors import TraceError
from rfcompass.recordings import check_target, check_task_target, is_run
from rfcompass.recordings.search_folder import StoredSearch, check_search_target, is_search, write_search
from rfcompass.recordings.trace_store import check_trace_target

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


every_check = pytest.mark.parametrize(
    "check", [check_search_target, check_target, check_task_target, check_trace_target]
)


@every_check
@pytest.mark.parametrize("inside", ["sub", "sub/deeper"])
def test_a_place_inside_a_file_is_refused_before_there_is_anything_to_write(tmp_path, check, inside):
    (tmp_path / "afile").write_text("mine", encoding="utf-8")
    with pytest.raises(TraceError, match="afile is no folder"):
        check(tmp_path / "afile" / inside, overwrite=False)


@every_check
@pytest.mark.parametrize("name", ["loop/run", 300 * "n", "a\0b"])
def test_a_place_that_no_system_has_is_refused(tmp_path, check, name):
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    with pytest.raises(TraceError, match=r"no place|is no folder"):
        check(tmp_path / name, overwrite=False)


@every_check
def test_a_place_in_a_folder_that_must_not_be_written_to_is_refused(tmp_path, check, monkeypatch):
    asked = []
    monkeypatch.setattr(os, "access", lambda folder, mode: asked.append((folder, mode)))  # says no, also to the root
    with pytest.raises(TraceError, match="nothing may be written"):
        check(tmp_path / "new" / "run", overwrite=False)
    assert asked == [(tmp_path.resolve(), os.W_OK | os.X_OK)]


@every_check
def test_folders_that_are_missing_on_the_way_are_no_obstacle(tmp_path, check, monkeypatch):
    monkeypatch.chdir(tmp_path)
    check(tmp_path / "new" / "run", overwrite=False)
    check(type(tmp_path)("runs/one"), overwrite=False)
    check(type(tmp_path)("."), overwrite=False)
    assert list(tmp_path.iterdir()) == []
