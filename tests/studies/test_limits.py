import json

import pytest
from toy_study import hostile_toy_trial, rarely_hostile_toy_trial, toy_study

from rfcompass.errors import StudyError
from rfcompass.studies.folder import read_rows
from rfcompass.studies.limits import TrialLimits
from rfcompass.studies.rows import stable_columns
from rfcompass.studies.runner import run_study

LIMITS = TrialLimits(seconds=3.0, megabytes=150.0)


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
        None, None, "timed_out", None, "out_of_memory", "process_died", "process_died", "out_of_memory"
    ]  # fmt: skip
    numbers = [json.loads(bold[seed]["failure_numbers"]) for seed in (2, 5, 6)]
    assert numbers == [{"seconds": 3.0}, {"signal": "SIGSEGV"}, {"exit_code": 3}]
    assert bold[4]["failure_message"] == bold[7]["failure_message"] == "took more than 150 MB"
    untouched = [row for row in rows if row["method"] == "shy" or row["seed"] in (0, 1, 3)]
    assert untouched == [row for row in peaceful if row["noise_m"] == 0.1 and row in untouched]
    assert len([row for row in peaceful if row in untouched]) == len(untouched)


def test_a_short_trial_that_once_in_a_batch_goes_wrong_takes_no_other_with_it(tmp_path):
    """Two hundred trials of a millisecond travel in batches, in which three crash and one hangs."""
    study = toy_study(
        trial=rarely_hostile_toy_trial, factors={"noise_m": (0.1,)}, paper=(), seeds=range(200), tuning_seeds=()
    )
    run_study(study, tmp_path, limits=LIMITS)
    kinds = read_rows(tmp_path).column("failure_kind").to_pylist()
    assert {seed: kind for seed, kind in enumerate(kinds) if kind is not None} == {
        50: "process_died", 90: "process_died", 91: "process_died", 150: "timed_out"
    }  # fmt: skip


@pytest.mark.parametrize("wrong", [{"seconds": 0.0}, {"seconds": float("nan")}, {"megabytes": -1.0}])
def test_a_limit_that_no_trial_can_keep_is_refused(wrong):
    with pytest.raises(StudyError, match="must be positive"):
        TrialLimits(**wrong)
