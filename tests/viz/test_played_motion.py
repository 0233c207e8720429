"""A film of a plan passes every waypoint, and the part rides in the hand once the jaws have closed."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_plans import GRASP, LIFTED, ROBOT, T_BASE_PART, a_plan

from rfcompass.errors import InputError
from rfcompass.geometry import Pose2
from rfcompass.robots import load_robot
from rfcompass.viz.played_motion import homogeneous, play

BASE = Pose2(0.3, -0.2, 0.7)


def index_at(motion, time_s):
    return int(np.argmin(np.abs(np.array(motion.times_s) - time_s)))


@pytest.mark.parametrize("base", [None, BASE])
def test_pictures_follow_each_other_closely_and_never_back(base):
    motion = play(a_plan(base), ROBOT)
    gaps = np.diff(motion.times_s)
    assert (gaps > 0).all()
    assert gaps.max() <= 0.1 + 1e-9
    assert motion.times_s[-1] == pytest.approx(a_plan(base).duration_s)


def test_the_part_lies_until_the_jaws_have_closed_and_then_keeps_its_place_in_the_hand():
    plan = a_plan()
    motion = play(plan, ROBOT)
    for time_s, at, T_world_part in zip(motion.times_s, motion.configurations, motion.parts, strict=True):
        if time_s <= 6.0:
            assert T_world_part == pytest.approx(T_BASE_PART, abs=1e-6)
        T_hand_part = np.linalg.inv(ROBOT.tool_pose(at).homogeneous) @ T_world_part
        if time_s >= 6.0:
            assert T_hand_part == pytest.approx(np.linalg.inv(plan.T_part_hand), abs=1e-6)
    assert motion.parts[-1][2, 3] > T_BASE_PART[2, 3] + 0.1


def test_after_a_drive_everything_happens_where_the_base_has_gone():
    motion = play(a_plan(BASE), ROBOT)
    assert motion.configurations[0].base == Pose2()
    assert motion.configurations[index_at(motion, 1.0)].base.theta_rad == pytest.approx(BASE.theta_rad / 2)
    assert all(at.base == BASE for at in motion.configurations[index_at(motion, 2.1) :])
    assert motion.parts[0] == pytest.approx(homogeneous(BASE) @ T_BASE_PART, abs=1e-6)


def test_stages_begin_where_the_last_one_ended():
    motion = play(a_plan(), ROBOT)
    marks = {mark.name: mark.start_s for mark in motion.stages}
    assert marks == {"pre-grasp": 0.0, "approach": 2.0, "close": 4.0, "lift": 6.0, "retreat": 8.0}
    assert motion.configurations[index_at(motion, 4.0)].joints == pytest.approx(GRASP.joints)
    assert motion.configurations[index_at(motion, 8.0)].joints == pytest.approx(LIFTED.joints)


def test_a_turn_takes_the_short_way():
    plan = a_plan(Pose2(0.0, 0.0, 3.0))
    drive = replace(plan.stages[0], bases=np.array([[0.0, 0.0, -3.0], [0.0, 0.0, 3.0]]))
    motion = play(replace(plan, stages=(drive, *plan.stages[1:])), ROBOT)
    assert all(abs(at.base.theta_rad) >= 3.0 - 1e-9 for at in motion.configurations[: index_at(motion, 2.0)])


def test_a_plan_of_another_robot_is_refused():
    with pytest.raises(InputError, match="has other joints"):
        play(a_plan(), load_robot("panda"))


def test_a_plan_without_stages_is_no_film():
    with pytest.raises(InputError, match="no stages"):
        play(replace(a_plan(), stages=()), ROBOT)
