import json

import pytest
from toy_study import toy_study

from rfcompass.errors import StudyError
from rfcompass.studies.folder import open_folder, read_manifest, read_rows


def test_the_manifest_says_what_was_asked(tmp_path):
    study = toy_study()
    open_folder(study, study.first_seeds(3), tmp_path / "run", resume=False)
    manifest = read_manifest(tmp_path / "run")
    assert manifest["schema"] == "rfcompass-study/1"
    assert manifest["factors"] == {"noise_m": [0.1, 0.5], "method": ["bold", "shy"]}
    assert manifest["seeds"] == {"start": 0, "stop": 3, "step": 1}
    assert "numpy" in manifest["versions"]


def test_listed_seeds_are_listed(tmp_path):
    open_folder(toy_study(seeds=(4, 2)), (4, 2), tmp_path, resume=False)
    assert read_manifest(tmp_path)["seeds"] == {"listed": [4, 2]}


@pytest.mark.parametrize(
    "changes",
    [
        {"name": "other"},
        {"kind": "measured"},
        {"factors": {"noise_m": (0.1, 0.6), "method": ("bold", "shy")}},
        {"factors": {"method": ("bold", "shy"), "noise_m": (0.1, 0.5)}},
        {"metrics": toy_study().metrics[:1]},
    ],
)
def test_a_folder_of_another_study_is_not_touched(tmp_path, changes):
    open_folder(toy_study(), range(3), tmp_path, resume=False)
    before = (tmp_path / "study.json").read_bytes()
    with pytest.raises(StudyError, match="differ"):
        open_folder(toy_study(**changes), range(3), tmp_path, resume=True)
    with pytest.raises(StudyError, match="differ"):
        read_rows(tmp_path, toy_study(**changes))
    assert (tmp_path / "study.json").read_bytes() == before


def test_rows_that_are_there_need_a_resume(tmp_path):
    open_folder(toy_study(), range(3), tmp_path, resume=False)
    with pytest.raises(StudyError, match="resume"):
        open_folder(toy_study(), range(3), tmp_path, resume=False)
    open_folder(toy_study(), range(5), tmp_path, resume=True)
    assert read_manifest(tmp_path)["seeds"]["stop"] == 5


def test_a_folder_with_other_things_is_refused(tmp_path):
    (tmp_path / "thesis.tex").write_text("precious")
    with pytest.raises(StudyError, match="not empty"):
        open_folder(toy_study(), range(3), tmp_path, resume=True)
    with pytest.raises(StudyError, match="not a folder"):
        open_folder(toy_study(), range(3), tmp_path / "thesis.tex", resume=True)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_what_a_killed_writer_left_is_cleared_away(tmp_path):
    (tmp_path / ".study.json.0.tmp").write_text("{")
    rows = open_folder(toy_study(), range(3), tmp_path, resume=False)
    (rows / ".rows-1.parquet.1.tmp").write_bytes(b"PAR1")
    open_folder(toy_study(), range(3), tmp_path, resume=True)
    assert [path.name for path in rows.iterdir()] == []
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rows", "study.json"]


@pytest.mark.parametrize("text", [None, "{", "[]", json.dumps({"schema": "rfcompass-study/9"})])
def test_what_is_no_study_is_refused(tmp_path, text):
    if text is not None:
        (tmp_path / "study.json").write_text(text)
    with pytest.raises(StudyError):
        read_rows(tmp_path)


def test_a_study_without_rows_is_refused(tmp_path):
    open_folder(toy_study(), range(3), tmp_path, resume=False)
    with pytest.raises(StudyError, match="no rows yet"):
        read_rows(tmp_path)
