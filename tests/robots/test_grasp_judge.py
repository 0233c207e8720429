"""What holds and what does not, by the readable judge."""

from dataclasses import replace

import numpy as np
import pytest
from grasp_poses import kind, over

from rfcompass import YouBot
from rfcompass.errors import InputError, PartError
from rfcompass.robots import hand_of, judge_grasp
from rfcompass.types import Box, Contacts, Cylinder, Sphere

HAND = hand_of(YouBot())
LEG = Box(np.array([0.40, 0.05, 0.05]))


def test_a_leg_between_the_jaws_is_held_on_its_long_faces():
    contacts = judge_grasp(HAND, LEG, over(0.05, 0.004))
    assert isinstance(contacts, Contacts)
    assert contacts.width_m == pytest.approx(0.05, abs=1e-7)
    np.testing.assert_allclose(contacts.normals, [[0, 1, 0], [0, -1, 0]], atol=1e-9)
    np.testing.assert_allclose(contacts.points_m[:, 1], [0.025, -0.025], atol=1e-7)
    np.testing.assert_allclose(contacts.points_m[:, 0], 0.05, atol=1e-6)


@pytest.mark.parametrize(
    ("y", "expected"), [(0.0124, "holds"), (0.0126, "hand_hits_part"), (-0.0126, "hand_hits_part")]
)
def test_the_margin_is_half_of_what_the_hand_opens_beyond_the_part(y, expected):
    assert kind(judge_grasp(HAND, LEG, over(y=y))) == expected


def test_a_turned_box_touches_with_the_edges_of_the_pads_and_is_wider():
    yaw = 0.2
    contacts = judge_grasp(HAND, LEG, over(yaw=yaw))
    across_m = np.ptp(HAND.left.pads_m[:, :, 0])
    assert contacts.width_m == pytest.approx(0.05 / np.cos(yaw) + across_m * np.tan(yaw), abs=1e-6)
    np.testing.assert_allclose(contacts.angles_rad, yaw, atol=1e-9)


def test_a_turned_box_holds_up_to_the_friction_angle():
    wide = HAND.with_opening(0.12)
    limit = np.arctan(wide.friction)
    assert kind(judge_grasp(wide, LEG, over(yaw=limit - 1e-3))) == "holds"
    assert kind(judge_grasp(wide, LEG, over(yaw=limit + 1e-3))) == "outside_friction_cone"


@pytest.mark.parametrize(
    ("pose", "expected"),
    [
        ({"z": 0.1}, "nothing_between_jaws"),
        ({"x": 0.3}, "nothing_between_jaws"),
        ({"y": 0.085}, "nothing_between_jaws"),  # the leg lies beside a jaw
        ({"y": -0.085}, "nothing_between_jaws"),
        ({"z": -0.035}, "hand_hits_part"),
        ({"yaw": 1.0}, "too_wide"),
    ],
)
def test_each_failure_says_why(pose, expected):
    assert kind(judge_grasp(HAND, LEG, over(**pose))) == expected


def test_a_part_that_is_thinner_than_the_jaws_close_is_not_held():
    thin = Box(np.array([0.4, 0.02, 0.05]))
    assert kind(judge_grasp(HAND, thin, over())) == "nothing_between_jaws"


def test_steps_on_either_side_of_a_part_are_not_opposite():
    beside = replace(
        HAND,
        left=replace(HAND.left, pads_m=np.array([[[-0.05, -0.01], [-0.04, 0.0]]])),
        right=replace(HAND.right, pads_m=np.array([[[0.04, -0.01], [0.05, 0.0]]])),
    )
    assert kind(judge_grasp(beside, LEG, over())) == "not_opposite"


@pytest.mark.parametrize(
    ("mass_kg", "grip_n", "expected"), [(0.166, 20.0, "holds"), (0.6, 20.0, "too_heavy"), (0.166, 1.0, "too_heavy")]
)
def test_weight_is_held_by_payload_and_friction(mass_kg, grip_n, expected):
    assert kind(judge_grasp(replace(HAND, grip_n=grip_n), LEG, over(), mass_kg=mass_kg)) == expected


def test_round_things_are_held_across_their_middle_only():
    rod, ball = Cylinder(0.025, 0.2), Sphere(0.03)
    assert kind(judge_grasp(HAND, rod, over())) == "holds"
    assert kind(judge_grasp(HAND, rod, over(z=0.015))) == "outside_friction_cone"
    assert kind(judge_grasp(HAND, ball, over(z=-0.01))) == "holds"
    assert kind(judge_grasp(HAND, ball, over(z=0.02))) == "outside_friction_cone"
    assert kind(judge_grasp(HAND, Cylinder(0.02, 0.05, "z"), over(yaw=0.7))) == "holds"


def test_bad_input_is_refused():
    with pytest.raises(PartError, match="no rigid transform"):
        judge_grasp(HAND, LEG, np.diag([1.0, 1.0, -1.0, 1.0]))
    with pytest.raises(InputError, match="opens from"):
        judge_grasp(HAND, LEG, over(), opening_m=0.2)
