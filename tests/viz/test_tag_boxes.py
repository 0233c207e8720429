"""Boxes of located tags are where the fixes are, as large as the boxes are, and coloured by confidence."""

import numpy as np
import pytest

from rfcompass.types import TagFix
from rfcompass.viz.tag_boxes import tag_boxes


def test_a_box_and_a_mark_for_each_fix():
    fix = TagFix("a", np.array([0.1, 0.2, 0.3]), np.array([0.05, 0.06, 0.2]), True)
    box, mark = tag_boxes([fix])
    assert box.dimensions_m == pytest.approx(fix.box_m)
    for shape in (box, mark):
        assert shape.T_world_shape[:3, 3] == pytest.approx(fix.point_m)
    assert box.rgba[3] < 1 == mark.rgba[3]


def test_an_unsure_fix_has_another_colour_and_a_flat_box_can_be_drawn():
    flat = np.array([0.1, 0.1, 0.0])
    sure, unsure = (tag_boxes([TagFix("a", np.zeros(3), flat, confident)])[0] for confident in (True, False))
    assert not np.allclose(sure.rgba, unsure.rgba)
    assert (unsure.dimensions_m > 0).all()
