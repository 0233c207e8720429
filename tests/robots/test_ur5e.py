"""The UR5e's URDF is its published kinematics, a sound model, and a hand of 85 mm."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.robots import CollisionModel, QuickCollisions, always_touching, check_urdf, hand_of, load_robot
from rfcompass.robots.layouts import data_folder

URDF = data_folder() / "ur5e_2f85.urdf"
ROBOT, DESCRIBED = load_robot(URDF), load_robot("ur5e_2f85")
# Denavit-Hartenberg parameters as the manufacturer publishes them: d [m], a [m], alpha [rad].
PUBLISHED = (
    (0.1625, 0.0, np.pi / 2),
    (0.0, -0.425, 0.0),
    (0.0, -0.3922, 0.0),
    (0.1333, 0.0, np.pi / 2),
    (0.0997, 0.0, -np.pi / 2),
    (0.0996, 0.0, 0.0),
)


def flange(joints):
    T = np.eye(4)
    for q, (d, a, alpha) in zip(joints, PUBLISHED, strict=True):
        c, s, ca, sa = np.cos(q), np.sin(q), np.cos(alpha), np.sin(alpha)
        T = T @ np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])
    return T


@given(st.lists(st.floats(-3.1, 3.1), min_size=6, max_size=6))
def test_the_flange_is_where_the_published_parameters_put_it(joints):
    configuration = ROBOT.configuration([*joints, 0.0, 0.0])
    assert ROBOT.link_pose(configuration, "tool0").homogeneous == pytest.approx(flange(joints), abs=1e-12)


def test_nothing_is_wrong_with_it():
    report = check_urdf(URDF)
    assert report.ok
    assert report.defects == ()


def test_no_links_touch_everywhere():
    assert always_touching(ROBOT) == ()


def test_the_hand_opens_by_85_mm():
    fingers = [name for name in ROBOT.joint_names if "finger" in name]
    upper = [ROBOT.limits.upper[ROBOT.joint_names.index(name)] for name in fingers]
    assert sum(upper) == pytest.approx(0.085)


def test_by_its_name_it_has_a_hand_a_tool_and_nine_tags():
    hand = hand_of(DESCRIBED)
    assert (hand.least_m, hand.greatest_m) == pytest.approx((0.0, 0.085))
    assert DESCRIBED.joint_names == ROBOT.joint_names
    assert not DESCRIBED.is_mobile
    assert len(DESCRIBED.layout.epcs) == 9
    T_tool0_tool = DESCRIBED.link_pose(DESCRIBED.configuration(), "tool0").inverse() * DESCRIBED.tool_pose(
        DESCRIBED.configuration()
    )
    assert T_tool0_tool.homogeneous == pytest.approx(
        np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.15], [0, 0, 0, 1]])
    )


@pytest.mark.parametrize("name", ["ready", "scan"])
def test_its_postures_point_down_before_the_foot_touch_nothing_and_have_the_hand_open(name):
    posture = DESCRIBED.posture(name)
    pose = DESCRIBED.tool_pose(posture)
    assert pose.rotation @ DESCRIBED.tool.approach_axis == pytest.approx([0, 0, -1], abs=0.02)
    assert 0.4 < pose.translation[0] < 0.6
    assert 0.1 < pose.translation[2] < 0.4
    assert not QuickCollisions(CollisionModel(DESCRIBED, with_tags=True)).collides(posture)
    assert posture.joints[-2:] == pytest.approx([0.0425, 0.0425])


def test_the_camera_looks_along_the_tool_and_does_not_see_the_hand():
    open_hand = DESCRIBED.posture("ready")
    T_camera_base = DESCRIBED.link_pose(open_hand, "camera_optical_link").inverse().homogeneous
    tool = DESCRIBED.tool_pose(open_hand)
    assert T_camera_base[:3, :3] @ tool.rotation @ DESCRIBED.tool.approach_axis == pytest.approx([0, 0, 1], abs=1e-12)
    hand = [shape for shape in DESCRIBED.collision_shapes if "finger" in shape.link or "palm" in shape.link]
    assert len(hand) == 4
    for shape in hand:
        T = T_camera_base @ DESCRIBED.link_pose(open_hand, shape.link).homogeneous @ shape.T_link_shape
        size_m = np.array(shape.dimensions_m)
        half_m = size_m / 2 if shape.kind == "box" else np.array([size_m[0], size_m[0], size_m[1] / 2])
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        points_m = (corners * half_m) @ T[:3, :3].T + T[:3, 3]
        ahead = points_m[points_m[:, 2] > 0]
        assert (np.abs(ahead[:, 1] / ahead[:, 2]) > np.tan(np.radians(20.0))).all()


def test_the_transmitter_is_where_the_wrist_rig_has_it():
    still = DESCRIBED.configuration()
    receiver, transmitter = (DESCRIBED.link_pose(still, f"antenna_{name}_link") for name in ("rx", "tx"))
    T = (receiver.inverse() * transmitter).homogeneous
    assert pytest.approx(np.array([[1, 0, 0, 0], [0, 1, 0, 0.10], [0, 0, 1, 0], [0, 0, 0, 1]]), abs=1e-12) == T
    boresight = receiver.rotation[:, 0]
    assert boresight == pytest.approx(DESCRIBED.tool_pose(still).rotation @ DESCRIBED.tool.approach_axis, abs=1e-12)
