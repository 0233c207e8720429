"""Figures show what the rows hold: every trial with an answer counts, and only those of the panel's cell."""

import numpy as np
import pyarrow as pa
import pytest

from rfcompass.studies.accuracy import ACCURACY
from rfcompass.studies.error_pictures import draw_accuracy, draw_resolution, picked
from rfcompass.studies.resolution import AFTER, RESOLUTION

ERRORS_M = (0.05, None, 0.01, 0.03)


def rows(study, values):
    """A table of the study's columns: four trials in each cell, the metrics the same everywhere."""
    cells = [cell for cell in study.cells for _ in values]
    columns = {factor: [cell[factor] for cell in cells] for factor in study.factors}
    metrics = {metric.name: pa.array([*values] * len(study.cells), pa.float64()) for metric in study.metrics}
    return pa.table({**columns, **metrics})


def test_picked_values_are_those_of_the_cell_that_have_an_answer():
    table = pa.table({"rig": ["a", "b", "a", "a"], "off_m": [0.1, 0.2, None, 0.3]})
    assert np.allclose(picked(table, "off_m", 100.0, rig="a"), [10.0, 30.0])
    assert not len(picked(table, "off_m", rig="c"))


def test_shares_rise_to_all_trials_with_an_answer():
    figures = draw_accuracy(rows(ACCURACY, ERRORS_M))
    assert len(figures) == 2
    for figure, scale in zip(figures.values(), (100.0, 180.0 / np.pi), strict=True):
        for axes in figure.axes:
            curves = [line for line in axes.lines if line.get_label().startswith("K = ")]
            assert len(curves) == 4
            for curve in curves:
                assert np.allclose(curve.get_xdata(), [0.0, *(scale * np.array([0.01, 0.03, 0.05]))])
                assert np.allclose(curve.get_ydata(), [0.0, 100.0 / 3, 200.0 / 3, 100.0])


def test_progress_shows_the_median_after_each_number_of_stops():
    figures = draw_resolution(rows(RESOLUTION, ERRORS_M))
    assert len(figures) == 4
    axes = next(iter(figures.values())).axes[0]
    assert [line.get_label() for line in axes.lines] == ["paper", "consistency", "posterior"]
    for line in axes.lines:
        assert tuple(line.get_xdata()) == AFTER
        assert line.get_ydata() == pytest.approx([3.0] * len(AFTER))
