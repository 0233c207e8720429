"""Inverse kinematics: an answer does the task, keeps every limit and touches nothing; a failure says why."""

import numpy as np
import pinocchio as pin
import pytest
from collision_scenes import ROBOT, at, things

from planners.ik import IkRules, InverseKinematics
from planners.task_forms import task_error
from rfcompass.errors import ShapeError
from rfcompass.robots import CollisionModel, FclCollisions, QuickCollisions, YouBot, load_robot
from rfcompass.robots.collision_model import homogeneous
from rfcompass.robots.packages import extra_folder
from rfcompass.types import Body, Box, Configuration, Failure, GraspTask, Solution, World

SCAN = ROBOT.posture("scan")
DOWN = np.array([0.0, 0.0, -1.0])
LEG = Body("leg", Box(np.array([0.05, 0.4, 0.05])), at(0.42, 0, 0.025))
TOP_DOWN = GraspTask([0.42, 0.05, 0.10], DOWN, [1.0, 0, 0])
METHODS = ["auto", "nlp"]


def solver(world=None, **rules):
    return InverseKinematics(ROBOT, world, IkRules(**rules))


def free_tasks(count, seed):
    """Tasks of random arm postures inside the soft limits, open hand, that touch nothing."""
    rng, quick, tasks = np.random.default_rng(seed), QuickCollisions(CollisionModel(ROBOT)), []
    while len(tasks) < count:
        arm = rng.uniform(ROBOT.limits.soft_lower[:5], ROBOT.limits.soft_upper[:5])
        configuration = Configuration([*arm, *SCAN.joints[5:]])
        if not quick.collides(configuration):
            T = ROBOT.tool_pose(configuration).homogeneous
            tasks.append(GraspTask.of_pose(T, ROBOT.tool.approach_axis, ROBOT.tool.closing_axis))
    return tasks


def check(task, solution, world=None, robot=ROBOT):
    """By pinocchio alone, without our own error measure; by the limits; by fcl."""
    configuration = solution.configuration
    T = pin.SE3(homogeneous(configuration.base)) * robot.tool_pose(configuration)
    assert np.linalg.norm(T.translation - task.point_m) < 1e-6
    for wanted, axis in ((task.approach, robot.tool.approach_axis), (task.closing, robot.tool.closing_axis)):
        if wanted is not None and not task.any_heading:
            got = T.rotation @ axis
            sign = np.sign(got @ wanted) if task.jaws_alike and wanted is task.closing else 1.0
            assert np.linalg.norm(np.cross(got, wanted)) < 1e-6
            assert sign * (got @ wanted) > 0
    robot.check_limits(configuration, soft=True)
    assert not FclCollisions(CollisionModel(robot, world or World())).collides(configuration)
    assert solution.certified_pairs > 50
    assert solution.residual_m < 1e-6
    assert solution.residual_rad < 1e-6


@pytest.mark.parametrize("method", METHODS)
def test_an_answer_does_the_task_inside_the_limits_and_touches_nothing(method):
    ik = solver(method=method)
    for task in free_tasks(40, seed=21):
        answer = ik.solve(task, SCAN)
        if method == "auto":
            assert isinstance(answer, Solution)
        if isinstance(answer, Solution):
            check(task, answer)


@pytest.mark.slow
@pytest.mark.parametrize(("method", "least"), [("closed_form", 1.0), ("nlp", 0.995)])
def test_ten_thousand_reachable_tasks_are_solved(method, least):
    ik, tasks = solver(method=method), free_tasks(10_000, seed=22)
    answers = [ik.solve(task, SCAN) for task in tasks]
    solved = [(task, answer) for task, answer in zip(tasks, answers, strict=True) if isinstance(answer, Solution)]
    assert len(solved) >= least * len(tasks)
    for task, answer in solved[::20]:
        check(task, answer)


def test_both_ways_agree_on_the_postures_there_are():
    """The optimisation ends in one of the closed form's branches."""
    closed, numeric = solver(), solver(method="nlp")
    for task in free_tasks(25, seed=23):
        answer = numeric.solve(task, SCAN)
        if isinstance(answer, Solution):
            branches = np.array([branch.joints for branch in closed.branches(task, answer.configuration)])
            assert np.abs(branches - answer.configuration.joints).max(axis=1).min() < 1e-4


def test_the_same_call_gives_the_same_answer():
    for method in METHODS:
        ik, task = solver(method=method), free_tasks(1, seed=24)[0]
        first, again, other = ik.solve(task, SCAN), ik.solve(task, SCAN), solver(method=method).solve(task, SCAN)
        assert first.configuration.joints.tolist() == again.configuration.joints.tolist()
        assert first.configuration.joints.tolist() == other.configuration.joints.tolist()


