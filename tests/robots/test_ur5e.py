"""The UR5e's URDF is its published kinematics, a sound model, and a hand of 85 mm."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.robots import always_touching, check_urdf, load_robot
from rfcompass.robots.layouts import data_folder

URDF = data_folder() / "ur5e_2f85.urdf"
ROBOT = load_robot(URDF)
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
