"""A grasp plan can be carried out, is the most likely one, and every refusal has its reason."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from grasp_scenes import LEG, ROBOT, SCAN, box_at, estimate, plain_part

from planners.grasp import GraspPlanner, GraspRules
from planners.hand_joints import hand_joints
from planners.ik import IkRules, InverseKinematics
from planners.margins import grown
from planners.reachability import MapMaker
from planners.success import success_probability
from planners.task_map import top_down
from rfcompass.errors import PartError, RobotModelError, ShapeError
from rfcompass.recordings.parts.mesh import part_from_mesh
from rfcompass.robots import CollisionModel, FclCollisions, QuickCollisions, Robot, load_robot
from rfcompass.robots.hand import hand_of
from rfcompass.robots.packages import extra_folder
from rfcompass.types import (
    Body,
    Box,
    Configuration,
    Cylinder,
    GraspFailure,
    GraspPlan,
    Mesh,
    PartEstimate,
    SearchVolume,
    Sphere,
    World,
)
from rfcompass.types.grasp_noise import GraspNoise

PLANNER = GraspPlanner(ROBOT)
HAND, JOINTS = hand_of(ROBOT), hand_joints(ROBOT)


def plan(part=LEG, where=None, world=None, start=None, planner=PLANNER, seed=0):
    return planner.plan(part, where or estimate(part=part), world, start, np.random.default_rng(seed))


@pytest.fixture(scope="module")
def leg_plan():
    return plan()


def tool_at(joints):
    return ROBOT.tool_pose(Configuration(joints)).homogeneous


def test_a_plan_is_sound_and_its_stages_join_without_a_gap(leg_plan):
    assert isinstance(leg_plan, GraspPlan)
    assert leg_plan.defects == ()
    assert [stage.stage for stage in leg_plan.stages] == ["reach", "approach", "close", "lift", "retreat"]
    assert leg_plan.stages[0].joints[0] == pytest.approx(SCAN.joints)
    for before, after in zip(leg_plan.stages[:-1], leg_plan.stages[1:], strict=True):
        assert np.array_equal(before.joints[-1], after.joints[0])
    assert leg_plan.approach[-1] == pytest.approx(leg_plan.configuration)
    for stage in leg_plan.stages:
        for joints in stage.joints:
            ROBOT.check_limits(Configuration(joints), soft=True)
    assert leg_plan.clearance_m > 0


def test_the_hand_is_where_the_plan_says_and_closes_on_the_leg(leg_plan):
    assert tool_at(leg_plan.configuration) == pytest.approx(leg_plan.T_base_hand, abs=1e-6)
    assert leg_plan.closed_m == pytest.approx(0.05, abs=1e-6)
    closed = Configuration(leg_plan.stages[2].joints[-1])
    assert closed.joints == pytest.approx(JOINTS.at_opening(closed, HAND, 0.05).joints, abs=1e-6)


def test_approach_and_lift_are_straight(leg_plan):
    stages = {stage.stage: np.array([tool_at(q)[:3, 3] for q in stage.joints]) for stage in leg_plan.stages}
    down, up = stages["approach"], stages["lift"]
    assert down[:, :2] == pytest.approx(np.tile(down[-1, :2], (len(down), 1)), abs=1e-6)
    assert up[-1] - up[0] == pytest.approx([0, 0, 0.05], abs=1e-6)


def test_fcl_finds_nothing_touching_on_the_way_with_the_leg_in_the_hand(leg_plan):
    T_base_leg = np.eye(4)
    T_base_leg[:2, :2] = [[np.cos(1.4), -np.sin(1.4)], [np.sin(1.4), np.cos(1.4)]]
    T_base_leg[:3, 3] = 0.42, 0.03, LEG.resting_height_m
    standing = World((Body(LEG.part_id, LEG.shape, T_base_leg),))
    T_tool_leg = np.linalg.inv(leg_plan.T_base_hand) @ T_base_leg
    T_tool_leg[3] = 0, 0, 0, 1
    held = standing.attach(LEG.part_id, ROBOT.tool.frame, T_tool_leg, (*JOINTS.fingers, "floor"))
    for stages, world in (((0, 1), standing), ((3, 4), held)):
        judge = FclCollisions(CollisionModel(ROBOT, world))
        rows = np.concatenate([leg_plan.stages[i].joints for i in stages])
        assert not any(judge.collides(Configuration(joints)) for joints in rows)


def test_the_chance_is_that_of_the_estimate(leg_plan):
    where = estimate(samples=4000, seed=9)
    draws = GraspNoise().draw(4000, np.random.default_rng(9))
    again = success_probability(HAND, LEG, leg_plan.T_base_hand, where.samples, where.height_m, draws=draws)
    assert leg_plan.success_probability == pytest.approx(again.probability, abs=0.04)
    assert sum(share for _, share in leg_plan.risks) == pytest.approx(1 - leg_plan.success_probability)


def test_no_grasp_that_was_left_is_likelier(leg_plan):
    others = [row.score for row in leg_plan.candidates if row.score is not None]
    # Scores of those that were given up early are rough: over a tenth of the samples.
    assert leg_plan.success_probability >= max(others) - 0.05
    assert len(others) > 10
    rejected = [row for row in leg_plan.candidates if row.rejection is not None]
    assert len(rejected) + len(others) == len(leg_plan.candidates)
    assert all(row.rejection.message for row in rejected)
    assert sum(leg_plan.reasons.values()) == len(rejected)


def test_equal_questions_get_equal_plans(leg_plan):
    again = GraspPlanner(ROBOT).plan(LEG, estimate(), None, None, np.random.default_rng(0))
    assert np.array_equal(again.T_base_hand, leg_plan.T_base_hand)
    assert again.success_probability == leg_plan.success_probability
    for one, other in zip(again.stages, leg_plan.stages, strict=True):
        assert np.array_equal(one.joints, other.joints)


def test_where_the_pose_is_surest_the_hand_closes():
    """The leg turns about a point 12 cm from its centre: there it moves least."""
    rng = np.random.default_rng(3)
    turns = 1.5 + rng.normal(0, np.deg2rad(6), 600)
    pivot = np.array([0.42, 0.0])
    centres = pivot - 0.12 * np.column_stack([np.cos(turns), np.sin(turns)])
    where = replace(estimate(), centre_m=centres.mean(axis=0), theta_rad=1.5, covariance=None,
                    samples=np.column_stack([centres, turns]))  # fmt: skip
    found = plan(where=where)
    assert isinstance(found, GraspPlan)
    assert 0.07 < found.T_part_hand[0, 3] < 0.17
    middle = found.T_base_hand.copy()
    middle[:2, 3] = where.centre_m
    at_the_middle = success_probability(HAND, LEG, middle, where.samples, where.height_m)
    assert found.success_probability > at_the_middle.probability + 0.1


def test_something_beside_the_middle_moves_the_grasp_along_the_leg():
    free = plan(where=estimate(y=0.0, theta=np.pi / 2))
    assert abs(free.T_part_hand[0, 3]) < 0.03
    pillar = box_at("pillar", (0.04, 0.06, 0.5), 0.48, 0.0, 0.25)
    found = plan(where=estimate(y=0.0, theta=np.pi / 2), world=World((pillar,)))
    assert isinstance(found, GraspPlan)
    assert abs(found.T_part_hand[0, 3]) > 0.03
    assert any("pillar" in row.rejection.message for row in found.candidates if row.rejection)


def test_a_margin_is_kept_from_what_stands_around_unless_the_robot_is_nearer():
    pillar = box_at("pillar", (0.04, 0.06, 0.5), 0.50, 0.0, 0.25)
    beside = box_at("beside", (0.2, 0.02, 0.1), 0.0, 0.193, 0.1)  # 3 mm from the base
    world = World((pillar, beside))
    found = plan(where=estimate(y=0.0, theta=np.pi / 2), world=world)
    assert isinstance(found, GraspPlan)
    checker = QuickCollisions(CollisionModel(ROBOT, world))
    rows = np.concatenate([stage.joints for stage in found.stages])
    names = checker.pair_names
    distances = np.array([checker.distances(Configuration(joints)) for joints in rows]).min(axis=0)
    to = {
        name: min(d for pair, d in zip(names, distances, strict=True) if name in pair) for name in ("pillar", "beside")
    }
    assert to["pillar"] >= 0.005
    assert 0 < to["beside"] < 0.005


@pytest.mark.parametrize("shape", [Box(np.array([0.1, 0.2, 0.3])), Cylinder(0.05, 0.2, "x"), Sphere(0.04)])
def test_grown_shapes_are_larger_by_the_margin_to_all_sides(shape):
    larger = grown(shape, 0.01)
    assert larger.upper_m == pytest.approx(shape.upper_m + 0.01)
    assert larger.lower_m == pytest.approx(shape.lower_m - 0.01)


def test_pieces_of_a_mesh_grow(turned_leg):
    larger = grown(turned_leg.shape, 0.01)
    for piece, was in zip(larger.pieces_m, turned_leg.shape.pieces_m, strict=True):
        assert piece.max(axis=0) == pytest.approx(was.max(axis=0) + 0.01)
        assert piece.min(axis=0) == pytest.approx(was.min(axis=0) - 0.01)


def test_hooks_over_both_ends_block_the_lift():
    hooks = [box_at(f"hook {k}", (0.03, 0.03, 0.02), 0.42, 0.18 * k, 0.065) for k in (-1, 1)]
    planner = GraspPlanner(ROBOT, rules=GraspRules(most_tries=4))
    failure = plan(where=estimate(y=0.0, theta=np.pi / 2), world=World(tuple(hooks)), planner=planner)
    assert failure.kind == "no_grasp"
    assert failure.reasons["lift_blocked"] == 4
    assert failure.reasons["not_tried"] > 0
    assert "4 lift_blocked" in failure.message


def test_walls_between_hand_and_leg_are_named():
    walls = [
        box_at(f"wall {k}", (0.02, 0.9, 1.2), 0.36 * np.cos(a), 0.36 * np.sin(a), 0.6, a)
        for k, a in enumerate(np.arange(4) * np.pi / 2)
    ]
    failure = plan(world=World(tuple(walls)), start=ROBOT.posture("candle"))
    assert failure.kind == "no_grasp"
    blocked = [row.rejection for row in failure.candidates if row.rejection.kind == "scene_collision"]
    assert any("wall 0" in row.message for row in blocked)
    assert failure.base is None


def test_a_neighbour_a_few_millimetres_beside_the_leg_does_not_block_the_lift():
    beside = box_at("beside", (0.02, 0.1, 0.05), 0.42 + 0.025 + 0.01 + 0.003, 0.16, 0.025)
    found = plan(where=estimate(y=0.0, theta=np.pi / 2), world=World((beside,)))
    assert isinstance(found, GraspPlan)
    assert found.defects == ()


def test_a_leg_on_a_plank_is_lifted_off_it():
    plank = box_at("plank", (0.2, 0.6, 0.02), 0.43, 0.0, 0.01)
    where = replace(estimate(y=0.0, theta=np.pi / 2), height_m=LEG.resting_height_m + 0.02)
    found = plan(where=where, world=World((plank,)))
    assert isinstance(found, GraspPlan)
    assert found.defects == ()


def test_a_folded_robot_whose_boxes_overlap_still_gets_there():
    folded = ROBOT.posture("folded")
    found = plan(start=folded)
    assert isinstance(found, GraspPlan)
    assert found.stages[0].joints[0] == pytest.approx(folded.joints)
    assert found.defects == ()


def test_a_point_has_no_chance_but_a_plan():
    point = PartEstimate(LEG.part_id, [0.42, 0.03], 1.4, "told", 1, LEG.resting_height_m)
    found = plan(where=point)
    assert found.success_probability is None
    assert found.defects == ()


def test_a_covariance_will_do_in_place_of_samples():
    found = plan(where=estimate(samples=0))
    assert found.success_probability == pytest.approx(plan().success_probability, abs=0.05)


@pytest.fixture(scope="module")
def turned_leg(tmp_path_factory):
    file = tmp_path_factory.mktemp("parts") / "leg.stl"
    profile = [[0, -0.2], [0.02, -0.2], [0.025, -0.1], [0.015, 0.0], [0.022, 0.1], [0.012, 0.2], [0, 0.2]]
    trimesh.creation.revolve(np.array(profile), sections=32).export(file)
    return part_from_mesh(file, "turned_leg", density_kg_m3=500.0)


def test_a_turned_leg_from_a_file_is_planned_and_certified(turned_leg):
    found = plan(turned_leg, estimate(theta=np.pi / 2, part=turned_leg))
    assert isinstance(found, GraspPlan)
    assert found.defects == ()
    assert 0.025 <= found.closed_m <= 0.052


def test_a_ball_needs_no_orientation_and_a_leg_does():
    post = plain_part(Cylinder(0.02, 0.06, "z"))
    covariance = np.full((3, 3), np.nan)
    covariance[:2, :2] = 1e-5 * np.eye(2)
    where = PartEstimate("thing", [0.42, 0.05], None, "told", 1, post.resting_height_m, covariance)
    assert isinstance(plan(post, where), GraspPlan)
    assert plan(where=replace(where, part_id=LEG.part_id, height_m=0.025)).kind == "orientation_unknown"


def refuse(kind, answer):
    assert isinstance(answer, GraspFailure)
    assert answer.kind == kind
    assert answer.message
    return dict(answer.numbers)


def test_a_part_that_is_too_wide_or_too_heavy_is_refused_with_numbers():
    brick = plain_part(Box(np.array([0.2, 0.1, 0.09])))
    numbers = refuse("too_wide", plan(brick))
    assert numbers["width_m"] == pytest.approx(0.09)
    assert numbers["opening_m"] < 0.075
    numbers = refuse("too_heavy", plan(replace(LEG, mass_kg=0.7)))
    assert (numbers["mass_kg"], numbers["most_kg"]) == (0.7, 0.5)


def test_a_covariance_that_is_none_is_refused():
    bad = replace(estimate(samples=0), covariance=np.diag([1e-4, -1e-4, 1e-3]))
    assert refuse("bad_covariance", plan(where=bad))["least_eigenvalue"] < 0
    with pytest.raises(ShapeError, match="covariance"):
        replace(estimate(), covariance=np.full((3, 3), np.nan))


def test_a_part_that_would_lie_in_the_floor_is_refused():
    assert refuse("part_in_the_floor", plan(where=replace(estimate(), height_m=0.0)))["depth_m"] == 0.025


def test_a_robot_without_a_tool_or_a_mesh_with_holes_is_bad_input():
    with pytest.raises(RobotModelError, match="tool"):
        GraspPlanner(Robot(replace(ROBOT.description, tool=None)))
    box = trimesh.creation.box([0.2, 0.04, 0.04])
    corners = np.asarray(box.vertices)
    holed = Mesh(corners, np.asarray(box.faces)[2:], (corners, corners + 0.001), "vhacd", np.eye(4))
    with pytest.raises(PartError, match="holes"):
        plan(plain_part(holed))


def test_a_robot_that_stands_in_something_is_told_so():
    block = box_at("block", (0.5, 0.5, 0.5), 0.0, 0.0, 0.25)
    numbers = refuse("start_collision", plan(world=World((block,))))
    assert "block" in (numbers["first"], numbers["second"])
    assert numbers["depth_m"] > 0


@pytest.mark.slow
def test_in_a_cage_there_is_no_grasp_and_no_drive():
    walls = [box_at(f"wall {k}", (0.02, 1.4, 1.2), 0.6 * np.cos(a), 0.6 * np.sin(a), 0.6, a)
             for k, a in enumerate(np.arange(4) * np.pi / 2)]  # fmt: skip
    failure = plan(where=estimate(x=0.85), world=World(tuple(walls)),
                   planner=GraspPlanner(ROBOT, rules=GraspRules(drive=True)))  # fmt: skip
    refuse("unreachable", failure)
    assert failure.base is None


FAR = {"x": 1.6, "y": 0.5, "theta": 0.3}


def test_out_of_reach_it_says_where_to_drive():
    failure = plan(where=estimate(**FAR))
    numbers = refuse("unreachable", failure)
    assert failure.base is not None
    assert (numbers["drive_x_m"], numbers["drive_y_m"]) == (failure.base.x_m, failure.base.y_m)
    assert "drive to" in failure.message
    there = plan(where=estimate(**FAR).in_frame(failure.base.inverse()))
    assert there.success_probability == pytest.approx(numbers["probability_there"], abs=0.05)


def test_it_drives_there_if_it_may():
    found = plan(where=estimate(**FAR), planner=GraspPlanner(ROBOT, rules=GraspRules(drive=True)))
    assert isinstance(found, GraspPlan)
    assert found.defects == ()
    assert found.stages[0].stage == "drive"
    assert found.stages[0].bases[-1] == pytest.approx([found.base.x_m, found.base.y_m, found.base.theta_rad])
    T = np.eye(4)
    T[:2, :2], T[:2, 3] = found.base.rotation, found.base.translation_m
    assert np.linalg.norm((T @ found.T_base_hand)[:2, 3] - [1.6, 0.5]) < 0.2


def test_with_a_map_the_place_to_drive_to_weighs_the_whole_estimate():
    quick = InverseKinematics(ROBOT, rules=IkRules(certify=False, explain=False))
    volume = SearchVolume([0.26, -0.2, 0.015], [0.5, 0.2, 0.055])
    task_map = MapMaker(ik=quick, spacing_m=0.04).make(volume, top_down(12), SCAN)
    failure = plan(where=estimate(**FAR), planner=GraspPlanner(ROBOT, task_map=task_map))
    refuse("unreachable", failure)
    without = plan(where=estimate(**FAR))
    assert failure.base != without.base
    there = plan(where=estimate(**FAR).in_frame(failure.base.inverse()))
    assert isinstance(there, GraspPlan)


def test_the_hand_goes_around_a_post_on_its_way_there():
    aside = SCAN.joints.copy()
    aside[0] += 1.4
    post = box_at("post", (0.04, 0.04, 0.6), 0.34, -0.1, 0.3)
    found = plan(where=estimate(y=0.03, theta=np.pi / 2), world=World((post,)), start=Configuration(aside))
    assert isinstance(found, GraspPlan)
    assert len(found.stages[0].joints) > 2
    assert found.defects == ()


@pytest.mark.skipif(extra_folder() is None, reason="the robots extra is not installed")
def test_an_arm_without_a_closed_form_grasps_as_well():
    panda = load_robot("panda")
    planner = GraspPlanner(panda, rules=GraspRules(samples=200))
    found = planner.plan(LEG, estimate(x=0.45, y=0.1), World(floor_m=-0.001))
    assert isinstance(found, GraspPlan)
    assert found.defects == ()
    assert found.solution.method in ("sqp", "ipopt")
    T = panda.tool_pose(panda.configuration(found.configuration)).homogeneous
    assert T[:3, 3] == pytest.approx(found.T_base_hand[:3, 3], abs=1e-6)


def test_rules_that_cannot_be_are_refused():
    for bad in ({"samples": 0}, {"most_tries": 0}, {"least_chance": 1.5}):
        with pytest.raises(ValueError, match="GraspRules"):
            GraspRules(**bad)
