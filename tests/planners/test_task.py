"""The task layer: what is to be done with each part, in order; wrong tasks are refused by name."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.task import DELIVER, GAP_M, VERBS, RelativeLocation, parts_of_task, plan_task, row_at_the_start
from rfcompass.errors import InputError, PartError, UnknownPart
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.types import PartEstimate

DATABASE = PartDatabase(":memory:")
LEGS = parts_of_task(DATABASE, (), "LACK")
NAMES = tuple(leg.part_id for leg in LEGS)


def test_a_table_is_its_four_legs_in_the_order_of_the_database():
    assert NAMES == ("table_leg_1", "table_leg_2", "table_leg_3", "table_leg_4")


def test_every_leg_is_navigated_to_localised_grasped_and_delivered_before_the_next():
    actions = [action for one in plan_task(LEGS, 4, Pose2()) for action in one.actions]
    assert [(action.part_id, action.verb) for action in actions] == [(name, verb) for name in NAMES for verb in VERBS]
    assert all((action.goal is not None) == (action.verb == DELIVER) for action in actions)


@pytest.mark.parametrize("tags", [2, 4])
def test_the_tags_are_those_of_the_part_database(tags):
    for leg, one in zip(LEGS, plan_task(LEGS, tags, Pose2()), strict=True):
        assert all(action.epcs == leg.layout(tags).epcs for action in one.actions)
        assert all(DATABASE.part_of_epc(epc).part_id == leg.part_id for epc in one.actions[0].epcs)


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3))
def test_goals_are_a_row_towards_the_robot_with_room_for_the_hand(x_m, y_m, theta_rad):
    first = Pose2(x_m, y_m, theta_rad)
    goals = [first.inverse() @ one.goal for one in plan_task(LEGS, 4, first)]
    assert np.allclose([goal.x_m for goal in goals], 0.0, atol=1e-9)
    assert np.allclose([goal.theta_rad for goal in goals], 0.0, atol=1e-9)
    for (one, goal), (other, after) in pairwise(zip(LEGS, goals, strict=True)):
        free_m = goal.y_m - after.y_m - (one.size_m[1] + other.size_m[1]) / 2
        assert np.isclose(free_m, GAP_M)


def test_unasked_the_row_lies_under_the_hand_as_the_robot_stands_at_its_start():
    goals = [one.goal for one in plan_task(LEGS, 4, row_at_the_start(LEGS))]
    assert np.allclose(np.mean([goal.translation_m for goal in goals], axis=0), [0.42, 0.0])
    assert (np.diff([goal.x_m for goal in goals]) < 0).all()  # the first lies farthest: nothing is driven over


def test_an_action_says_in_one_line_what_to_do_with_what_and_where():
    navigate, *_, deliver = plan_task(LEGS[:1], 4, Pose2(1.0, -2.0, 0.5))[0].actions
    assert str(navigate).split() == ["navigate", "table_leg_1"]
    assert "x 1.00 m, y -2.00 m, θ 0.50 rad" in str(deliver)


def test_an_estimate_reaches_the_planner_as_direction_distance_and_orientation():
    found = RelativeLocation.of(PartEstimate("table_leg_1", np.array([-3.0, 4.0]), 0.3, "told", 1))
    assert np.allclose([found.phi_rad, found.D_m, found.theta_rad], [np.arctan2(4.0, -3.0), 5.0, 0.3])
    assert RelativeLocation.of(PartEstimate("table_leg_1", np.ones(2), None, "told", 1)).theta_rad is None


@pytest.mark.parametrize(
    ("names", "assembly", "kind"),
    [
        (("table_leg_9",), None, UnknownPart),
        (("table_leg_1", "table_leg_2", "table_leg_1"), None, InputError),
        ((), "BILLY", UnknownPart),
        (("table_leg_1",), "LACK", InputError),
        ((), None, InputError),
    ],
)
def test_a_task_that_cannot_be_is_refused(names, assembly, kind):
    with pytest.raises(kind):
        parts_of_task(DATABASE, names, assembly)


def test_a_part_without_so_many_tags_is_refused():
    with pytest.raises(PartError):
        plan_task(LEGS, 7, Pose2())
