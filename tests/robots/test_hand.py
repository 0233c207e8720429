"""The hand read from a URDF, and its openings."""

from dataclasses import replace

import numpy as np
import pytest

from rfcompass import YouBot
from rfcompass.errors import InputError, RobotModelError
from rfcompass.robots import Robot, hand_of
from rfcompass.robots.youbot import PAYLOAD_KG
from rfcompass.types import Jaw

HAND = hand_of(YouBot())


def test_the_youbots_hand_opens_as_its_urdf_says_and_carries_what_the_paper_says():
    assert HAND.least_m == pytest.approx(0.025)
    assert HAND.greatest_m == pytest.approx(0.075)
    assert HAND.payload_kg == PAYLOAD_KG


def test_jaws_and_palm_lie_where_the_urdf_has_them():
    boxes_m = HAND.boxes_m(0.05)
    tips_m = boxes_m[len(HAND.palm_m) :]
    assert tips_m[:, 1, 2].max() == pytest.approx(0.0, abs=1e-12)
    assert tips_m[tips_m[:, 0, 0] > 0][:, 0, 0].min() == pytest.approx(0.025)
    assert HAND.palm_m[:, 1, 2].max() == pytest.approx(0.0325 - 0.0876)


def test_both_jaws_of_a_hand_are_mirror_images_at_every_opening():
    for opening_m in np.linspace(HAND.least_m, HAND.greatest_m, 5):
        left, right = np.split(HAND.boxes_m(opening_m)[len(HAND.palm_m) :], 2)
        np.testing.assert_allclose(left[:, :, 0], -right[:, ::-1, 0], atol=1e-12)


def test_a_wider_hand_only_has_its_jaws_further_apart():
    wide = HAND.with_opening(0.1)
    assert wide.greatest_m == 0.1
    np.testing.assert_allclose(wide.boxes_m(0.06), HAND.boxes_m(0.06))


@pytest.mark.parametrize("opening_m", [0.0, 0.0249, 0.0751, np.nan])
def test_an_opening_that_the_hand_has_not_is_refused(opening_m):
    with pytest.raises(InputError, match="opens from"):
        HAND.opening(opening_m)


@pytest.mark.parametrize("greatest_m", [0.025, -1.0, np.inf, np.nan])
def test_a_hand_cannot_open_less_than_it_closes(greatest_m):
    with pytest.raises(InputError, match="least < greatest"):
        HAND.with_opening(greatest_m)


@pytest.mark.parametrize("field", ["payload_kg", "friction", "grip_n", "give_m"])
def test_physics_must_be_positive(field):
    with pytest.raises(InputError, match=field):
        replace(HAND, **{field: 0.0})


def test_a_jaw_needs_a_pad_and_corners_in_order():
    with pytest.raises(InputError, match="inner face"):
        Jaw(HAND.left.boxes_m, np.zeros((0, 2, 2)))
    with pytest.raises(InputError, match="above the upper"):
        Jaw(HAND.left.boxes_m[:, ::-1], HAND.left.pads_m)


def test_tags_make_the_hand_larger():
    tagged = hand_of(YouBot(), with_tags=True)
    assert len(tagged.palm_m) == len(HAND.palm_m) + 4


def test_a_robot_without_a_tool_or_without_fingers_is_named():
    described = YouBot().description
    with pytest.raises(RobotModelError, match="no tool frame"):
        hand_of(Robot(replace(described, tool=None)))
    with pytest.raises(RobotModelError, match="two fingers"):
        hand_of(Robot(replace(described, tool=replace(described.tool, frame="gripper_finger_link_l"))))


def test_fingers_that_slide_across_the_closing_axis_are_refused():
    described = YouBot().description
    tool = replace(described.tool, closing_axis=np.array([1.0, 0.0, 0.0]))
    with pytest.raises(RobotModelError, match="slide along the closing axis"):
        hand_of(Robot(replace(described, tool=tool)))
