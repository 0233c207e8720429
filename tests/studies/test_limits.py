import json

import pytest
from toy_study import hostile_toy_trial, toy_study

from rfcompass.errors import StudyError
from rfcompass.studies.folder import read_rows
from rfcompass.studies.limits import TrialLimits
from rfcompass.studies.rows import stable_columns
from rfcompass.studies.runner import run_study

LIMITS = TrialLimits(seconds=1.5, megabytes=300.0)


@pytest.fixture(scope="module")
def peaceful(tmp_path_factory):
    out = tmp_path_factory.mktemp("peaceful")
    run_study(toy_study(), out, limits=LIMITS)
    return stable_columns(read_rows(out)).to_pylist()


@pytest.mark.parametrize(("backend", "workers"), [("sequential", 1), ("threading", 2), ("loky", 2)])
def test_what_hangs_hoards_or_crashes_is_a_row_and_the_study_goes_on(tmp_path, peaceful, backend, workers):
    study = toy_study(trial=hostile_toy_trial, factors={"noise_m": (0.1,), "method": ("bold", "shy")})
    run_study(study, tmp_path, backend=backend, workers=workers, limits=LIMITS)
    rows = stable_columns(read_rows(tmp_path, study)).to_pylist()
    assert len(rows) == 16
    bold = [row for row in rows if row["method"] == "bold"]
    assert [row["failure_kind"] for row in bold] == [
        None, "timed_out", "timed_out", None, "out_of_memory", "process_died", "process_died", "out_of_memory"
    ]  # fmt: skip
    numbers = [json.loads(bold[seed]["failure_numbers"]) for seed in (1, 2, 5, 6)]
    assert numbers == [{"seconds": 1.5}, {"seconds": 1.5}, {"signal": "SIGSEGV"}, {"exit_code": 3}]
    assert bold[4]["failure_message"] == bold[7]["failure_message"] == "took more than 300 MB"
    untouched = [row for row in rows if row["method"] == "shy" or row["seed"] in (0, 3)]
    assert untouched == [row for row in peaceful if row["noise_m"] == 0.1 and row in untouched]
    assert len([row for row in peaceful if row in untouched]) == len(untouched)


@pytest.mark.parametrize("wrong", [{"seconds": 0.0}, {"seconds": float("nan")}, {"megabytes": -1.0}])
def test_a_limit_that_no_trial_can_keep_is_refused(wrong):
    with pytest.raises(StudyError, match="must be positive"):
        TrialLimits(**wrong)
