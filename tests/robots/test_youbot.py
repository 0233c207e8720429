"""The youBot agrees with what is published about it, and with what we decided about its hand and tags."""

from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

from rfcompass.errors import UnknownRobot
from rfcompass.robots import YouBot
from rfcompass.robots.layouts import data_folder
from rfcompass.robots.urdf_xml import pose

ROBOT = YouBot()
DEGREES = np.pi / 180
JOINT_1_ZERO = 169 * DEGREES

# Published tree of the arm: parent placement (xyz, then rpy in degrees), axis, limits. Joint 1 has 170 degrees there.
PUBLISHED = [
    ((0.143 + 0.024, 0, 0.046 + 0.096), (0, 0, 170), (0, 0, -1), (0, 5.899213)),
    ((0.033, 0, 0.019), (0, -65, 0), (0, 1, 0), (0, 2.705260)),
    ((0, 0, 0.155), (0, 146, 0), (0, 1, 0), (-5.183628, 0)),
    ((0, 0, 0.135), (0, -102.5, 0), (0, 1, 0), (0, 3.577925)),
    ((-0.002, 0, 0.130), (0, 0, 167.5), (0, 0, -1), (0, 5.846853)),
]
FLOOR_TO_BASE_LINK = pin.SE3(np.eye(3), np.array([0, 0, 0.084]))


def arms(count=50):
    """Random values of the seven joints inside their limits, (count, 7)."""
    rng = np.random.default_rng(7)
    return rng.uniform(ROBOT.limits.lower, ROBOT.limits.upper, (count, 7))


def dh(theta, d, a, alpha):
    """Standard Denavit-Hartenberg transform."""
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])


def dh_arm(q, last_d):
    """The arm's published Denavit-Hartenberg table, from base_footprint."""
    start = pin.SE3(np.eye(3), np.array([0.167, 0, 0.046 + 0.084])).homogeneous
    rows = [
        (JOINT_1_ZERO - q[0], 0.115, 0.033, -np.pi / 2),
        (q[1] - 155 * DEGREES, 0, 0.155, 0),
        (q[2] + 146 * DEGREES, 0, 0.135, 0),
        (q[3] - 12.5 * DEGREES, 0, -0.002, np.pi / 2),
        (167.5 * DEGREES - q[4], last_d, 0, 0),
    ]
    return np.linalg.multi_dot([start, *(dh(*row) for row in rows)])


@pytest.mark.parametrize(("link", "last_d"), [("arm_link_5", 0.130), ("gripper_tool_link", 0.2176)])
def test_forward_kinematics_equal_the_dh_table(link, last_d):
    for q in arms():
        T = ROBOT.link_pose(ROBOT.configuration(q), link).homogeneous
        assert np.abs(T - dh_arm(q, last_d)).max() < 1e-9


def test_forward_kinematics_equal_the_published_tree_with_joint_1_shifted_by_one_degree():
    model, parent = pin.Model(), 0
    for xyz, rpy, axis, _ in PUBLISHED:
        placement = pin.SE3(pin.rpy.rpyToMatrix(np.array(rpy) * DEGREES), np.array(xyz, dtype=float))
        joint = pin.JointModelRevoluteUnaligned(np.array(axis, dtype=float))
        parent = model.addJoint(parent, joint, placement, f"arm_joint_{parent + 1}")
    data = model.createData()
    for q in arms():
        published = q[:5] + np.array([1 * DEGREES, 0, 0, 0, 0])
        pin.forwardKinematics(model, data, published)
        for i in range(1, 6):
            T = ROBOT.link_pose(ROBOT.configuration(q), f"arm_link_{i}").homogeneous
            assert np.abs(T - (FLOOR_TO_BASE_LINK * data.oMi[i]).homogeneous).max() < 1e-6


def test_joints_and_their_limits_are_the_published_ones():
    fingers = ("gripper_finger_joint_l", "gripper_finger_joint_r")
    assert ROBOT.joint_names == (*(f"arm_joint_{i}" for i in range(1, 6)), *fingers)
    assert ROBOT.arm_joints == ROBOT.joint_names[:5]
    expected = np.array([limits for *_, limits in PUBLISHED])
    assert np.allclose(np.stack([ROBOT.limits.lower, ROBOT.limits.upper], axis=1)[:5], expected)
    soft = [(0.01007, 5.84014), (0.01007, 2.61799), (-5.02655, -0.01571), (0.02212, 3.42920), (0.11062, 5.64159)]
    assert np.allclose(np.stack([ROBOT.limits.soft_lower, ROBOT.limits.soft_upper], axis=1)[:5], soft)
    assert np.allclose(ROBOT.limits.velocity[:5], np.pi / 2)


