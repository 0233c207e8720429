"""Frames and values survive the trip to the last bit; what is no frame is refused in a typed way."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from same_records import differences

from rfcompass.errors import JointLimitError, RfCompassError, RobotFormatError, RobotRefused
from rfcompass.geometry import Pose2
from rfcompass.recordings.robot_link import decode_frame, encode_frame
from rfcompass.recordings.robot_link import values as v
from rfcompass.recordings.robot_link.errors_json import error_json, error_of
from rfcompass.recordings.robot_link.frames import frame_id
from rfcompass.types import Failure, GraspOutcome, RobotState

finite = st.floats(allow_nan=False, allow_infinity=False)
moderate = st.floats(-1e6, 1e6)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**63) | finite | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)


def travelled(content):
    return decode_frame(encode_frame({"it": content})[:-1])["it"]


@given(finite)
def test_a_float_comes_back_with_the_same_bits(value):
    assert struct.pack("d", travelled(value)) == struct.pack("d", value)


@given(st.dictionaries(st.text(), JSON, max_size=5))
def test_a_frame_is_one_line_of_ascii_and_comes_back(content):
    line = encode_frame(content)
    assert line.endswith(b"\n")
    assert line.count(b"\n") == 1
    assert line.isascii()
    assert decode_frame(line[:-1]) == content


@given(st.binary(max_size=60))
def test_whatever_bytes_arrive_they_are_an_object_or_refused(line):
    try:
        assert isinstance(decode_frame(line), dict)
    except RobotFormatError as error:
        assert error.message  # noqa: PT017 - either is right


@pytest.mark.parametrize(
    "line",
    [b"", b"[1]", b"7", b"null", b'{"a":NaN}', b'{"a":-Infinity}', b'{"a":1', b"\xff\xfe", b"[" * 100_000,
     b'{"a":' + b"9" * 5000 + b"}"],
    ids=lambda line: repr(line[:12]),
)  # fmt: skip
def test_what_is_no_json_object_is_refused(line):
    with pytest.raises(RobotFormatError):
        decode_frame(line)


@pytest.mark.parametrize("value", [math.nan, math.inf, {1, 2}, b"x"])
def test_what_is_no_json_is_not_sent(value):
    with pytest.raises(RobotFormatError):
        encode_frame({"it": value})


@pytest.mark.parametrize("number", [None, True, -1, 1.0, "1", 1 << 53])
def test_an_id_is_a_natural_number(number):
    with pytest.raises(RobotFormatError):
        frame_id({"id": number})


@given(moderate, moderate, st.floats(-4.0, 4.0))
def test_a_pose_comes_back_with_the_same_bits(x_m, y_m, theta_rad):
    pose = Pose2(x_m, y_m, theta_rad)
    assert differences(v.pose_of(travelled(v.pose_json(pose)), "goal"), pose) == []


@given(
    arrays(np.float64, 3, elements=moderate),
    moderate,
    st.floats(-4, 4),
    arrays(np.float64, (3, 3), elements=st.floats(-1, 1)),
)
def test_a_state_comes_back_with_the_same_bits_in_whatever_order_its_joints_are(joints, x_m, theta_rad, root):
    state = RobotState(joints, Pose2(x_m, -x_m, theta_rad), root @ root.T)
    content = travelled(v.state_json(state, ("a", "b", "c")))
    content["joints"] = dict(reversed(content["joints"].items()))
    assert differences(v.state_of(content, ("a", "b", "c")), state) == []


@given(st.booleans(), st.none() | st.tuples(st.text(), st.text(), st.lists(st.tuples(st.text(), moderate | st.text()))))
def test_an_outcome_comes_back(success, told):
    failure = None if told is None else Failure(told[0], told[1], tuple(told[2]))
    outcome = GraspOutcome(success, failure)
    assert differences(v.outcome_of(travelled(v.outcome_json(outcome))), outcome) == []


@given(JSON)
def test_no_content_makes_the_readers_fail_in_an_untyped_way(content):
    readers = [
        lambda c: v.pose_of(c, "goal"),
        lambda c: v.joints_of(c, ("a",)),
        lambda c: v.state_of(c, ("a",)),
        lambda c: v.state_of({"base": c, "base_covariance": c, "joints": {"a": 1.0}}, ("a",)),
        v.outcome_of,
        lambda c: v.outcome_of({"success": True, "failure": c}),
        lambda c: v.outcome_of({"success": False, "failure": {"kind": "a", "message": "b", "numbers": c}}),
        lambda c: v.numbers(c, "legs_m", (None, 2, 3)),
    ]
    for reader in readers:
        try:
            reader(content)
        except RobotFormatError:
            continue


@pytest.mark.parametrize(
    "joints", [{"a": 1.0}, {"a": 1.0, "b": 2.0, "c": 0.0}, {"a": 1, "b": "2"}, {"a": 1, "b": True}, 3]
)
def test_joints_are_all_there_and_no_others(joints):
    with pytest.raises(RobotFormatError):
        v.joints_of(joints, ("a", "b"))


def test_a_covariance_that_cannot_be_is_refused():
    with pytest.raises(RobotFormatError):
        v.state_of({"base": [0, 0, 0], "base_covariance": (-np.eye(3)).tolist(), "joints": {}}, ())


def test_a_refusal_of_ours_comes_back_as_itself_with_its_numbers():
    error = JointLimitError("too far", joint="a", value=np.float64(7.5), upper=np.inf, names=("a", "b"))
    back = error_of(travelled(error_json(error)), command="move_arm")
    assert type(back) is JointLimitError
    assert back.numbers == {"joint": "a", "value": 7.5, "upper": None, "names": ["a", "b"], "command": "move_arm"}


@pytest.mark.parametrize("kind", ["E-Stop", "Self", "RobotLost", "RobotFrameError", "__doc__", 3])
def test_any_other_refusal_is_a_refusal_with_its_kind_as_reason(kind):
    back = error_of({"kind": kind, "message": "no", "numbers": {"message": 1, "self": 2, "amps": 3.0}})
    assert type(back) is RobotRefused
    assert back.numbers == {"amps": 3.0, "reason": str(kind)}


@given(JSON)
def test_whatever_stands_for_an_error_becomes_one(content):
    assert isinstance(error_of(content, host="h"), RfCompassError)
