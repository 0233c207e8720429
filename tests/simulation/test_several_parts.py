"""Several parts in one room: one is sought, the others stay where they are, and what is put down stays there."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError, SceneError
from rfcompass.geometry import Pose2
from rfcompass.interfaces import HandOpener
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.types import GraspOutcome

ROBOT = YouBot()
LEGS = PartDatabase(":memory:").assembly("LACK")
FIRST, SECOND = LEGS[:2]
ROOM = PlaneRoom(T_room_base=Pose2(2.0, 2.0, 0.3), T_room_part=Pose2(3.0, 2.5, 1.0))


def a_room(seed=0):
    return ROOM.with_others([(leg, leg.layout(4)) for leg in LEGS[1:]], np.random.default_rng(seed))


def a_robot(sensor=None, room=None, kind=SimulatedRobot):
    layout, rng = FIRST.layout(4), np.random.default_rng(1)
    joints = ROBOT.posture("scan").joints
    return kind(ROBOT, FIRST, layout, room or a_room(), rng, joints, sensor or NoisyDistances(0.0))


def a_radio(room):
    return RadioSetup(scene="free_space").sensor(room, ROBOT.layout, FIRST.layout(4), np.random.default_rng(2))


@given(st.integers(0, 50))
def test_parts_lie_apart_from_each_other_and_from_the_robot(seed):
    room = a_room(seed)
    poses = [room.T_room_base, room.T_room_part, *(one.T_room_part for one in room.others)]
    places_m = np.array([pose.translation_m for pose in poses])
    gaps_m = np.linalg.norm(places_m[:, None] - places_m[None], axis=2)[np.triu_indices(5, 1)]
    assert (gaps_m[1:] >= 0.8 - 1e-12).all()


def test_without_others_nothing_is_drawn():
    rng = np.random.default_rng(0)
    assert ROOM.with_others([], rng) == ROOM
    assert rng.random() == np.random.default_rng(0).random()


def test_a_full_room_is_refused():
    with pytest.raises(SceneError):
        ROOM.with_others([(SECOND, SECOND.layout(4))], np.random.default_rng(0), ((0.0, 0.0), (4.0, 4.0)), 9.0)


def test_the_robot_hears_the_part_that_it_was_sent_for_from_where_that_truly_lies():
    robot = a_robot()
    for leg in (SECOND, FIRST, LEGS[3]):
        poses = {one.part.part_id: one.T_room_part for one in a_room().others} | {FIRST.part_id: ROOM.T_room_part}
        robot.seek(leg.part_id)
        seen = robot.scan()
        pose = robot.true_pose_in_room().inverse() @ poses[leg.part_id]
        assert seen.part.epcs == leg.layout(4).epcs
        for k, point in enumerate(seen.part.points_m):
            tag = np.append(pose.apply(point[:2]), seen.part_tag_heights_m[k])
            assert np.allclose(seen.proximity.m[k], np.linalg.norm(tag - seen.anchors.points_m, axis=1))


def test_a_part_that_is_not_there_cannot_be_sought():
    with pytest.raises(InputError, match="lies in the room"):
        a_robot(room=ROOM).seek(SECOND.part_id)


def test_by_radio_every_part_is_heard_whichever_is_sought_and_its_tags_keep_their_constants():
    room = a_room()
    robot = a_robot(a_radio(room), room)
    before = {tags.epcs: tags for tags in (robot.sensor.part_tags, *robot.sensor.other_tags)}
    robot.seek(SECOND.part_id)
    after = {tags.epcs: tags for tags in (robot.sensor.part_tags, *robot.sensor.other_tags)}
    assert robot.sensor.part_tags.epcs == SECOND.layout(4).epcs
    assert set(after) == set(before) == {leg.layout(4).epcs for leg in LEGS}
    for epcs, tags in after.items():
        assert np.array_equal(tags.phase_rad, before[epcs].phase_rad)
        assert np.array_equal(tags.gain_db, before[epcs].gain_db)


class Sure(SimulatedRobot):
    """A hand that always holds."""

    def close_hand(self):
        T_room_part = np.eye(4)
        pose = self.room.T_room_part
        T_room_part[:2, :2], T_room_part[:2, 3] = pose.rotation, pose.translation_m
        T_room_part[2, 3] = self.part.resting_height_m
        tool = self.robot.tool_pose(self.configuration).homogeneous
        T_room_base = np.eye(4)
        T_room_base[:2, :2], T_room_base[:2, 3] = self._true.rotation, self._true.translation_m
        self._T_hand_held = np.linalg.inv(T_room_base @ tool) @ T_room_part
        return GraspOutcome(True)


def test_what_is_put_down_has_moved_with_the_robot_and_its_tags_are_heard_from_there():
    room = a_room()
    robot = a_robot(a_radio(room), room, Sure)
    before = robot.true_pose_in_base()
    robot.close_hand()
    robot.move_base(Pose2(0.3, -0.2, 1.0))
    robot.open_hand()
    after = robot.true_pose_in_base()
    assert np.allclose(after.translation_m, before.translation_m)
    assert np.isclose(after.theta_rad, before.theta_rad)
    assert abs(robot.true_drop_m()) < 1e-12
    state = robot.true_state()
    robot.seek(SECOND.part_id)
    left = next(tags for tags in robot.sensor.other_tags if tags.epcs == FIRST.layout(4).epcs)
    assert np.allclose(left.points_m, state.targets.points_m)


def test_a_full_hand_is_sent_for_nothing_and_an_empty_one_lets_nothing_go():
    room = a_room()
    robot = a_robot(None, room, Sure)
    robot.open_hand()
    assert robot.room is room
    robot.close_hand()
    with pytest.raises(InputError, match="still in the hand"):
        robot.seek(SECOND.part_id)


def test_the_simulated_robot_can_open_its_hand_as_a_real_one():
    assert isinstance(a_robot(), HandOpener)


def test_broken_tags_are_never_heard_and_nothing_else_changes():
    epcs = FIRST.layout(4).epcs
    whole, broken = a_robot().scan(), a_robot(NoisyDistances(0.0, frozenset(epcs[:2]))).scan()
    assert np.isnan(broken.proximity.m[:2]).all()
    assert np.array_equal(broken.proximity.m[2:], whole.proximity.m[2:])
    room = a_room()
    heard = a_robot(a_radio(room).silenced(epcs), room).scan().scan
    assert not set(epcs) & set(heard.traces)
