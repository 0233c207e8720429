import json

import numpy as np
import pytest

from rfcompass.errors import TraceError
from rfcompass.recordings import AntennaPoses, Run, Trace, TraceMeta, is_run, open_trace, reads_table, write_run


def a_run(**changes):
    trace = Trace(TraceMeta(frame="odom"), reads_table(()), AntennaPoses.along(np.zeros((1, 3))))
    fields = {
        "asked": {"seed": 1},
        "events": [{"stop": 0}, {"stop": 1}],
        "trace": trace,
        "estimate": {"theta_rad": None},
        "samples": np.zeros((2, 3)),
        "pictures": {"view.html": lambda path: path.write_text("x")},
    }
    return Run(**{**fields, **changes})


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_run_holds_everything_it_was_given(tmp_path):
    write_run(a_run(), tmp_path / "run")
    assert is_run(tmp_path / "run")
    assert json.loads((tmp_path / "run/run.json").read_text())["seed"] == 1
    assert [json.loads(line)["stop"] for line in (tmp_path / "run/events.jsonl").read_text().splitlines()] == [0, 1]
    assert open_trace(tmp_path / "run/trace").meta.frame == "odom"
    assert np.load(tmp_path / "run/samples.npz")["samples"].shape == (2, 3)
    assert (tmp_path / "run/view.html").read_text() == "x"


def test_equal_runs_give_equal_bytes(tmp_path):
    write_run(a_run(), tmp_path / "a")
    write_run(a_run(), tmp_path / "b")
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def test_a_run_is_replaced_only_on_demand(tmp_path):
    write_run(a_run(), tmp_path / "run")
    with pytest.raises(TraceError, match="not asked for"):
        write_run(a_run(asked={"seed": 2}), tmp_path / "run")
    write_run(a_run(asked={"seed": 2}), tmp_path / "run", overwrite=True)
    assert json.loads((tmp_path / "run/run.json").read_text())["seed"] == 2


def test_what_is_no_run_is_never_replaced(tmp_path):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis/chapter.tex").write_text("precious")
    with pytest.raises(TraceError, match="something else"):
        write_run(a_run(), tmp_path / "thesis", overwrite=True)
    assert (tmp_path / "thesis/chapter.tex").read_text() == "precious"


@pytest.mark.parametrize("described", ["{}", "[]", "no json", '{"schema": "other/1"}'])
def test_a_run_json_of_somebody_else_makes_no_run(tmp_path, described):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/run.json").write_text(described)
    with pytest.raises(TraceError, match="something else"):
        write_run(a_run(), tmp_path / "mine", overwrite=True)


def test_a_run_to_which_something_was_added_is_not_replaced(tmp_path):
    write_run(a_run(), tmp_path / "run")
    (tmp_path / "run/notes.txt").write_text("precious")
    with pytest.raises(TraceError, match="something else"):
        write_run(a_run(), tmp_path / "run", overwrite=True)
    assert (tmp_path / "run/notes.txt").read_text() == "precious"


def test_a_failure_leaves_nothing_behind(tmp_path):
    def fail(path):
        raise RuntimeError

    with pytest.raises(RuntimeError):
        write_run(a_run(pictures={"view.html": fail}), tmp_path / "run")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(ValueError, match="JSON"):
        write_run(a_run(estimate={"x": float("nan")}), tmp_path / "run")
    assert list(tmp_path.iterdir()) == []
