"""The optimisation's parts: residual, distances, spheres, Newton's steps, and programs that are used again."""

import casadi as ca
import numpy as np
import pytest
from collision_scenes import ROBOT, at, random_configurations, things
from hypothesis import given
from hypothesis import strategies as st

from planners.ik import IkRules, InverseKinematics
from planners.ik_numeric import NumericIk, NumericTask, newton
from planners.ik_program import IkProgram, box_parameters, recent_program
from planners.link_spheres import cover
from planners.task_forms import task_error
from rfcompass.robots import CollisionModel, QuickCollisions
from rfcompass.robots.solids import robot_solids
from rfcompass.types import Body, Box, GraspTask, Sphere, World

SCAN = ROBOT.posture("scan")
MODEL = CollisionModel(ROBOT, things())


def parameters(program, numbers, joints, size=0.0, weights=(1, 1, 0)):
    x = np.concatenate([joints[:5], np.zeros(3 * program.base_free)])
    boxes = box_parameters(program.standing)
    return x, program.parameters(
        task=numbers, weights=np.array(weights, dtype=float), joints=joints, reference=x, pull=np.ones(len(x)),
        size=size, floor=0.0, boxes=boxes,
    )  # fmt: skip


@pytest.mark.parametrize("base_free", [False, True])
def test_the_residual_is_zero_exactly_where_the_task_is_done(base_free):
    program = IkProgram(MODEL, base_free)
    for configuration in random_configurations(20, seed=41, moves_base=False):
        T = ROBOT.tool_pose(configuration)
        task = GraspTask.of_pose(T.homogeneous, ROBOT.tool.approach_axis, ROBOT.tool.closing_axis)
        numbers = np.concatenate([task.point_m, task.approach, task.closing])
        r, _ = program.residual(*parameters(program, numbers, configuration.joints))
        assert np.abs(np.array(r)).max() < 1e-12
        other, _ = program.residual(*parameters(program, numbers, SCAN.joints))
        off = task_error(task, ROBOT.tool_pose(SCAN), ROBOT.tool)
        assert np.linalg.norm(np.array(other)[:3]) == pytest.approx(off[0])


def test_derivatives_of_the_residual_are_finite_differences():
    program = IkProgram(MODEL, True)
    numbers = np.array([0.4, 0.1, 0.1, 0, 0, -1, 0, 1, 0], dtype=float)
    for weights in ((1, 1, 0), (1, 1, 1), (0, 1, 0)):
        x, p = parameters(program, numbers, SCAN.joints, weights=weights)
        _, J = program.residual(x, p)
        for k in range(len(x)):
            step = 1e-6 * np.eye(len(x))[k]
            ahead, behind = (np.array(program.residual(x + sign * step, p)[0]).ravel() for sign in (1, -1))
            assert np.array(J)[:, k] == pytest.approx((ahead - behind) / 2e-6, abs=1e-8)


def test_inner_spheres_never_refuse_what_is_free_of_boxes_and_outer_ones_never_pass_a_touch():
    """Over the floor, h with inner radii is an upper bound and with outer ones a lower; what touches has h <= 0."""
    world = World((Body("leg", Box(np.array([0.05, 0.4, 0.05])), at(0.42, 0, 0.025)),))
    model = CollisionModel(ROBOT, world)
    program, quick, touching = IkProgram(model, False), QuickCollisions(model), 0
    for configuration in random_configurations(60, seed=42, moves_base=False):
        x, inner = parameters(program, np.zeros(9), configuration.joints, size=0.0)
        _, outer = parameters(program, np.zeros(9), configuration.joints, size=1.0)
        near = quick.distances(configuration)
        floor = [d for names, d in zip(quick.pair_names, near, strict=True) if names[1] == "floor"]
        count = len(floor)
        assert (np.array(program.guard(x, inner)).ravel()[:count] >= np.array(floor) - 1e-6).all()
        assert (np.array(program.guard(x, outer)).ravel()[:count] <= np.array(floor) + 1e-6).all()
        if near.min() <= 0:
            assert np.array(program.guard(x, outer)).min() <= 1e-6
            touching += 1
    assert touching > 10


@pytest.mark.parametrize("solid", robot_solids(ROBOT), ids=lambda solid: solid.owner)
def test_outer_spheres_cover_the_box_and_inner_ones_lie_in_it(solid):
    spheres, rng = cover(solid), np.random.default_rng(0)
    inverse = np.linalg.inv(solid.T_carrier_box)
    centres = spheres.centres_m @ inverse[:3, :3].T + inverse[:3, 3]
    points = rng.uniform(-1, 1, (500, 3)) * solid.half_size_m
    off = np.linalg.norm(points[:, None] - centres, axis=2).min(axis=1)
    assert off.max() <= spheres.outer_m + 1e-12
    assert (np.abs(centres) + spheres.inner_m <= solid.half_size_m + 1e-12).all()