def test_joint_1_can_turn_equally_far_to_both_sides_of_straight_ahead():
    assert ROBOT.limits.upper[0] == pytest.approx(2 * JOINT_1_ZERO, abs=1e-6)
    T = ROBOT.tool_pose(ROBOT.configuration({"arm_joint_1": JOINT_1_ZERO, "arm_joint_2": 2.0}))
    assert T.translation[1] == pytest.approx(0, abs=1e-12)
    assert T.translation[0] > 0.167


def test_the_upright_arm_is_as_high_as_published():
    height_m = ROBOT.tool_pose(ROBOT.posture("candle")).translation[2]
    assert height_m == pytest.approx(0.245 + 0.155 + 0.135 + 0.2176)


def test_the_scan_posture_points_the_open_hand_straight_down_in_front():
    T = ROBOT.tool_pose(ROBOT.posture("scan"))
    assert T.translation == pytest.approx([0.42, 0, 0.10], abs=1e-9)
    assert T.rotation @ ROBOT.tool.approach_axis == pytest.approx([0, 0, -1], abs=1e-9)
    assert opening_m(ROBOT.posture("scan")) == pytest.approx(0.075)


@pytest.mark.parametrize("name", ["folded", "candle", "scan"])
def test_postures_keep_the_soft_limits(name):
    ROBOT.check_limits(ROBOT.posture(name), soft=True)


def corners_in_tool(shape, T_base_tool):
    """Corners of a box in the tool frame [m], (8, 3)."""
    signs = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T
    corners = np.c_[signs * shape.dimensions_m, np.ones(8)]
    return (np.linalg.inv(T_base_tool.homogeneous) @ shape.T_world_shape @ corners.T).T[:, :3]


def fingers(configuration):
    T = ROBOT.tool_pose(configuration)
    shapes = ROBOT.visual_shapes(configuration)
    return {
        side: np.vstack([corners_in_tool(s, T) for s in shapes if s.link == f"gripper_finger_link_{side}"])
        for side in "lr"
    }


def opening_m(configuration):
    corners = fingers(configuration)
    return corners["l"][:, 1].min() - corners["r"][:, 1].max()


def test_the_hand_opens_as_in_the_paper_and_ends_at_the_tool_frame():
    for travel_m, expected_m in [(0.0, 0.025), (0.0125, 0.050), (0.025, 0.075)]:
        fingers_at = {"gripper_finger_joint_l": travel_m, "gripper_finger_joint_r": travel_m}
        configuration = ROBOT.configuration(fingers_at)
        assert opening_m(configuration) == pytest.approx(expected_m)
        for corners in fingers(configuration).values():
            assert corners[:, 2].max() == pytest.approx(0, abs=1e-12)
    assert ROBOT.limits.upper[5:] == pytest.approx([0.025, 0.025])


def test_the_wheels_stand_on_the_floor_where_the_odometry_puts_them():
    wheels = [shape for shape in ROBOT.visual_shapes(ROBOT.configuration()) if shape.link.startswith("wheel")]
    assert len(wheels) == 4
    for wheel in wheels:
        assert np.abs(wheel.T_world_shape[:2, 3]) == pytest.approx([0.235, 0.150])
        assert wheel.T_world_shape[2, 3] == pytest.approx(wheel.dimensions_m[0])
        assert abs(wheel.T_world_shape[:3, 2] @ [0, 1, 0]) == pytest.approx(1)


def test_nine_tags_lie_where_the_default_layout_has_them():
    configuration = ROBOT.posture("scan")
    expected_base = [(0.297, 0.110, 0.062), (0.297, -0.110, 0.062), (0, 0.180, 0.062), (0, -0.180, 0.062)]
    points_m = ROBOT.tag_positions(configuration).points_m
    assert points_m[2:6] == pytest.approx(np.array(expected_base))
    assert points_m[8] == pytest.approx([-0.159, 0, 0.209])
    hand = [(0, 0.060), (0, -0.060), (-0.075, 0), (0.075, 0)]  # with the tool down, fore and aft change sign
    for point_m, (dx, dy) in zip(points_m[[0, 1, 6, 7]], hand, strict=True):
        assert point_m == pytest.approx([0.42 + dx, dy, 0.10 + 0.0876 + 0.015])


