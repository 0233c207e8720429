"""URDF text is read without resolving anything, and written back unchanged."""

from xml.etree.ElementTree import fromstring

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import RobotModelError
from rfcompass.robots.layouts import data_folder
from rfcompass.robots.urdf_xml import parse_urdf, pose, read_urdf, urdf_text, vector

XXE = '<?xml version="1.0"?><!DOCTYPE robot [<!ENTITY x SYSTEM "file://{file}">]><robot name="r">&x;</robot>'
BOMB = (
    '<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    '<robot name="&b;"><link name="a"/></robot>'
)


def test_an_external_entity_is_refused_and_its_file_never_shows(tmp_path):
    secret = tmp_path / "secret.txt"
    secret.write_text("<link name='stolen'/>")
    with pytest.raises(RobotModelError, match="document type") as caught:
        parse_urdf(XXE.format(file=secret).encode(), "bad.urdf")
    assert "stolen" not in str(caught.value)
    assert caught.value.numbers["doctype"] == "robot"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "iso-8859-1"])
def test_document_types_are_refused_in_every_encoding(encoding):
    text = f'<?xml version="1.0" encoding="{encoding}"?>' + BOMB
    with pytest.raises(RobotModelError, match="document type"):
        parse_urdf(text.encode(encoding), "bad.urdf")


def test_a_document_type_that_only_points_to_a_file_is_refused():
    with pytest.raises(RobotModelError, match="document type"):
        parse_urdf(b'<!DOCTYPE robot SYSTEM "http://example.org/robot.dtd"><robot name="r"/>', "bad.urdf")


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "is no XML"),
        (b"not xml", "is no XML"),
        (b"<robot>", "is no XML"),
        (b"<robot>&missing;</robot>", "is no XML"),
        (b"<robot a='1' a='2'/>", "is no XML"),
        (b"<sdf/>", "root is <sdf>"),
        (b"\xff\xfe\x00", "is no XML"),
        (b"<robot>" + b"<link>" * 200, "nests more than"),
    ],
)
def test_what_is_no_robot_is_refused_with_a_reason(data, reason):
    with pytest.raises(RobotModelError, match=reason) as caught:
        parse_urdf(data, "bad.urdf")
    assert caught.value.numbers["file"] == "bad.urdf"


@given(st.binary(max_size=300))
def test_random_bytes_raise_nothing_but_our_error(data):
    with pytest.raises(RobotModelError):
        parse_urdf(data, "noise")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(RobotModelError, match=r"nowhere\.urdf: cannot be read"):
        read_urdf(tmp_path / "nowhere.urdf")


def test_reading_and_writing_keeps_every_element_and_comment():
    root = read_urdf(data_folder() / "youbot.urdf")
    again = parse_urdf(urdf_text(root).encode(), "again")
    assert urdf_text(again) == urdf_text(root)
    assert "Joint 1: at q = 2.9496" in urdf_text(root)


def test_comments_in_front_of_the_root_are_kept():
    root = parse_urdf(b"<!-- licence --><!-- author --><robot name='r'><link name='a'/></robot>", "r")
    assert urdf_text(root).index("licence") < urdf_text(root).index("author") < urdf_text(root).index("link")


@given(st.tuples(*[st.floats(-4, 4)] * 6))
def test_a_pose_is_what_pinocchio_makes_of_the_same_numbers(numbers):
    words = [repr(number) for number in numbers]
    T = pose(fromstring(f'<origin xyz="{" ".join(words[:3])}" rpy="{" ".join(words[3:])}"/>'))
    assert T[:3, 3] == pytest.approx(numbers[:3])
    assert T[:3, :3] == pytest.approx(pin.rpy.rpyToMatrix(*numbers[3:]), abs=1e-12)
    assert (pose(None) == np.eye(4)).all()


@pytest.mark.parametrize("text", ["1 2", "1 2 3 4", "a b c", "nan 0 0", "inf 0 0", ""])
def test_what_is_not_three_finite_numbers_is_refused(text):
    with pytest.raises(RobotModelError, match="not 3 finite numbers"):
        vector(fromstring(f'<origin xyz="{text}"/>'), "xyz", (0.0, 0.0, 0.0))
