"""Joints that follow others."""

from xml.etree.ElementTree import fromstring

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import RobotModelError
from rfcompass.robots.joint_map import read_joint_map


def robot(*rules):
    """Joints j0, j1, …; rule i is None or (leader, multiplier, offset)."""
    mimics = [
        "" if rule is None else f'<mimic joint="{rule[0]}" multiplier="{rule[1]!r}" offset="{rule[2]!r}"/>'
        for rule in rules
    ]
    joints = "".join(f'<joint name="j{i}" type="revolute">{mimic}</joint>' for i, mimic in enumerate(mimics))
    return fromstring(f'<robot name="r"><joint name="still" type="fixed"/>{joints}</robot>')


def test_without_mimic_rules_values_are_positions():
    joint_map = read_joint_map(robot(None, None), ["j0", "j1"])
    assert joint_map.names == ("j0", "j1")
    assert joint_map.positions([0.3, -0.2]).tolist() == [0.3, -0.2]


@given(st.tuples(*[st.floats(-3, 3)] * 5))
def test_a_follower_of_a_follower_follows_the_first(numbers):
    a, b, c, d, value = numbers
    joint_map = read_joint_map(robot(("j2", a, b), ("j0", c, d), None), ["j0", "j1", "j2"])
    assert joint_map.names == ("j2",)
    first = a * value + b
    assert joint_map.positions([value]) == pytest.approx([first, c * first + d, value])


@pytest.mark.parametrize("leader", ["still", "nobody"])
def test_a_follower_of_what_does_not_move_stays_at_its_offset(leader):
    joint_map = read_joint_map(robot(None, (leader, 2.0, 0.25)), ["j0", "j1"])
    assert joint_map.positions([1.0]).tolist() == [1.0, 0.25]


def test_a_ring_of_followers_is_refused():
    with pytest.raises(RobotModelError, match="j0 -> j1 -> j0"):
        read_joint_map(robot(("j1", 1.0, 0.0), ("j0", 1.0, 0.0)), ["j0", "j1"])
