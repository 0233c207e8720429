"""A panel for each rule, a line for each hand, dashed lines to compare with."""

import numpy as np

from rfcompass.viz.attempt_figures import draw_attempts

SHARES = {"7.5 cm": np.linspace(0.1, 1.0, 40), "10 cm": np.ones(40)}


def test_every_rule_has_a_panel_and_every_hand_a_line():
    figure = draw_attempts({"geometry": SHARES, "threshold": SHARES})
    assert [axes.get_title() for axes in figure.axes] == ["geometry", "threshold"]
    for axes in figure.axes:
        assert [line.get_label() for line in axes.lines] == list(SHARES)
        np.testing.assert_array_equal(axes.lines[0].get_xdata(), np.arange(1, 41))
        np.testing.assert_array_equal(axes.lines[0].get_ydata(), SHARES["7.5 cm"])


def test_references_have_the_colour_of_their_hand():
    axes = draw_attempts({"geometry": SHARES}, {"7.5 cm": SHARES["7.5 cm"], "10 cm": np.array([0.8])}).axes[0]
    assert len(axes.lines) == 4
    assert axes.lines[2].get_color() == axes.lines[0].get_color()
    assert axes.lines[3].get_color() == axes.lines[1].get_color()
    assert axes.lines[3].get_linestyle() == "None"  # a point, not a curve
