"""The hand goes where the part is believed to be; what it meets is the true part."""

import numpy as np
import pytest

from rfcompass import YouBot
from rfcompass.evaluation.error_pairs import Draws, ErrorFamily
from rfcompass.evaluation.geometric_rule import GeometricRule, from_above
from rfcompass.evaluation.grasp_trials import GraspRule
from rfcompass.robots.hand import hand_of
from rfcompass.types.shapes import Box

LEG = Box(np.array([0.40, 0.05, 0.05]))
HAND = hand_of(YouBot())


def rule(opening_m):
    hand = HAND.with_opening(opening_m)
    return GeometricRule(hand, LEG, from_above(hand, 0.005))


def draws(x_m=0.0, y_m=0.0, theta_rad=0.0):
    x_m, y_m, theta_rad = np.broadcast_arrays(np.atleast_1d(x_m), y_m, theta_rad)
    return Draws(np.column_stack([x_m, y_m]), theta_rad)


def test_the_planned_pose_points_down_with_the_jaws_across():
    T = from_above(HAND, 0.01, 0.12)
    np.testing.assert_allclose(T[:3, :3] @ HAND.approach_axis, [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(T[:3, :3] @ HAND.closing_axis, [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(T[:3, 3], [0.12, 0, 0.01])
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)


def test_without_an_error_every_hand_wider_than_the_part_holds():
    assert isinstance(rule(0.075), GraspRule)
    for opening_m in (0.055, 0.075, 0.10):
        assert rule(opening_m).holds(draws()).all()


def test_a_hand_no_wider_than_the_part_never_holds():
    assert not rule(0.045).holds(draws(y_m=[0.0, 0.01])).any()


def test_the_error_along_the_part_does_not_matter_as_long_as_there_is_part():
    np.testing.assert_array_equal(rule(0.075).holds(draws(x_m=[0.02, 0.10, 0.18, 0.25])), [True, True, True, False])


def test_across_the_part_the_margin_is_half_of_what_the_opening_leaves():
    for opening_m in (0.075, 0.10):
        margin_m = (opening_m - 0.05) / 2
        inside = rule(opening_m).holds(draws(y_m=[-margin_m + 1e-3, margin_m - 1e-3]))
        outside = rule(opening_m).holds(draws(y_m=[-margin_m - 1e-3, margin_m + 1e-3]))
        assert inside.all()
        assert not outside.any()


def test_half_a_turn_is_the_same_grasp_and_a_quarter_is_none():
    np.testing.assert_array_equal(rule(0.075).holds(draws(theta_rad=[np.pi, np.pi / 2])), [True, False])


def test_far_from_the_centre_a_turn_of_the_estimate_moves_the_hand_across():
    near, far = (GeometricRule(HAND, LEG, from_above(HAND, 0.005, along_m)) for along_m in (0.0, 0.15))
    turned = draws(theta_rad=[0.1])  # 15 mm across at 15 cm
    assert near.holds(turned).all()
    assert not far.holds(turned).any()


def test_the_hand_is_placed_by_the_estimate():
    T = rule(0.075).poses(draws(0.03, -0.02, 0.3))[0]
    np.testing.assert_allclose(T[:3, 3], [0.03, -0.02, 0.005])
    closing = T[:3, :3] @ HAND.closing_axis
    np.testing.assert_allclose(closing, [-np.sin(0.3), np.cos(0.3), 0.0], atol=1e-12)


def test_a_wider_hand_holds_whatever_a_narrower_one_holds():
    family = ErrorFamily(median_m=0.0276, theta_median_rad=0.1, shape=2.46)
    drawn = family.draw(300, np.random.default_rng(3))
    held = [rule(opening_m).holds(drawn) for opening_m in (0.075, 0.085, 0.10)]
    for narrow, wide in ((0, 1), (1, 2)):
        assert (held[wide] >= held[narrow]).all()
        assert held[wide].sum() > held[narrow].sum()
