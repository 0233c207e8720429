"""Pictures of a choice in a pile."""

import dataclasses

import numpy as np
import pytest
from extraction_scenes import question

from planners.extraction import FuseBotPolicy
from rfcompass.errors import ShapeError
from rfcompass.types import InstanceMasks
from rfcompass.viz.choice_figures import draw_choice, shares_of


def test_scores_become_shares_of_the_largest_and_what_is_barred_has_none():
    assert shares_of({4: 2.0, 7: 1.0, 9: -np.inf, 3: -1.0}) == {4: 1.0, 7: 0.5, 3: 0.0}
    assert shares_of({4: 0.0}) == {4: 0.0}
    assert shares_of({}) == {}


def test_the_picture_has_a_number_for_each_object_and_jaws_across_the_chosen_one(tmp_path):
    asked = question(quality=(0.9, 0.9, 0.2))
    policy = FuseBotPolicy()
    action, scores = policy.choose(*asked.parts()), policy.scores(*asked.parts())
    assert max(scores, key=scores.get) == action.mask_label
    figure = draw_choice(asked.view, asked.masks, scores, action, "a pile")
    left, right = figure.axes[:2]
    assert len(right.texts) == 2
    assert left.get_title(loc="left") == "a pile"
    u, v = right.lines[0].get_data()
    row, column = np.round([v.mean(), u.mean()]).astype(int)
    assert asked.masks.labels[row, column] == action.mask_label
    figure.savefig(tmp_path / "choice.png")
    assert (tmp_path / "choice.png").stat().st_size > 5000


def test_without_colour_and_without_a_choice_there_is_a_picture_too():
    asked = question()
    grey = dataclasses.replace(asked.view, colour=None)
    assert not draw_choice(grey, asked.masks, {}).axes[0].lines


def test_masks_of_another_image_are_refused():
    asked = question()
    with pytest.raises(ShapeError):
        draw_choice(asked.view, InstanceMasks(asked.masks.labels[:5]), {})
