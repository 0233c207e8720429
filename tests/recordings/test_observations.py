"""A trace with stops becomes observations, with forward kinematics at every stop."""

from dataclasses import replace

import numpy as np
import pytest

from rfcompass.errors import JointLimitError, TagNeverHeard, TraceError
from rfcompass.recordings import AntennaPoses, PartDatabase, Stops, Trace, TraceMeta, TraceTag, reads_table
from rfcompass.robots import YouBot
from rfcompass.types import ProximityMatrix

ROBOT = YouBot()
LEGS = PartDatabase(":memory:")
LEG = LEGS.part("table_leg_3")


def a_trace(postures=("folded", "scan"), K=2):
    layout, robot = LEG.layout(K), ROBOT.layout
    between = np.full((9, 9), np.nan)
    matrix = ProximityMatrix(layout.epcs, robot.epcs, np.arange(1.0, 9 * K + 1).reshape(K, 9), between, "distance")
    stops = Stops(
        stop_ids=np.arange(len(postures)),
        base_poses=np.array([[0.1 * i, 0.0, 0.2] for i in range(len(postures))]),
        joint_names=ROBOT.joint_names,
        joints=np.array([ROBOT.posture(name).joints for name in postures]),
    )
    meta = TraceMeta(frame="odom", robot="youbot", tags=tuple(TraceTag(epc) for epc in (*layout.epcs, *robot.epcs)))
    poses = AntennaPoses.along(np.zeros((0, 3)))
    return Trace(meta, reads_table((), ()), poses, stops, dict.fromkeys(range(len(postures)), matrix))


def test_anchors_are_where_forward_kinematics_puts_them_at_each_stop():
    for seen, name in zip(a_trace().observations(ROBOT, LEG), ("folded", "scan"), strict=True):
        expected = ROBOT.tag_positions(ROBOT.posture(name))
        assert np.allclose(seen.anchors.points_m, expected.points_m)


def test_the_tags_in_use_are_those_of_the_trace_and_lie_at_their_heights():
    seen = a_trace(K=2).observations(ROBOT, LEG)[0]
    assert seen.part.epcs == LEG.layout(2).epcs
    assert dict(seen.part.counterparts[2]) == dict(LEG.layout(2).counterparts[2])
    assert np.allclose(seen.part_tag_heights_m, 0.025 + seen.part.points_m[:, 2])


def test_a_joint_outside_its_limits_is_named_with_the_stop():
    trace = a_trace()
    joints = trace.stops.joints.copy()
    joints[1, 1] = 9.0
    broken = Trace(
        trace.meta, trace.reads, trace.antenna_poses, replace(trace.stops, joints=joints), dict(trace.proximity)
    )
    with pytest.raises(JointLimitError) as caught:
        broken.observations(ROBOT, LEG)
    assert caught.value.numbers["stop"] == 1
    assert caught.value.numbers["joint"] == ROBOT.joint_names[1]


def test_another_part_was_not_heard():
    with pytest.raises(TagNeverHeard):
        a_trace().observations(ROBOT, LEGS.part("table_leg_1"))


def test_joints_of_another_robot_are_refused():
    trace = a_trace()
    stops = replace(trace.stops, joint_names=("elbow", *ROBOT.joint_names[1:]))
    with pytest.raises(TraceError, match="elbow"):
        Trace(trace.meta, trace.reads, trace.antenna_poses, stops, dict(trace.proximity)).observations(ROBOT, LEG)
