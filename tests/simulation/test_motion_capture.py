"""Cameras see what nothing hides, place what two of them see, and answer with three placed markers or not at all."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.errors import InputError, NotInView, SceneError
from rfcompass.geometry import Pose2
from rfcompass.interfaces import Localizer
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.simulation import CameraRig, MotionCapture, PlaneRoom, SimulatedRobot
from rfcompass.simulation.motion_capture import NoReader, part_markers_m, robot_markers_m
from rfcompass.types.scene import Material, Obstacle, Room, Scene
from rfcompass.types.shapes import Box, Cylinder

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
ROOM = Room(np.array([6.0, 5.0, 2.7]), "air", "air", "air")
AIR = {"air": Material("air")}
EMPTY = Scene("empty", ROOM, (), AIR)
RIG = CameraRig.under_ceiling(ROOM)
poses = st.builds(Pose2, st.floats(1, 5), st.floats(1, 4), st.floats(-3, 3))


def standing(shape, at_m, yaw_rad=0.0):
    T = np.eye(4)
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    T[:2, :2], T[:3, 3] = [[c, -s], [s, c]], at_m
    return Obstacle("thing", shape, T, "air")


def scene_with(obstacle):
    return Scene("one thing", ROOM, (obstacle,), AIR)


def a_device(T_room_base=None, T_room_part=None):
    room = PlaneRoom(T_room_base=T_room_base or Pose2(1.5, 1.5, 0.3), T_room_part=T_room_part or Pose2(4, 3, 1.0))
    joints = ROBOT.posture("scan").joints
    return SimulatedRobot(ROBOT, LEG, LEG.layout(2), room, np.random.default_rng(0), joints, NoReader())


def test_eight_cameras_hang_inside_the_room_under_its_ceiling():
    assert len(np.unique(RIG.cameras_m, axis=0)) == 8
    assert ((RIG.cameras_m > 0) & (RIG.cameras_m < ROOM.size_m)).all()
    assert np.allclose(RIG.cameras_m[:, 2], 2.6)


def test_the_paper_has_ten_markers_on_the_robot_and_four_on_the_part():
    assert robot_markers_m().shape == (10, 3)
    assert part_markers_m(LEG).shape == (4, 3)


def test_no_markers_fall_on_each_other_after_a_turn_of_the_body():
    for places_m in (robot_markers_m(), part_markers_m(LEG)):
        for turn in np.linspace(np.pi / 2, 3 * np.pi / 2, 19):
            turned_m = Pose2(0, 0, turn).apply(places_m)
            nearest_m = np.linalg.norm(turned_m[:, None] - places_m[None], axis=2).min(axis=1)
            assert nearest_m.max() > 10 * RIG.sigma_m


def test_a_marker_behind_a_board_is_not_seen_from_the_other_side():
    board = scene_with(standing(Box(np.array([0.03, 5.0, 2.2])), (3.0, 2.5, 1.1)))
    marker_m = np.array([[3.3, 2.5, 0.05]])
    seen = RIG.views(board, marker_m)[:, 0]
    assert not seen[RIG.cameras_m[:, 0] < 2.9].any()
    assert seen[RIG.cameras_m[:, 0] > 3.1].all()


@settings(max_examples=40, deadline=None)
@given(
    st.tuples(st.floats(0.5, 5.5), st.floats(0.5, 4.5), st.floats(0.3, 1.0)),
    st.floats(-3, 3),
    st.tuples(st.floats(0.2, 5.8), st.floats(0.2, 4.8), st.floats(0.0, 0.2)),
    st.sampled_from([Box(np.array([0.8, 0.5, 0.4])), Cylinder(0.3, 0.6, "z")]),
)
def test_a_view_is_free_exactly_if_no_point_of_it_lies_in_the_thing(at_m, yaw_rad, marker_m, shape):
    thing = standing(shape, at_m, yaw_rad)
    seen = RIG.views(scene_with(thing), np.array([marker_m]))[:, 0]
    for camera_m, free in zip(RIG.cameras_m, seen, strict=True):
        points_m = camera_m + np.linspace(0, 1, 4001)[:, None] * (marker_m - camera_m)
        own_m = (points_m - thing.T_scene_obstacle[:3, 3]) @ thing.T_scene_obstacle[:3, :3]
        inside = (np.abs(own_m) < shape.upper_m).all(axis=1)
        if isinstance(shape, Cylinder):
            inside &= np.hypot(own_m[:, 0], own_m[:, 1]) < shape.radius_m
        assert free or inside.any() or _grazes(own_m, shape)
        assert not (free and inside.any())


def _grazes(own_m, shape):
    """Whether the samples pass so near that the thing may lie between two of them."""
    out_m = np.maximum(np.abs(own_m) - shape.upper_m, 0)
    if isinstance(shape, Cylinder):
        out_m[:, :2] = 0
        out_m[:, 0] = np.maximum(np.hypot(own_m[:, 0], own_m[:, 1]) - shape.radius_m, 0)
    return np.linalg.norm(out_m, axis=1).min() < 2e-3


def test_chair_legs_that_no_wave_notices_stop_light():
    leg = scene_with(standing(Cylinder(0.02, 2.0, "z"), (1.0, 1.0, 1.0)))
    camera = CameraRig(cameras_m=np.array([[0.5, 1.0, 1.0]]))
    assert not camera.views(leg, np.array([[1.5, 1.0, 1.0]])).any()
    assert camera.views(leg, np.array([[1.5, 1.3, 1.0]])).all()


def test_one_camera_places_nothing_and_two_do():
    pose, rng = Pose2(3, 2, 0.5), np.random.default_rng(0)
    one, two = CameraRig(cameras_m=RIG.cameras_m[:1]), CameraRig(cameras_m=RIG.cameras_m[:2])
    with pytest.raises(NotInView) as caught:
        one.capture("part", EMPTY, part_markers_m(LEG), pose, rng)
    assert caught.value.numbers == {"body": "part", "markers": 0, "needed": 3}
    assert two.capture("part", EMPTY, part_markers_m(LEG), pose, rng).x_m == pytest.approx(3, abs=0.01)


@pytest.mark.parametrize(("count", "enough"), [(2, False), (3, True), (4, True)])
def test_a_body_needs_three_markers(count, enough):
    markers_m, rng = part_markers_m(LEG)[:count], np.random.default_rng(0)
    if enough:
        RIG.capture("part", EMPTY, markers_m, Pose2(3, 2, 0.5), rng)
    else:
        with pytest.raises(NotInView):
            RIG.capture("part", EMPTY, markers_m, Pose2(3, 2, 0.5), rng)


def test_a_body_under_a_table_is_lost_and_the_error_names_it():
    cover = scene_with(standing(Box(np.array([3.0, 3.0, 0.03])), (4.0, 3.0, 0.4)))
    capture = MotionCapture(RIG, cover, a_device(), np.random.default_rng(0))
    with pytest.raises(NotInView, match="part") as caught:
        capture.estimate([])
    assert caught.value.numbers["body"] == "part"
    assert capture.base_pose(None) is not None


def test_a_robot_under_a_table_does_not_know_where_it_is():
    cover = scene_with(standing(Box(np.array([3.0, 3.0, 0.03])), (1.5, 1.5, 0.4)))
    assert MotionCapture(RIG, cover, a_device(), np.random.default_rng(0)).base_pose(None) is None


@settings(max_examples=30, deadline=None)
@given(poses, poses)
def test_without_noise_the_part_is_where_it_is(T_room_base, T_room_part):
    device = a_device(T_room_base, T_room_part)
    exact = CameraRig.under_ceiling(ROOM, sigma_m=0.0)
    found, truth = MotionCapture(exact, EMPTY, device, device.rng).estimate([]), device.true_pose_in_base()
    assert np.allclose(found.centre_m, truth.translation_m, atol=1e-9)
    assert np.cos(found.theta_rad - truth.theta_rad) == pytest.approx(1.0)


def test_it_stands_where_a_localizer_stands_and_errs_by_millimetres():
    device = a_device()
    capture = MotionCapture(RIG, EMPTY, device, np.random.default_rng(2))
    assert isinstance(capture, Localizer)
    truth = device.true_pose_in_base().translation_m
    off_m = [np.linalg.norm(capture.estimate([]).centre_m - truth) for _ in range(200)]
    assert 2e-4 < np.mean(off_m) < 1e-2


def test_a_scan_without_a_reader_says_nothing():
    heard = a_device().scan().proximity
    assert np.isnan(heard.m).all()
    assert np.isnan(heard.anchor_m).all()


def test_what_cannot_be_is_refused():
    with pytest.raises(InputError):
        CameraRig(cameras_m=RIG.cameras_m, sigma_m=-1.0)
    with pytest.raises(SceneError):
        CameraRig.under_ceiling(ROOM, inset_m=2.0)
