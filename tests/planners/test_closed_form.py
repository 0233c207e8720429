"""The closed form finds every arm posture that forward kinematics can make, and nothing else."""

import time

import numpy as np
import pytest
from collision_scenes import ROBOT
from hypothesis import given
from hypothesis import strategies as st

from planners.closed_form import BEYOND_LIMIT, OFF_PLANE, REACHED, TOO_FAR, solve_all
from planners.planar_arm import read_planar_arm
from planners.task_forms import fixed_tasks, task_error
from rfcompass.robots import load_robot
from rfcompass.robots.packages import extra_folder
from rfcompass.types import GraspTask

ARM = read_planar_arm(ROBOT)
LOWER, UPPER = ROBOT.limits.lower[:5], ROBOT.limits.upper[:5]
NEAR = ROBOT.posture("scan").joints[:5].copy()
FRACTIONS = st.tuples(*[st.floats(0, 1)] * 5)


def configuration(arm):
    return ROBOT.configuration([*arm, 0.0, 0.0])


def rows_of(arms):
    """Tool point, approach and closing axis of arm postures, (B, 9)."""
    poses = [ROBOT.tool_pose(configuration(arm)) for arm in arms]
    return np.array([[*T.translation, *T.rotation[:, 2], *T.rotation[:, 1]] for T in poses])


def arms(count, seed):
    return np.random.default_rng(seed).uniform(LOWER, UPPER, (count, 5))


def test_the_youbots_dimensions_are_the_published_ones():
    assert ARM.axis_m == pytest.approx([0.167, 0.0])
    assert ARM.shoulder_m == pytest.approx([0.033, 0.245])
    assert (ARM.upper_m, ARM.lower_m) == pytest.approx((0.155, 0.135))
    assert ARM.hand_m == pytest.approx([0.2176, -0.002])


@given(fractions=FRACTIONS)
def test_one_branch_is_the_posture_that_made_the_task(fractions):
    arm = LOWER + np.array(fractions) * (UPPER - LOWER)
    tool = ROBOT.tool_pose(configuration(arm)).translation
    if np.hypot(*(tool[:2] - ARM.axis_m)) < 1e-4:
        return  # above the axis of joint 1, any heading will do
    q, status, *_ = solve_all(ARM, rows_of([arm]), arm, False)
    off = np.abs(q[0] - arm).max(axis=1)
    assert np.nanmin(np.where(status[0] == REACHED, off, np.nan)) < 1e-5


def test_every_branch_does_the_task_within_the_limits():
    rows = rows_of(arms(2000, 1))
    q, status, *_ = solve_all(ARM, rows, NEAR, False)
    assert (status == REACHED).any(axis=1).all()
    for b, branch in np.argwhere(status == REACHED)[:1500]:
        assert np.abs(rows_of([q[b, branch]])[0] - rows[b]).max() < 1e-9
        assert (q[b, branch] >= LOWER).all()
        assert (q[b, branch] <= UPPER).all()


def test_a_branch_beyond_a_limit_does_the_task_too_and_names_the_joint():
    rows = rows_of(arms(500, 2))
    q, status, joint, beyond = solve_all(ARM, rows, NEAR, False)
    for b, branch in np.argwhere(status == BEYOND_LIMIT)[:300]:
        assert np.abs(rows_of([q[b, branch]])[0] - rows[b]).max() < 1e-9
        k = joint[b, branch]
        out = max(LOWER[k] - q[b, branch, k], q[b, branch, k] - UPPER[k])
        assert 0 < beyond[b, branch] <= out + 1e-12


def test_branches_are_distinct_except_where_the_elbow_is_straight():
    q, status, *_ = solve_all(ARM, rows_of(arms(500, 3)), NEAR, False)
    for postures, done in zip(q, status == REACHED, strict=True):
        found = postures[done]
        for i in range(len(found)):
            assert (np.abs(found[:i] - found[i]).max(axis=1, initial=0) > 1e-6).all()


def test_the_branch_nearest_to_a_posture_is_chosen_among_whole_turns():
    arm = np.array([2.9, 1.8, -1.2, 2.9, 2.9])
    for turn in (0, 0.5, -0.5, 1.5):
        q, status, *_ = solve_all(ARM, rows_of([arm]), arm + turn, True)
        assert np.nanmin(np.abs(q[status == REACHED] - arm).max(axis=1)) < 1e-9


def test_alike_jaws_may_turn_by_half_a_turn_and_others_may_not():
    arm = np.array([2.9, 1.8, -1.2, 2.9, 1.0])
    near = arm + np.pi * np.eye(5)[4]
    for alike, turned in ((True, np.pi), (False, 0.0)):
        q, status, *_ = solve_all(ARM, rows_of([arm]), near, alike)
        rolls = q[status == REACHED][:, 4]
        assert np.abs(rolls - (arm[4] + turned)).min() < 1e-9


