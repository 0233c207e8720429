import numpy as np
import pyarrow as pa
import pytest
from toy_study import toy_study

from rfcompass.evaluation.statistics import wilson_interval
from rfcompass.studies.metric import Metric
from rfcompass.studies.rows import row_schema
from rfcompass.studies.study import PaperValue
from rfcompass.studies.summary import run_facts, summarise

STUDY = toy_study(
    factors={"method": ("bold", "shy")},
    metrics=(
        Metric("error_m", ("median", "p90")),
        Metric("right", ("share",), "bool"),
        Metric("order", ("share",), "samples"),
        Metric("tag_errors_m", ("median",), "samples"),
        Metric("remark", column="text"),
    ),
    paper=(PaperValue("right", "share", 0.9, "[Toy]", cell={"method": "shy"}),),
)


def table(rows):
    blank = dict.fromkeys(("error_m", "right", "order", "tag_errors_m", "remark", "failure_kind"))
    common = {"study": "toy", "runtime_s": 0.5, "versions": "numpy 2"}
    filled = [{**blank, **common, "method": ("bold", "shy")[row["cell"]], **row} for row in rows]
    return pa.Table.from_pylist(filled, schema=row_schema(STUDY))


def lines(rows):
    return {(line.cell["method"], line.metric, line.summary): line for line in summarise(STUDY, table(rows))}


def test_statistics_are_of_the_trials_that_have_a_value():
    errors = np.random.default_rng(0).exponential(size=20)
    rows = [{"cell": 0, "seed": seed, "error_m": error} for seed, error in enumerate(errors)]
    rows += [{"cell": 0, "seed": 20, "failure_kind": "TooFewReads"}, {"cell": 0, "seed": 21}]
    line = lines(rows)["bold", "error_m", "p90"]
    assert (line.trials, line.failures, line.n) == (22, 1, 20)
    assert line.value == pytest.approx(np.quantile(errors, 0.9))
    assert line.interval.low < line.value < line.interval.high


def test_a_failed_trial_is_a_no_in_a_share_of_trials():
    rights = [True] * 6 + [False] * 2 + [None]
    rows = [{"cell": 1, "seed": seed, "right": right} for seed, right in enumerate(rights)]
    rows += [{"cell": 1, "seed": seed, "failure_kind": "Infeasible"} for seed in (9, 10)]
    line = lines(rows)["shy", "right", "share"]
    assert (line.n, line.value) == (10, 0.6)
    assert line.interval == wilson_interval(6, 10)
    assert line.paper.value == 0.9


def test_samples_of_all_trials_are_pooled_and_stay_together():
    rng = np.random.default_rng(1)
    by_trial = [list(rng.normal(rng.normal(), 0.01, size=10)) for _ in range(12)]
    rows = [{"cell": 0, "seed": seed, "tag_errors_m": samples} for seed, samples in enumerate(by_trial)]
    rows += [{"cell": 0, "seed": 12, "tag_errors_m": []}, {"cell": 0, "seed": 13}]
    line = lines(rows)["bold", "tag_errors_m", "median"]
    assert line.n == 120
    assert line.value == pytest.approx(np.median(by_trial))
    scattered = [{"cell": 0, "seed": k, "tag_errors_m": [x]} for k, x in enumerate(np.ravel(by_trial))]
    independent = lines(scattered)["bold", "tag_errors_m", "median"]
    assert independent.value == line.value
    width, narrow = (x.interval.high - x.interval.low for x in (line, independent))
    assert narrow < 0.7 * width


def test_always_right_has_an_interval_with_a_width():
    rows = [{"cell": 0, "seed": seed, "order": [1.0] * 10} for seed in range(5)]
    line = lines(rows)["bold", "order", "share"]
    assert (line.value, line.n) == (1.0, 50)
    assert line.interval.low == wilson_interval(50, 50).low < 1.0


def test_one_value_has_no_interval_and_none_no_value():
    found = lines([{"cell": 0, "seed": 0, "error_m": 0.5}])
    assert found["bold", "error_m", "median"].value == 0.5
    assert found["bold", "error_m", "median"].interval is None
    assert found["bold", "right", "share"].value is None


def test_one_trial_of_many_samples_has_an_interval():
    line = lines([{"cell": 0, "seed": 0, "tag_errors_m": [0.1, 0.2, 0.3, 0.4]}])["bold", "tag_errors_m", "median"]
    assert 0.1 <= line.interval.low < line.interval.high <= 0.4


def test_a_line_does_not_depend_on_other_cells():
    rows = [{"cell": 1, "seed": seed, "error_m": float(seed)} for seed in range(5)]
    alone = lines(rows)
    others = lines([{"cell": 0, "seed": 3, "error_m": 9.0}, *rows])
    assert len(others) == 2 * len(alone)  # cells without rows have no line
    assert others["shy", "error_m", "median"] == alone["shy", "error_m", "median"]


def test_facts_name_every_software_and_failure():
    rows = [{"cell": 0, "seed": 0}, {"cell": 1, "seed": 0, "failure_kind": "Infeasible", "versions": "numpy 3"}]
    facts = run_facts(table(rows))
    assert (facts.trials, facts.seeds, facts.runtime_s) == (2, 1, 1.0)
    assert facts.failures == {"Infeasible": 1}
    assert facts.versions == ("numpy 2", "numpy 3")