def test_the_branch_nearest_to_the_present_posture_is_taken():
    ik = solver()
    for branch in ik.branches(TOP_DOWN, SCAN):
        assert ik.solve(TOP_DOWN, branch).configuration.joints == pytest.approx(branch.joints, abs=1e-9)


def test_joints_outside_the_arm_stay_where_they_are():
    half_open = ROBOT.configuration([*SCAN.joints[:5], 0.01, 0.02])
    for method in METHODS:
        joints = solver(method=method).solve(TOP_DOWN, half_open).configuration.joints
        assert joints[5:].tolist() == [0.01, 0.02]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "task",
    [
        GraspTask([0.42, 0.05, 0.10], DOWN),
        GraspTask([0.45, 0.0, 0.20], [1.0, 0, -1], None),
        GraspTask([0.45, 0.1, 0.25], [1.0, 0, -1], [0, 1.0, 0], any_heading=True),
        GraspTask([0.45, 0.1, 0.25], [1.0, 0, -1], any_heading=True),
        GraspTask([0.42, 0.1, 0.10], DOWN, [0, 1.0, 0], any_heading=True),
        GraspTask([0.45, 0.1, 0.25]),
        GraspTask([0.45, 0.0, 0.25], closing=[0, 1.0, 0]),
        GraspTask([0.45, 0.1, 0.25], closing=[0, 1.0, 0], any_heading=True),
    ],
)
def test_what_is_free_may_be_anything(method, task):
    answer = solver(method=method).solve(task, SCAN)
    assert isinstance(answer, Solution)
    check(task, answer)
    if task.any_heading and task.approach is not None:
        T = ROBOT.tool_pose(answer.configuration)
        assert (T.rotation @ ROBOT.tool.approach_axis)[2] == pytest.approx(task.approach[2], abs=1e-6)


