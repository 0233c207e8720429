import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.hand_over import hand_over
from rfcompass.errors import OutOfReach
from rfcompass.geometry import angle_difference
from rfcompass.robots import YouBot

ROBOT = YouBot()
START = ROBOT.posture("scan")


@given(st.floats(0.34, 0.44), st.floats(-0.1, 0.1), st.floats(-np.pi, np.pi))
def test_the_hand_is_where_it_was_asked_to_be_and_points_down(x, y, yaw):
    point = np.array([x, y, 0.10])
    found = hand_over(ROBOT, START, point, yaw)
    pose = ROBOT.tool_pose(found)
    assert np.linalg.norm(pose.translation - point) <= 1e-3
    assert np.allclose(pose.rotation @ ROBOT.tool.approach_axis, [0, 0, -1], atol=0.02)
    closing = pose.rotation @ ROBOT.tool.closing_axis
    assert abs(angle_difference(np.arctan2(closing[1], closing[0]), yaw, np.pi)) < 0.02
    ROBOT.check_limits(found, soft=True)


def test_the_fingers_keep_their_opening():
    found = hand_over(ROBOT, START, np.array([0.4, 0.05, 0.1]), 0.3)
    fingers = [ROBOT.joint_names.index(name) for name in ROBOT.joint_names if "finger" in name]
    assert np.array_equal(found.joints[fingers], START.joints[fingers])


def test_the_same_question_has_the_same_answer():
    asked = (ROBOT, START, np.array([0.38, -0.05, 0.1]), 1.0)
    assert np.array_equal(hand_over(*asked).joints, hand_over(*asked).joints)


def test_a_point_out_of_reach_says_by_how_much():
    with pytest.raises(OutOfReach) as caught:
        hand_over(ROBOT, START, np.array([1.5, 0.0, 0.1]), 0.0)
    assert caught.value.numbers["miss_m"] > 0.5
