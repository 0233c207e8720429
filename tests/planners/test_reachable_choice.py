"""Choosing again while the arm refuses: nearby grasps, then other objects; what failed before stays where it was."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.extraction.candidates import tried_before
from planners.reachable_choice import Offer, choose_within_reach
from planners.target_grasp import ChosenGrasp
from rfcompass.errors import NothingToGrasp
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView, ExtractionAction, GraspMaps, InstanceMasks

H, W, F, HIGH_M = 40, 60, 60.0, 0.6
DOWN = np.diag([1.0, -1.0, -1.0, 1.0])
DOWN[2, 3] = HIGH_M
VIEW = DepthView(np.full((H, W), HIGH_M - 0.05), np.array([[F, 0, 29.5], [0, F, 19.5], [0, 0, 1.0]]), DOWN)
FLAT = np.zeros((H, W))


def offer(*, failed_m=()):
    """Two objects side by side, the left one with the better grasps."""
    labels = np.zeros((H, W), dtype=np.int64)
    labels[10:30, 10:30], labels[10:30, 30:50] = 1, 2
    quality = np.select([labels == 1, labels == 2], [0.9, 0.6], 0.0)
    return Offer(VIEW, InstanceMasks(labels), GraspMaps(quality, FLAT, FLAT + 0.04, FLAT + 0.02), failed_m)


def place_m(row, column):
    return points_image(VIEW)[row, column]


def best(left):
    """The best grasp that is left, after failures."""
    quality = left.grasps.quality * tried_before(points_image(VIEW), left.masks, left.failed_m)
    quality = np.where(left.masks.labels > 0, quality, -1.0)
    row, column = np.unravel_index(quality.argmax(), quality.shape)
    if quality[row, column] < 0:
        raise NothingToGrasp("nothing is left", masks=0)
    T = DOWN.copy()
    T[:3, 3] = place_m(row, column)
    action = ExtractionAction(int(left.masks.labels[row, column]), T, 0.06, 1.0)
    return ChosenGrasp(action, left.chance_of(action))


def right_of_the_middle(action):
    return bool(action.T_world_hand[0, 3] > 0.0)


def test_the_first_choice_stays_where_the_arm_reaches_it():
    chosen = choose_within_reach(offer(), best, lambda action: True)
    assert (chosen.action.mask_label, chosen.reached) == (1, True)
    assert chosen.chance == pytest.approx(0.9)


def test_an_object_out_of_reach_gives_way_after_two_grasps():
    asked = []

    def reaches(action):
        asked.append(action.mask_label)
        return right_of_the_middle(action)

    chosen = choose_within_reach(offer(), best, reaches)
    assert asked == [1, 1, 2]
    assert (chosen.action.mask_label, chosen.reached) == (2, True)
    assert chosen.chance == pytest.approx(0.6)


def test_where_nothing_is_in_reach_the_last_choice_says_so_and_promises_nothing():
    chosen = choose_within_reach(offer(), best, lambda action: False)
    assert (chosen.reached, chosen.chance) == (False, 0.0)


def test_a_target_is_tried_elsewhere_and_what_shares_its_mask_is_kept():
    def target(left):
        return replace(best(left), on_target=True)

    asked = []
    chosen = choose_within_reach(offer(), target, lambda action: asked.append(action.mask_label) or len(asked) == 6)
    assert asked[:6] == [1] * 6
    assert chosen.reached


def test_a_choice_of_one_object_is_not_told_that_the_object_is_gone():
    seen = []

    def notes(left):
        seen.append(left.masks.count)
        return best(left)

    choose_within_reach(offer(), notes, lambda action: False, objects=False)
    assert set(seen) == {2}


def test_nothing_at_all_is_for_the_caller():
    empty = replace(offer(), masks=InstanceMasks(np.zeros((H, W), dtype=np.int64)))
    with pytest.raises(NothingToGrasp):
        choose_within_reach(empty, best, lambda action: True)
    assert choose_within_reach(offer(), lambda left: None, lambda action: True) is None


@given(row=st.integers(10, 29), column=st.integers(10, 49), label=st.sampled_from([1, 2]))
def test_leaving_an_object_out_moves_no_blame_to_another(row, column, label):
    """What is believed of each pixel of the object that stays is what was believed before."""
    before = offer(failed_m=(place_m(row, column),))
    after = before.without_object(label)
    tried = [tried_before(points_image(VIEW), of.masks, of.failed_m) for of in (before, after)]
    failed_on = int(before.masks.labels[row, column])
    stays = after.masks.labels > 0
    if failed_on == label:
        assert np.all(tried[1][stays] == 1.0)
    else:
        np.testing.assert_array_equal(tried[1][stays], tried[0][stays])
    assert len(after.failed_m) == len(before.failed_m)


def test_what_failed_promises_less():
    action = best(offer()).action
    failed = offer(failed_m=(action.T_world_hand[:3, 3],))
    assert failed.chance_of(action) < 0.5 * offer().chance_of(action)