def test_a_base_that_drives_recovers_the_heading_that_five_joints_lack():
    """A horizontal tool that looks along y, beside the robot: the arm alone cannot, arm and base can."""
    task = GraspTask([0.5, 0.5, 0.15], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
    assert isinstance(solver().solve(task, SCAN), Failure)
    answer = solver().solve(task, SCAN, base_free=True)
    assert isinstance(answer, Solution)
    check(task, answer)
    assert abs(answer.configuration.base.theta_rad) > 0.5


def test_a_far_part_is_driven_to():
    task = GraspTask([2.0, -1.0, 0.05], DOWN, [0.0, 1.0, 0.0])
    answer = solver().solve(task, SCAN, base_free=True)
    assert isinstance(answer, Solution)
    check(task, answer)
    assert 1.5 < np.hypot(*answer.configuration.base.translation_m) < 2.2


def test_a_free_base_solves_what_the_arm_can_do_at_some_distance():
    """The pitch and the height decide; the closed form, asked at every distance, says which can be done."""
    rng, ik, solved = np.random.default_rng(26), solver(certify=False), 0
    arm = InverseKinematics(ROBOT, rules=IkRules(certify=False, explain=False))
    for _ in range(40):
        pitch, heading, height = rng.uniform(np.pi / 2, np.pi), rng.uniform(-np.pi, np.pi), rng.uniform(0.03, 0.35)
        ahead = [
            GraspTask([x, 0, height], [np.sin(pitch), 0, np.cos(pitch)], [0, 1.0, 0]) for x in np.arange(0.3, 0.7, 0.01)
        ]
        possible = any(isinstance(arm.solve(task, SCAN), Solution) for task in ahead)
        a = [np.sin(pitch) * np.cos(heading), np.sin(pitch) * np.sin(heading), np.cos(pitch)]
        point = [*rng.uniform(-1.5, 1.5, 2), height]
        answer = ik.solve(GraspTask(point, a, [-np.sin(heading), np.cos(heading), 0]), SCAN, base_free=True)
        if possible:
            assert isinstance(answer, Solution)
            solved += 1
    assert solved > 20


def test_the_hand_goes_around_the_part():
    world = World((LEG,))
    answer = solver(world).solve(GraspTask([0.42, 0.0, 0.03], DOWN, [1.0, 0, 0]), SCAN)
    assert isinstance(answer, Solution)
    check(GraspTask([0.42, 0.0, 0.03], DOWN, [1.0, 0, 0]), answer, world)
    assert answer.clearance.distance_m == pytest.approx(0.0125, abs=2e-5)  # (75 - 50) / 2 mm


@pytest.mark.parametrize("method", METHODS)
def test_jaws_across_the_part_collide_with_it(method):
    answer = solver(World((LEG,)), method=method, starts=4).solve(GraspTask([0.42, 0, 0.03], DOWN, [0, 1.0, 0]), SCAN)
    assert answer.kind == "scene_collision"
    numbers = dict(answer.numbers)
    assert "leg" in (numbers["first"], numbers["second"])
    assert numbers["depth_m"] > 0
    assert "leg" in answer.message


@pytest.mark.parametrize("method", METHODS)
def test_the_floor_is_in_the_way(method):
    answer = solver(method=method, starts=4).solve(GraspTask([0.42, 0, -0.01], DOWN, [0, 1.0, 0]), SCAN)
    assert answer.kind == "scene_collision"
    assert dict(answer.numbers)["second"] == "floor"
    assert dict(answer.numbers)["depth_m"] == pytest.approx(0.01, abs=1e-6)


def test_links_in_the_way_of_each_other_are_a_self_collision():
    answer = solver().solve(GraspTask([0.20, 0.0, 0.16], DOWN, [0, 1.0, 0]), SCAN)
    assert answer.kind in ("self_collision", "joint_limit")
    posture = ROBOT.posture("folded")
    T = ROBOT.tool_pose(posture).homogeneous
    folded = GraspTask.of_pose(T, ROBOT.tool.approach_axis, ROBOT.tool.closing_axis)
    answer = solver().solve(folded, posture)
    assert answer.kind == "self_collision"
    assert dict(answer.numbers)["first"] == "arm_link_2"


@pytest.mark.parametrize("method", METHODS)
def test_a_joint_at_its_end_is_named(method):
    """A horizontal tool lower than 0.110 m needs joint 2 beyond 155 degrees."""
    answer = solver(method=method, starts=4, soft_limits=False).solve(GraspTask([0.55, 0, 0.08], [1.0, 0, 0]), SCAN)
    assert answer.kind == "joint_limit"
    assert dict(answer.numbers)["joint"] == "arm_joint_2"
    assert dict(answer.numbers)["beyond"] > 0


@pytest.mark.parametrize("method", METHODS)
def test_out_of_reach_comes_with_the_nearest_pose(method):
    task = GraspTask([0.9, 0.0, 0.245], [1.0, 0, 0])
    answer = solver(method=method, starts=4).solve(task, SCAN)
    assert answer.kind == "unreachable"
    numbers = dict(answer.numbers)
    nearest = np.array([numbers[f"nearest_{axis}_m"] for axis in "xyz"])
    assert np.linalg.norm(nearest - task.point_m) == pytest.approx(numbers["residual_m"], abs=1e-9)
    stretched = ROBOT.tool_pose(ROBOT.configuration([2.9496, 2.61, -2.548, 1.789, 2.9, 0, 0]))
    off = task_error(task, stretched, ROBOT.tool)
    assert np.hypot(numbers["residual_m"], 0.2 * numbers["residual_rad"]) < np.hypot(off[0], 0.2 * off[1])


def test_a_failure_need_not_be_explained():
    task = GraspTask([0.9, 0.0, 0.245], [1.0, 0, 0], [0, 1.0, 0])
    answer = solver(explain=False).solve(task, SCAN)
    assert (answer.kind, answer.numbers) == ("unreachable", ())


def test_no_task_out_of_reach_is_ever_solved():
    rng, ik = np.random.default_rng(25), solver(starts=2)
    for _ in range(150):
        heading, far = rng.uniform(-np.pi, np.pi), rng.uniform(0.56, 2.0)  # the stretched arm is 0.5406 long
        point = np.array([0.167 + far * np.cos(heading), far * np.sin(heading), rng.uniform(0, 0.8)])
        a, b = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2]
        answer = ik.solve(GraspTask(point, a, b), SCAN)
        assert isinstance(answer, Failure)
        assert answer.kind == "unreachable"


def test_a_clearance_is_kept_or_its_lack_is_named():
    world, task = World((LEG,)), GraspTask([0.42, 0.0, 0.03], DOWN, [1.0, 0, 0])
    assert isinstance(solver(world, clearance_m=0.012).solve(task, SCAN), Solution)
    answer = solver(world, clearance_m=0.013).solve(task, SCAN)
    assert answer.kind == "scene_collision"
    assert dict(answer.numbers)["depth_m"] < 0
    assert "13.0 mm are to be kept" in answer.message


def test_an_elbow_in_the_way_of_a_post_is_moved_out_of_it():
    """With pitch and roll free, the optimisation bends the arm around what the nearest posture would touch."""
    task = GraspTask([0.50, 0.0, 0.30])
    free = solver(method="nlp").solve(task, SCAN)
    elbow = ROBOT.link_pose(free.configuration, "arm_link_4").translation
    world = World((Body("post", Box(np.array([0.05, 0.3, 0.05])), at(*elbow)),))
    answer = solver(world, method="nlp").solve(task, SCAN)
    assert isinstance(answer, Solution)
    check(task, answer, world)