def test_the_tag_links_in_the_file_are_those_of_the_default_layout():
    root = ElementTree.parse(data_folder() / "youbot.urdf").getroot()
    joints = {joint.find("child").get("link"): joint for joint in root.findall("joint")}
    tags = [name for name in joints if name.startswith("tag_")]
    assert tags == [f"tag_{i}" for i in range(1, 10)]
    for name, frame, point_m in zip(tags, ROBOT.layout.frames, ROBOT.layout.points_m, strict=True):
        assert joints[name].get("type") == "fixed"
        assert joints[name].find("parent").get("link") == frame
        T = pose(joints[name].find("origin"))
        assert T[:3, 3] == pytest.approx(point_m)
        assert T[:3, 2] == pytest.approx([0, 0, 1])


@pytest.mark.parametrize(("layout", "tags", "roles"), [("x4", 9, 6), ("l0", 9, 5), ("skew6", 6, 4)])
def test_every_layout_has_the_hand_tags_and_a_counterpart_for_up_to_four_part_tags(layout, tags, roles):
    mounted = YouBot(layout).layout
    assert len(mounted.epcs) == tags
    assert len(set(mounted.roles)) == roles
    assert len(mounted.with_role("hand_left")) == len(mounted.with_role("hand_right")) == 1
    assert len(mounted.with_role("base_front")) == 2
    assert (len(mounted.with_role("base_end")) > 0) == (layout != "skew6")
    assert set(mounted.counterparts) == {1, 2, 3, 4}


def test_hand_tags_lie_left_and_right_along_the_closing_axis():
    for layout in ("x4", "l0", "skew6"):
        robot = YouBot(layout)
        configuration = robot.posture("scan")
        points_m = robot.tag_positions(configuration).points_m
        (left,), (right,) = robot.layout.with_role("hand_left"), robot.layout.with_role("hand_right")
        closing = robot.tool_pose(configuration).rotation @ robot.tool.closing_axis
        assert (points_m[left] - points_m[right]) == pytest.approx(0.12 * closing)


def test_an_unknown_layout_lists_the_known_ones():
    with pytest.raises(UnknownRobot, match=r"youbot_skew6.*youbot_x4"):
        YouBot("x5")


def inertia_about_centre(shape, mass):
    """Inertia of one primitive about its own centre and axes [kg m²]."""
    if shape.tag == "box":
        x, y, z = (float(word) for word in shape.get("size").split())
        return mass / 12 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
    r, h = float(shape.get("radius")), float(shape.get("length"))
    across = mass / 12 * (3 * r * r + h * h)
    return np.diag([across, across, mass / 2 * r * r])


def volume_m3(shape):
    if shape.tag == "box":
        return np.prod([float(word) for word in shape.get("size").split()])
    return np.pi * float(shape.get("radius")) ** 2 * float(shape.get("length"))


LINKS = ElementTree.parse(data_folder() / "youbot.urdf").getroot().findall("link")
HEAVY = [link for link in LINKS if link.find("inertial") is not None]


@pytest.mark.parametrize("link", HEAVY, ids=lambda link: link.get("name"))
def test_inertia_is_that_of_the_collision_shapes_filled_uniformly(link):
    solids = [(pose(part.find("origin")), part.find("geometry")[0]) for part in link.findall("collision")]
    total = sum(volume_m3(shape) for _, shape in solids)
    inertial = link.find("inertial")
    mass = float(inertial.find("mass").get("value"))
    centre = sum(volume_m3(shape) / total * T[:3, 3] for T, shape in solids)
    expected = np.zeros((3, 3))
    for T, shape in solids:
        share, R, off = mass * volume_m3(shape) / total, T[:3, :3], T[:3, 3] - centre
        expected += R @ inertia_about_centre(shape, share) @ R.T + share * (off @ off * np.eye(3) - np.outer(off, off))
    stated = inertial.find("inertia").attrib
    matrix = np.array([[float(stated["i" + "".join(sorted(a + b))]) for b in "xyz"] for a in "xyz"])
    assert pose(inertial.find("origin"))[:3, 3] == pytest.approx(centre, abs=1e-8)
    assert matrix == pytest.approx(expected, rel=1e-5, abs=1e-9)


def test_the_base_with_its_wheels_weighs_20_kg_and_only_frames_weigh_nothing():
    mass = {link.get("name"): float(link.find("inertial/mass").get("value")) for link in HEAVY}
    wheels = [mass[f"wheel_link_{corner}"] for corner in ("fl", "fr", "bl", "br")]
    assert mass["base_link"] + sum(wheels) == pytest.approx(20)
    weightless = {link.get("name") for link in LINKS} - set(mass)
    assert weightless == {"base_footprint", "gripper_tool_link", *(f"tag_{i}" for i in range(1, 10))}
