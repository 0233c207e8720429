"""The arm over a pile looks straight down, goes straight down, touches neither table nor itself, and takes its time."""

from functools import cache

import numpy as np
import pytest

from planners.ik import IkRules, InverseKinematics
from planners.pile_arm import ABOVE_M, CLOSING_S, ArmMotion, PileArm, link_poses
from rfcompass.arrays import FloatArray
from rfcompass.robots import load_robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.grasps import Failure
from rfcompass.types.world import World

FOOT_M = 0.27
T_WORLD_BASE = np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, -0.5], [0.0, 0.0, 1.0, FOOT_M], [0.0, 0.0, 0.0, 1.0]])
CAMERA = "camera_optical_link"


@cache
def arm() -> PileArm:
    robot = load_robot("ur5e_2f85")
    ik = InverseKinematics(robot, World(floor_m=-FOOT_M), IkRules(certify=False, explain=False))
    return PileArm(ik, T_WORLD_BASE, CAMERA, np.array([0.6, -0.3, 0.35]), robot.posture("scan"))


def grasp_at(x_m: float, y_m: float, z_m: float, yaw_rad: float) -> FloatArray:
    T, c, s = np.eye(4), np.cos(yaw_rad), np.sin(yaw_rad)
    T[:3, :3] = np.array([[-s, c, 0.0], [c, s, 0.0], [0.0, 0.0, -1.0]])
    T[:3, 3] = x_m, y_m, z_m
    return T


def tool_poses(path: FloatArray) -> FloatArray:
    return link_poses(arm(), path, arm().ik.robot.tool.frame)


def motion(answer: ArmMotion | Failure) -> ArmMotion:
    assert isinstance(answer, ArmMotion), answer.message
    return answer


@pytest.mark.parametrize("point_m", [(0.0, 0.0, 0.1), (0.25, 0.15, 0.0), (-0.3, -0.1, 0.2)])
def test_the_camera_looks_straight_down_at_the_point(point_m: tuple[float, float, float]) -> None:
    looking = motion(arm().look_at(np.array(point_m), 0.60, arm().resting))
    T = looking.T_world_link
    assert T[:3, 2] == pytest.approx([0, 0, -1], abs=1e-5)
    assert T[:2, 3] == pytest.approx(point_m[:2], abs=1e-5)
    assert 0.40 - 1e-6 <= T[2, 3] <= 0.65 + 1e-6
    assert link_poses(arm(), [looking.end.joints], CAMERA)[0] == pytest.approx(T, abs=1e-9)


@pytest.mark.parametrize("yaw_rad", [0.0, 0.9, 2.5])
def test_the_hand_goes_straight_down_and_up_again(yaw_rad: float) -> None:
    wanted = grasp_at(0.1, 0.05, 0.03, yaw_rad)
    fetching = motion(arm().fetch(wanted, arm().resting))
    down, up = fetching.stages[1], fetching.stages[2]
    tools = tool_poses(down.joints)
    assert np.abs(tools[:, :2, 3] - wanted[:2, 3]).max() < 1e-3
    assert tools[0, 2, 3] - tools[-1, 2, 3] == pytest.approx(ABOVE_M, abs=1e-5)
    assert tools[-1, :3, 3] == pytest.approx(wanted[:3, 3], abs=1e-5)
    closing = tools[-1, :3, :3] @ arm().ik.robot.tool.closing_axis
    assert abs(closing @ wanted[:3, 1]) == pytest.approx(1.0, abs=1e-6)
    assert (up.joints == down.joints[::-1]).all()


def test_it_ends_over_the_drop_zone() -> None:
    fetching = motion(arm().fetch(grasp_at(0.0, 0.0, 0.03, 0.0), arm().resting))
    assert tool_poses(fetching.stages[-1].joints)[-1, :3, 3] == pytest.approx([0.6, -0.3, 0.35], abs=1e-5)


def test_stages_join_and_times_add_up() -> None:
    fetching = motion(arm().fetch(grasp_at(-0.1, 0.1, 0.05, 1.0), arm().resting))
    for one, other in zip(fetching.stages[:-1], fetching.stages[1:], strict=True):
        assert one.joints[-1] == pytest.approx(other.joints[0], abs=1e-9)
    assert fetching.duration_s == pytest.approx(CLOSING_S + sum(stage.duration_s for stage in fetching.stages))
    assert fetching.waiting_s == CLOSING_S


def test_the_slowest_joint_moves_at_four_fifths_of_its_limit() -> None:
    limits = arm().ik.robot.limits.velocity
    for stage in motion(arm().fetch(grasp_at(0.2, -0.1, 0.05, 2.0), arm().resting)).stages:
        seconds = np.diff(stage.times_s)
        moved = np.abs(np.diff(stage.joints, axis=0))
        assert (moved <= limits * seconds[:, None] + 1e-9).all()
        takes_time = seconds > 0
        share = moved[takes_time] / (limits * seconds[takes_time, None])
        assert share.max(axis=1) == pytest.approx(0.8)


def test_beyond_its_reach_the_arm_says_so() -> None:
    for answer in (
        arm().fetch(grasp_at(1.2, 0.8, 0.05, 0.0), arm().resting),
        arm().look_at(np.array([1.5, 1.0, 0.0]), 0.60, arm().resting),
    ):
        assert isinstance(answer, Failure)
        assert answer.kind in ("unreachable", "joint_limit")


def test_below_the_table_the_arm_does_not_go() -> None:
    answer = arm().fetch(grasp_at(0.0, 0.0, -0.05, 0.0), arm().resting)
    assert isinstance(answer, Failure)
    assert answer.kind == "scene_collision"


def test_the_same_question_has_the_same_answer() -> None:
    start = Configuration(motion(arm().look_at(np.zeros(3), 0.6, arm().resting)).end.joints)
    one, other = (motion(arm().fetch(grasp_at(0.1, 0.1, 0.04, 0.5), start)) for _ in range(2))
    assert (one.path == other.path).all()