def test_a_family_whose_listed_answers_all_touch_something_goes_through_the_optimisation(monkeypatch):
    ik, task = solver(), GraspTask([0.45, 0.1, 0.25])
    accept = ik._accept
    monkeypatch.setattr(ik, "_accept", lambda *args: None if args[2] == "closed_form" else accept(*args))
    answer = ik.solve(task, SCAN)
    assert isinstance(answer, Solution)
    assert answer.method == "sqp"
    assert ik.solve(TOP_DOWN, SCAN).kind in ("scene_collision", "self_collision")  # no family: the list is all there is


def test_a_model_comes_in_place_of_a_world():
    with pytest.raises(ValueError, match="place"):
        InverseKinematics(ROBOT, World(), model=CollisionModel(ROBOT))


def test_a_robot_inside_an_obstacle_gets_a_typed_answer():
    cage = World((Body("block", Box(np.array([2.0, 2.0, 2.0])), at(0, 0, 1)),))
    for base_free in (False, True):
        answer = solver(cage, starts=2).solve(TOP_DOWN, SCAN, base_free=base_free)
        assert answer.kind == "scene_collision"


def test_limits_that_are_reached_are_reported():
    soft = ROBOT.limits.soft_upper[1]
    posture = ROBOT.configuration([2.9, soft, -1.0, 1.0, 2.9, 0.025, 0.025])
    T = ROBOT.tool_pose(posture).homogeneous
    task = GraspTask.of_pose(T, ROBOT.tool.approach_axis, ROBOT.tool.closing_axis)
    answer = InverseKinematics(ROBOT, World(floor_m=None)).solve(task, posture)
    assert answer.at_limit == ("arm_joint_2",)


@pytest.mark.parametrize(
    "change",
    [
        {"clearance_m": -1.0},
        {"clearance_m": np.nan},
        {"method": "magic"},
        {"starts": 0},
        {"position_m": 0.0},
        {"manipulability": -1.0},
    ],
)
def test_impossible_rules_are_refused(change):
    with pytest.raises(ValueError, match="IkRules"):
        IkRules(**change)


@pytest.mark.parametrize(
    "arguments",
    [
        {"point_m": [0.4, 0, np.nan]},
        {"point_m": [0.4, 0]},
        {"point_m": [0.4, 0, 0.1], "approach": [0, 0, 0]},
        {"point_m": [0.4, 0, 0.1], "approach": [0, 0, 1], "closing": [0, 1, 1]},
    ],
)
def test_impossible_tasks_are_refused(arguments):
    with pytest.raises(ShapeError):
        GraspTask(**arguments)


def test_a_start_of_another_robot_is_refused():
    with pytest.raises(ShapeError):
        solver().solve(TOP_DOWN, Configuration(np.zeros(4)))


@pytest.mark.skipif(extra_folder() is None, reason="the robots extra is not installed")
def test_a_seven_joint_arm_is_solved_by_optimisation_alone():
    panda = load_robot("panda")
    world = World(floor_m=None)
    ik = InverseKinematics(panda, world)
    start = panda.configuration([0, -0.5, 0, -2.0, 0, 1.6, 0.8, 0.04, 0.04][: len(panda.joint_names)])
    answer = ik.solve(GraspTask([0.5, 0.1, 0.3], DOWN, [0, 1.0, 0]), start)
    assert isinstance(answer, Solution), answer.message
    assert max(answer.residual_m, answer.residual_rad) < 1e-6
    with pytest.raises(ValueError, match="fixed"):
        ik.solve(TOP_DOWN, start, base_free=True)
    with pytest.raises(ValueError, match="closed form"):
        InverseKinematics(panda, world, IkRules(method="closed_form"))
    with pytest.raises(ValueError, match="closed form"):
        ik.branches(TOP_DOWN)


def test_tags_can_be_bodies_too():
    """Tags at the sides of the hand widen it: between two walls 0.116 m apart it fits without them."""
    walls = [Body(f"wall_{side}", Box(np.array([0.05, 0.01, 0.06])), at(0.42, side * 0.063, 0.17)) for side in (-1, 1)]
    task = GraspTask([0.42, 0.0, 0.10], DOWN, [0, 1.0, 0])
    for with_tags, kind in ((False, Solution), (True, Failure)):
        model = CollisionModel(YouBot(), World(tuple(walls)), with_tags=with_tags)
        assert isinstance(
            InverseKinematics(ROBOT, model=model, rules=IkRules(soft_limits=False)).solve(task, SCAN), kind
        )


def test_the_error_of_a_pose_is_its_distance_and_its_largest_angle():
    T = pin.SE3(pin.rpy.rpyToMatrix(np.pi, 0.1, 0.0), np.array([0.4, 0.0, 0.103]))
    task = GraspTask([0.4, 0, 0.1], T.rotation @ pin.rpy.rpyToMatrix(0.0, 0.02, 0.0) @ [0, 0, 1.0])
    position_m, angle_rad = task_error(task, T, ROBOT.tool)
    assert (position_m, angle_rad) == pytest.approx((0.003, 0.02))
    assert things().bodies