@given(seed=st.integers(0, 10_000))
def test_newton_solves_what_is_consistent_and_stays_within_bounds(seed):
    rng = np.random.default_rng(seed)
    A, goal = rng.normal(size=(3, 5)), rng.uniform(-0.5, 0.5, 5)
    lower, upper = np.full(5, -1.0), np.full(5, 1.0)

    def residual(x):
        return A @ (x - goal) + 0.05 * (A @ (x - goal)) ** 2, A * (1 + 0.1 * (A @ (x - goal)))[:, None]

    away = rng.normal(size=5)
    start = goal + 0.02 * away / (np.linalg.norm(A, 2) * np.linalg.norm(away))  # |r| ≲ 0.02: not hopeless
    x, size = newton(residual, start, lower, upper)
    assert size < 1e-9
    assert (x >= lower).all()
    assert (x <= upper).all()


def test_newton_leaves_alone_what_is_hopeless():
    x, size = newton(lambda x: (x + 10, np.eye(2)), np.zeros(2), np.full(2, -1.0), np.ones(2))
    assert x.tolist() == [0, 0]
    assert size == pytest.approx(np.hypot(10, 10))


def test_the_starts_are_the_same_in_every_call_and_inside_the_limits():
    ik = NumericIk(MODEL)
    task = NumericTask(ik, GraspTask([0.4, 0, 0.1], [0, 0, -1], [0, 1, 0]), SCAN)
    first, again = list(task.starts(10)), list(task.starts(10))
    assert [start.x.tolist() for start in first] == [start.x.tolist() for start in again]
    for start in first:
        assert (start.x >= ik.lower).all()
        assert (start.x <= ik.upper).all()
    assert first[0].numbers[6:].tolist() == (-first[1].numbers[6:]).tolist()  # the jaws the other way round


def test_a_program_is_used_again_where_only_places_and_sizes_differ():
    def world(x, size):
        return World((Body("leg", Box(np.array([0.05, size, 0.05])), at(x, 0, 0.025)),))

    programs = [recent_program(CollisionModel(ROBOT, world(*args)), False) for args in ((0.4, 0.4), (0.5, 0.3))]
    assert programs[0] is programs[1]
    more = world(0.4, 0.4).with_bodies(Body("ball", Sphere(0.1), at(1, 0, 0)))
    assert recent_program(CollisionModel(ROBOT, more), False) is not programs[0]
    assert recent_program(CollisionModel(ROBOT, world(0.4, 0.4), 0.01), False) is not programs[0]
    assert recent_program(CollisionModel(ROBOT, world(0.4, 0.4)), True) is not programs[0]
    assert isinstance(programs[0].plain, ca.Function)


def test_the_manipulability_is_that_of_pinocchios_jacobian_and_vanishes_where_the_arm_is_straight():
    program, frame = IkProgram(MODEL, False), ROBOT.kinematics.frame_id(ROBOT.tool.frame)
    for configuration in random_configurations(20, seed=43, moves_base=False):
        J = ROBOT.kinematics.point_jacobians(configuration.joints, [frame])[0][:, :5]
        expected = np.sqrt(max(0.0, np.linalg.det(J @ J.T)))
        assert float(program.dexterity(configuration.joints[:5])) == pytest.approx(expected, abs=1e-9)
    assert float(program.dexterity(ROBOT.posture("candle").joints[:5])) < 1e-4


def test_a_weight_on_manipulability_buys_some_where_the_task_leaves_a_choice():
    """Pitch and roll are free; the present posture does the task with the least manipulability that there is."""
    dexterity = IkProgram(MODEL, False).dexterity
    measured = {0.0: [], 1e-3: []}
    for task in (GraspTask([x, 0.05, z]) for x in (0.35, 0.45, 0.5) for z in (0.25, 0.35, 0.45)):
        branches = InverseKinematics(ROBOT).branches(task, SCAN)
        poor = min(branches, key=lambda branch: float(dexterity(branch.joints[:5])))
        for weight, found in measured.items():
            ik = InverseKinematics(ROBOT, rules=IkRules(method="nlp", manipulability=weight, certify=False))
            found.append(float(dexterity(ik.solve(task, poor).configuration.joints[:5])))
    assert np.mean(measured[1e-3]) > 1.05 * np.mean(measured[0.0])