@pytest.mark.parametrize(
    ("row", "status"),
    [
        ([2.0, 0, 0.3, 0, 0, -1, 0, 1, 0], TOO_FAR),
        ([0.45, 0, 0.2, 0, 1, 0, 1, 0, 0], OFF_PLANE),
    ],
)
def test_what_cannot_be_reached_says_why(row, status):
    q, said, *_ = solve_all(ARM, np.array([row], dtype=float), NEAR, True)
    assert status in said[0]
    assert REACHED not in said[0]
    assert np.isnan(q[said == status]).all()


def test_the_kernel_equals_a_readable_version():
    """The same equations in plain Python, for the branch that leans forwards with the elbow up."""
    for arm, row in zip(arms(50, 4), rows_of(arms(50, 4)), strict=True):
        q, status, *_ = solve_all(ARM, row[None], arm, False)
        heading = np.arctan2(row[1] - 0, row[0] - 0.167)
        pitch = np.arctan2(row[3] * np.cos(heading) + row[4] * np.sin(heading), row[5])
        r = np.hypot(row[0] - 0.167, row[1]) - 0.033 - 0.2176 * np.sin(pitch) + 0.002 * np.cos(pitch)
        z = row[2] - 0.245 - 0.2176 * np.cos(pitch) - 0.002 * np.sin(pitch)
        cosine = (r**2 + z**2 - 0.155**2 - 0.135**2) / (2 * 0.155 * 0.135)
        if status[0, 0] == TOO_FAR:
            assert abs(cosine) > 1
            continue
        bend = np.arccos(np.clip(cosine, -1, 1))
        t2 = np.arctan2(r, z) - np.arctan2(0.135 * np.sin(bend), 0.155 + 0.135 * np.cos(bend))
        expected = np.array([np.deg2rad(169) - heading, t2 + np.deg2rad(65), bend - np.deg2rad(146)])
        off = (q[0, 0, :3] - expected + np.pi) % (2 * np.pi) - np.pi
        assert np.abs(off).max() < 1e-9


def test_a_batch_takes_microseconds_a_pose():
    rows = rows_of(arms(2000, 5))
    solve_all(ARM, rows, NEAR, True)
    times = []
    for _ in range(5):
        start = time.process_time()
        solve_all(ARM, rows, NEAR, True)
        times.append(time.process_time() - start)
    assert min(times) / len(rows) < 5e-6  # 1 measured; the rest is room for a busy machine


HEADING = st.floats(-3.1, 3.1)


@given(pitch=st.floats(1.7, 3.1), heading=HEADING, closing=st.booleans(), radius=st.floats(0.25, 0.32))
def test_with_any_heading_both_directions_of_the_arm_plane_are_tried(pitch, heading, closing, radius):
    a = np.array([np.sin(pitch) * np.cos(heading), np.sin(pitch) * np.sin(heading), np.cos(pitch)])
    jaws = np.array([-np.sin(heading), np.cos(heading), 0]) if closing else None
    point = np.array([0.167 + radius * np.cos(0.3), radius * np.sin(0.3), 0.1])
    task = GraspTask(point, a, jaws, any_heading=True)
    q, status, *_ = solve_all(ARM, fixed_tasks(ARM, task), NEAR, True)
    for arm in q[status == REACHED]:
        position_m, angle_rad = task_error(task, ROBOT.tool_pose(configuration(arm)), ROBOT.tool)
        assert position_m < 1e-9
        assert angle_rad < 1e-7
    assert (status != OFF_PLANE).any()


@pytest.mark.parametrize("closing", [None, (0.0, 1.0, 0.0), (1.0, 0.3, 0.2)])
@pytest.mark.parametrize("any_heading", [False, True])
def test_with_a_free_approach_every_answer_does_the_task(closing, any_heading):
    task = GraspTask([0.45, 0.0, 0.15], closing=closing, any_heading=any_heading)
    q, status, *_ = solve_all(ARM, fixed_tasks(ARM, task), NEAR, True)
    found = q[status == REACHED]
    assert len(found)
    for arm in found[:: max(1, len(found) // 20)]:
        assert max(task_error(task, ROBOT.tool_pose(configuration(arm)), ROBOT.tool)) < 1e-7


@pytest.mark.skipif(extra_folder() is None, reason="the robots extra is not installed")
@pytest.mark.parametrize("name", ["panda", "tiago", "pr2"])
def test_an_arm_of_another_kind_has_no_closed_form(name):
    assert read_planar_arm(load_robot(name)) is None
