import numpy as np
import pytest

from rfcompass.errors import InputError, StudyError
from rfcompass.studies.metric import Metric


def test_numpy_values_are_stored_as_plain_ones():
    assert Metric("x").stored(np.float32(0.5)) == 0.5
    assert Metric("x", column="bool").stored(np.bool_(True)) is True
    assert Metric("x", column="text").stored("word") == "word"
    assert Metric("x", column="samples").stored(np.array([0.5, 1.0])) == (0.5, 1.0)


@pytest.mark.parametrize("column", ["float", "bool", "text", "samples"])
def test_what_is_not_observable_is_none(column):
    assert Metric("x", column=column).stored(None) is None


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("float", float("nan")),
        ("float", np.inf),
        ("float", "0.5"),
        ("float", [0.5, 0.6]),
        ("bool", 1),
        ("text", 1.0),
        ("samples", 0.5),
        ("samples", "0.5"),
        ("samples", [0.5, float("nan")]),
    ],
)
def test_values_of_another_type_or_without_meaning_are_refused(column, value):
    with pytest.raises(StudyError, match="metric x"):
        Metric("x", column=column).stored(value)


def test_a_share_of_samples_needs_yes_and_no():
    right = Metric("right", ("share",), "samples")
    assert right.stored([True, 0, 1.0]) == (1.0, 0.0, 1.0)
    with pytest.raises(StudyError):
        right.stored([0.5])


@pytest.mark.parametrize(
    ("column", "summary"),
    [("float", "share"), ("bool", "mean"), ("text", "median"), ("text", "share"), ("float", "best")],
)
def test_summaries_that_make_no_sense_are_refused(column, summary):
    with pytest.raises(InputError):
        Metric("x", (summary,), column)


def test_a_value_is_shown_in_the_unit_of_the_report():
    assert Metric("x_m", unit="cm", scale=100.0).shown(0.0234) == "2.3"
    assert Metric("x_m").shown(None) == "–"
