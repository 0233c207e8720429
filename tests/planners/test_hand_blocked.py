"""What stands where the hand would be is told before arm and base are asked, and they would say the same."""

import numpy as np
import pytest
from grasp_scenes import LEG, ROBOT, box_at, estimate
from hypothesis import given
from hypothesis import strategies as st

from planners import grasp, grasp_elsewhere, grasp_stages
from planners.grasp import GraspPlanner
from planners.hand_blocked import hand_blocked
from rfcompass.robots import CollisionModel, QuickCollisions
from rfcompass.types import Box, GraspPlan, World
from rfcompass.types.world import Body

HAND_LINKS = {"gripper_palm_link", "gripper_finger_link_l", "gripper_finger_link_r", "arm_link_5"}


def opened(joints):
    return ROBOT.configuration([*joints, 0.025, 0.025])


limits = list(zip(ROBOT.limits.soft_lower[:5], ROBOT.limits.soft_upper[:5], strict=True))
arms = st.tuples(*(st.floats(float(low), float(high)) for low, high in limits))
places = st.tuples(st.floats(0.2, 0.6), st.floats(-0.3, 0.3), st.floats(0.0, 0.5))


@given(arms, places, st.floats(0.01, 0.2))
def test_it_is_what_a_check_of_the_whole_robot_finds_at_the_hand(arm, place, edge_m):
    at = opened(arm)
    model = CollisionModel(ROBOT, World((box_at("crate", (edge_m, edge_m, edge_m), *place), LEG_BODY)))
    touching = QuickCollisions(model).touching(at)
    hand_touches = any(row.first in HAND_LINKS and row.second == "crate" for row in touching)
    deep_enough = not touching or min(abs(row.distance_m) for row in touching) > 1e-6
    failure = hand_blocked(model, opened(np.zeros(5)), LEG.part_id)(ROBOT.tool_pose(at).homogeneous)
    if deep_enough:
        assert (failure is not None) == hand_touches
    if failure is not None:
        assert dict(failure.numbers)["second"] == "crate"


LEG_BODY = Body(LEG.part_id, LEG.shape, np.array([[1, 0, 0, 0.42], [0, 1, 0, 0], [0, 0, 1, 0.025], [0, 0, 0, 1.0]]))


def enclosed():
    """Four walls and a lid, 1 cm from a leg that lies across at y = 0.03."""
    length, width = LEG.size_m[:2]
    frame = box_at("part", (1, 1, 1), 0.42, 0.03, 0.0, 1.4).T_parent_body
    rows = {
        "left": ((length + 0.06, 0.02, 0.06), (0, width / 2 + 0.02, 0.03)),
        "right": ((length + 0.06, 0.02, 0.06), (0, -width / 2 - 0.02, 0.03)),
        "front": ((0.02, width + 0.02, 0.06), (length / 2 + 0.02, 0, 0.03)),
        "back": ((0.02, width + 0.02, 0.06), (-length / 2 - 0.02, 0, 0.03)),
        "lid": ((length + 0.06, width + 0.06, 0.02), (0, 0, 0.075)),
    }
    return World(tuple(Body(name, Box(np.array(size)), placed(frame, at)) for name, (size, at) in rows.items()))


def placed(frame, at):
    T = np.eye(4)
    T[:3, 3] = at
    return frame @ T


LIES_ACROSS = estimate(y=0.0, theta=np.pi / 2)
PILLAR = World((box_at("pillar", (0.04, 0.06, 0.5), 0.48, 0.0, 0.25),))


@pytest.fixture
def unasked(monkeypatch):
    """A planner that finds out only by asking arm and base."""

    def plan(world, where):
        with monkeypatch.context() as patched:
            for module in (grasp_stages, grasp_elsewhere):
                patched.setattr(module, "hand_blocked", lambda *_: lambda _: None)
            return GraspPlanner(ROBOT).plan(LEG, where, world)

    return plan


@pytest.mark.parametrize("world", [World(), PILLAR], ids=["open", "pillar"])
def test_a_plan_is_the_same_as_without_asking(world, unasked):
    asked, slow = GraspPlanner(ROBOT).plan(LEG, LIES_ACROSS, world), unasked(world, LIES_ACROSS)
    assert isinstance(asked, GraspPlan)
    assert np.array_equal(asked.T_base_hand, slow.T_base_hand)
    assert (asked.success_probability, asked.clearance_m) == (slow.success_probability, slow.clearance_m)
    assert all(np.array_equal(a.joints, b.joints) for a, b in zip(asked.stages, slow.stages, strict=True))


def test_a_failure_is_the_same_as_without_asking(unasked):
    asked, slow = GraspPlanner(ROBOT).plan(LEG, estimate(), enclosed()), unasked(enclosed(), estimate())
    assert (asked.kind, asked.base, asked.reasons) == (slow.kind, None, slow.reasons)
    blockers = {dict(row.rejection.numbers).get("second") for row in asked.candidates if row.rejection}
    assert blockers & {"left", "right", "lid"}


def test_arm_and_base_are_not_asked_where_the_part_is_enclosed(monkeypatch):
    def never(*_args, **_options):
        pytest.fail("asked")

    monkeypatch.setattr(grasp.StagePlanner, "plan", never)
    monkeypatch.setattr(grasp_elsewhere.InverseKinematics, "solve", never)
    assert GraspPlanner(ROBOT).plan(LEG, estimate(), enclosed()).kind == "no_grasp"
