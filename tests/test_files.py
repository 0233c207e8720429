import pytest

from rfcompass.errors import PlanFileError
from rfcompass.files import read_json, write_atomic, write_text_atomic


def test_a_writer_that_fails_leaves_the_old_file_and_nothing_else(tmp_path):
    write_text_atomic(tmp_path / "a.txt", "old")

    def fail(draft):
        draft.write_text("half")
        raise RuntimeError("disk full")

    with pytest.raises(RuntimeError):
        write_atomic(tmp_path / "a.txt", fail)
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "old"


def test_a_draft_hides_beside_its_file_until_it_is_whole(tmp_path):
    seen = []

    def write(draft):
        draft.write_text("new")
        seen.extend(path.name for path in tmp_path.iterdir())

    write_atomic(tmp_path / "a.txt", write)
    assert len(seen) == 1
    assert seen[0].startswith(".a.txt.")
    assert (tmp_path / "a.txt").read_text() == "new"


@pytest.mark.parametrize("text", [None, "{", "\x00"])
def test_a_file_that_is_no_json_says_so_in_the_callers_words(tmp_path, text):
    file = tmp_path / "plan.json"
    if text is not None:
        file.write_text(text)
    with pytest.raises(PlanFileError, match="cannot be read as JSON") as refused:
        read_json(file, PlanFileError)
    assert refused.value.numbers == {"file": str(file)}


def test_json_is_read_as_it_is(tmp_path):
    (tmp_path / "a.json").write_text('[1, {"b": null}]')
    assert read_json(tmp_path / "a.json", PlanFileError) == [1, {"b": None}]
