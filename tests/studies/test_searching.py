"""Whole searches in small piles, through camera, masks, grasps and physics."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from simulation.pile_scenes import RED, at, item, tiny

from planners.pile_arm import PileArm
from rfcompass.errors import InputError, PileUnsettled
from rfcompass.mapping.visual_map import check_spacing
from rfcompass.simulation.piles import ExecutedGrasp, PileScene, flat_state
from rfcompass.simulation.piles.catalogue import draw_target
from rfcompass.studies import pile_robot
from rfcompass.studies.pile_robot import DROP_M, READ_S, SimulatedPileRobot, pile_arm
from rfcompass.studies.pile_scan import PILE_SAR, T_WORLD_BASE
from rfcompass.studies.search_film import film_of
from rfcompass.studies.search_methods import METHODS, search_method
from rfcompass.studies.searching import SearchRun, SearchTask, tagged_items_of
from rfcompass.types import ExtractionAction, GraspMaps, InstanceMasks, TagFix

SEED = 1


def task(**more):
    scene = tiny()
    return SearchTask(scene, tagged_items_of(scene, "any", more.pop("tags", 0), SEED), SEED, spacing_m=0.02, **more)


def begin(name, **more):
    one = task(**more)
    return SearchRun.of(one, search_method(name, one.tags.target_size, SEED))


@cache
def finished(name):
    run = begin(name)
    return run, run.run()


def test_a_small_pile_is_searched_to_a_typed_end_and_the_accounts_agree():
    run, result = finished("ours")
    assert result.outcome in ("found", "too_many_actions", "too_many_failures")
    assert result.found == (run.task.scene.target in run.robot.taken)
    assert len(run.robot.taken) >= result.actions - result.failed_grasps
    assert result.elapsed_s == pytest.approx(sum(motion.duration_s for _, motion in run.robot.motions))
    assert [step.elapsed_s for step in result.steps] == sorted(step.elapsed_s for step in result.steps)


def test_the_same_search_gives_the_same_answer():
    _, one = finished("ours")
    other = begin("ours").run()
    assert [step.action.T_world_hand.tolist() for step in one.steps] == [
        step.action.T_world_hand.tolist() for step in other.steps
    ]
    assert (one.outcome, one.elapsed_s, one.hidden_m3) == (other.outcome, other.elapsed_s, other.hidden_m3)


def test_each_motion_begins_where_the_last_one_ended():
    run, _ = finished("ours")
    motions = [motion for _, motion in run.robot.motions]
    ends = [run.robot.arm.resting.joints, *(motion.end.joints for motion in motions)]
    for motion, joints in zip(motions, ends, strict=False):
        assert np.allclose(motion.stages[0].joints[0], joints, atol=1e-9)


@pytest.mark.parametrize(
    ("outcome", "stages", "closes", "felt"),
    [("held", 4, True, ""), ("missed", 3, True, "jaws 2 mm"), ("blocked", 3, False, "31 N on the way down")],
)
def test_an_empty_hand_is_not_carried_away_and_says_what_it_felt(monkeypatch, outcome, stages, closes, felt):
    robot = begin("ours").robot
    done = ExecutedGrasp(outcome, (), 0.002, 31.0, False)
    monkeypatch.setattr(pile_robot, "grasp_item", lambda world, T_world_hand, aperture_m: done)
    T = np.array([[0.0, 1, 0, 0.0], [1, 0, 0, 0.0], [0, 0, -1, 0.05], [0, 0, 0, 1.0]])
    attempt = robot.grasp(ExtractionAction(1, T, 0.06, 1.0))
    (_, motion), *none = robot.motions
    assert (len(motion.stages), motion.waiting_s > 0, none) == (stages, closes, [])
    assert attempt.message.startswith(felt)
    assert attempt.duration_s == robot.elapsed_s == motion.duration_s


def test_physics_that_blows_up_ends_a_search_with_its_actions_and_the_pile_kept(monkeypatch):
    run, calls = begin("ours"), []

    def grasp_item(world, T_world_hand, aperture_m):
        calls.append(len(world.items))
        if len(calls) > 1:
            raise PileUnsettled("the simulation of a grasp blew up", simulated_s=1.0, creep_m=np.inf)
        return ExecutedGrasp("missed", (), 0.0, 0.0, False)

    monkeypatch.setattr(pile_robot, "grasp_item", grasp_item)
    result = run.run()
    assert (result.outcome, result.actions, len(calls)) == ("arm_stopped", 1, 2)
    assert result.message == "the arm stopped: the simulation of a grasp blew up"
    assert len(run.robot.world.items) == calls[0]


def test_methods_begin_with_the_same_map_of_the_same_pile():
    runs = [begin(name) for name in ("ours", "xray_equal")]
    for run in runs:
        next(run.search.steps())
    assert runs[0].robot.motions[0][1].duration_s == runs[1].robot.motions[0][1].duration_s
    hidden_m3 = [run.search._done[0].hidden_m3 for run in runs]
    assert hidden_m3[0] == hidden_m3[1] > 0


def test_listening_takes_time_at_each_antenna_position():
    silent, loud = begin("ours").robot, begin("ours", tags=4).robot
    silent.scan(), loud.scan()
    (_, to_begin), (_, around) = loud.motions
    assert around.duration_s == pytest.approx(READ_S * len(loud.way.track))
    assert silent.motions[0][1].duration_s == to_begin.duration_s
    assert silent.elapsed_s < loud.elapsed_s / 2
    fixes = [TagFix(tag.epc, np.array([0.0, 0.0, 0.05]), np.full(3, 0.05), True) for tag in loud.tags.tags]
    before_s = loud.elapsed_s
    loud.look(np.array([0.1, 0.0, 0.05]), 0.6)
    quick_s, before_s = loud.elapsed_s - before_s, loud.elapsed_s
    loud.look(np.array([-0.1, 0.1, 0.05]), 0.6, fixes)
    assert loud.elapsed_s - before_s > 2 * quick_s


def test_the_room_and_the_tags_are_the_same_whenever_one_listens():
    """Two scans of one pile differ by noise, which is far less than another room would change."""
    robot = begin("ours", tags=4).robot
    first, second = ({fix.epc: fix.point_m for fix in robot.scan().fixes} for _ in range(2))
    assert set(first) == set(second)
    assert 0 < max(np.linalg.norm(first[epc] - second[epc]) for epc in first) < 0.01


def test_listening_again_joins_what_was_heard_on_another_way():
    robot = begin("ours", tags=4).robot
    robot.scan()
    before = {epc: trace.antenna_positions_m for epc, trace in robot._heard.items()}
    fixes, around = robot.listen_again(), robot.motions[-1][1]
    assert {fix.epc for fix in fixes} == set(before)
    assert around.duration_s == pytest.approx(READ_S * len(robot.other_way.track))
    for epc, positions_m in before.items():
        joined_m = robot._heard[epc].antenna_positions_m
        np.testing.assert_array_equal(joined_m[: len(positions_m)], positions_m)
        assert len(joined_m) > len(positions_m)


def test_a_tag_whose_thing_lay_still_stays_where_it_was():
    robot = begin("ours", tags=4).robot
    fixes = [fix for fix in robot.scan().fixes if fix.confident]
    assert fixes
    robot.look(np.array([-0.2, -0.2, 0.05]), 0.6)
    followed = robot.look(np.array([0.2, 0.2, 0.05]), 0.6, fixes).fixes
    assert len(followed) >= 2
    assert {fix.epc for fix in followed} <= {fix.epc for fix in fixes}
    stayed = [any(fix is old for old in fixes) for fix in followed]
    assert sum(stayed) >= len(followed) - 1


def test_the_arm_reaches_over_the_piles_and_not_across_the_room():
    robot = begin("ours").robot
    T = np.array([[0.0, 1, 0, 0.0], [1, 0, 0, 0.0], [0, 0, -1, 0.05], [0, 0, 0, 1.0]])
    assert robot.reaches(ExtractionAction(1, T, 0.06, 1.0))
    far = T.copy()
    far[0, 3] = 2.0
    action = ExtractionAction(1, far, 0.06, 1.0)
    assert not robot.reaches(action)
    assert robot.grasp(action).outcome == "unreachable"
    assert robot.elapsed_s == 0.0


def test_which_tags_are_located_confidently_is_for_the_surveyor_of_the_task_to_say():
    edges_m = (1e-4, 10.0)
    scans = [
        begin("fusebot", tags=4, surveyor=replace(PILE_SAR, max_box_m=(edge_m,) * 3)).robot.scan() for edge_m in edges_m
    ]
    none, some = ([fix.confident for fix in scan.fixes] for scan in scans)
    assert not any(none)
    assert any(some)


def test_a_target_that_is_not_there_is_not_found():
    result = begin("ours", absent=True).run()
    assert not result.found
    assert all(not step.attempt.shows_target for step in result.steps)


def test_true_masks_are_those_of_the_views_that_were_taken():
    run = begin("ours", segmenter=None)
    view = run.robot.scan().views[-1]
    masks = run.robot.true_masks(view)
    numbers = {item.number for item in run.task.scene.items}
    assert set(np.unique(masks.labels)) <= {0, *numbers}
    with pytest.raises(ValueError, match="did not take"):
        run.robot.true_masks(replace(view))


def test_tags_are_dealt_once_for_all_methods_and_as_many_as_there_are_items():
    scene = tiny()
    one, other = (tagged_items_of(scene, "any", 50, SEED) for _ in range(2))
    assert [(tag.epc, tag.number) for tag in one.tags] == [(tag.epc, tag.number) for tag in other.tags]
    taggable = [item for item in scene.items if item.taggable and item.number != scene.target]
    assert len(one.tags) == len(taggable)
    with pytest.raises(InputError, match="count: -1"):
        tagged_items_of(scene, "any", -1, SEED)


@pytest.mark.parametrize("seed", [-1, 1.5])
def test_a_seed_that_is_none_is_refused_before_anything_is_made(seed):
    one = task()
    for make in (
        lambda: replace(one, seed=seed),
        lambda: tagged_items_of(one.scene, "any", 1, seed),
        lambda: search_method("random", one.tags.target_size, seed),
        lambda: SimulatedPileRobot(scene=one.scene, tags=one.tags, seed=seed),
    ):
        with pytest.raises(InputError, match="seed"):
            make()


def test_voxels_in_which_the_target_would_be_overlooked_are_refused():
    target = task().tags.target_size
    with pytest.raises(InputError, match="too coarse") as refusal:
        SearchRun.of(replace(task(), spacing_m=0.1), search_method("fusebot", target))
    assert refusal.value.numbers["spacing_m"] == 0.1
    assert refusal.value.numbers["edge_m"] == target.shortest_m


def test_two_centimetres_are_fine_enough_for_every_target_that_is_drawn():
    for seed in range(300):
        check_spacing(0.02, float(draw_target(1, np.random.default_rng(seed)).size_m.min()))


def test_a_tag_that_comes_into_the_drop_zone_answers_there():
    run = begin("largest", tags=50)
    result = run.run()
    epcs = {tag.number: tag.epc for tag in run.task.tags.tags}
    heard = [epc for step in result.steps for epc in step.attempt.epcs]
    assert sorted(heard) == sorted(epcs[number] for number in run.robot.taken if number in epcs)
    assert not set(heard) & set(run.search._fixes)


@pytest.mark.parametrize("name", METHODS)
def test_every_method_can_be_made_and_knows_its_name(name):
    target = task().tags.target_size
    assert search_method(name, target).name == name


def test_an_unknown_method_is_refused_with_those_that_are_known():
    with pytest.raises(InputError, match="fusebot"):
        search_method("best", task().tags.target_size)


def test_the_film_has_every_change_of_the_table_and_every_grasp():
    run, result = finished("ours")
    film = film_of(run, result)
    assert len(film.grasps) == result.actions
    assert (
        len(film.piles)
        == len(run.robot.tables)
        == 1 + sum(step.attempt.outcome != "unreachable" for step in result.steps)
    )
    assert np.all(np.diff(film.times_s) > 0)
    assert film.times_s[-1] <= result.elapsed_s + 1e-6


def test_what_was_taken_leaves_the_pile_once_the_hand_has_closed_and_goes_with_it_to_the_drop_zone():
    run, result = finished("ours")
    film = film_of(run, result)
    assert len(film.carried) == sum(step.attempt.success for step in result.steps)
    changes_s = [pile.time_s for pile in film.piles[1:]]
    for carry in film.carried:
        assert carry.times_s[0] in changes_s
        assert np.all(np.diff(carry.times_s) > 0)
        assert np.linalg.norm(carry.T_world_hand[-1][:3, 3] - DROP_M) < 0.02
        for shape in carry.shapes:  # beside the fingers
            assert np.linalg.norm(shape.T_world_shape[:2, 3] - carry.T_world_hand[0][:2, 3]) < 0.25
    names = {shape.link for carry in film.carried for shape in carry.shapes}
    assert names <= {shape.link for shape in film.piles[0].shapes} - {"table"}
    assert not names & {shape.link for shape in film.piles[-1].shapes}


class NoObjects:
    """A segmenter that tells nothing apart."""

    def segment(self, view):
        return InstanceMasks(np.zeros(view.depth_m.shape, dtype=np.int64))


class NoGrasp:
    """Grasps that promise nothing."""

    def quality(self, view):
        flat = np.zeros(view.depth_m.shape)
        return GraspMaps(flat, flat, flat, flat)


@pytest.mark.parametrize("name", ["fusebot", "xray", "ours"])
def test_a_simulated_search_without_masks_ends_and_says_so(name):
    result = begin(name, segmenter=NoObjects()).run()
    assert (result.outcome, result.actions) == ("nothing_to_grasp", 0)
    assert result.elapsed_s > 0


@pytest.mark.parametrize("name", ["fusebot", "ours"])
def test_where_nothing_promises_to_hold_a_simulated_search_tries_and_ends(name):
    run = begin(name, quality=NoGrasp())
    result = run.run()
    assert 1 <= result.actions <= 15
    assert {step.chance for step in result.steps} == {0.0}
    assert result.found == (run.task.scene.target in run.robot.taken)


def arm_at(further_m=0.0, drop_m=DROP_M):
    """The arm of the studies with its foot further from the table, or with another drop zone."""
    arm, T_world_base = pile_arm(), T_WORLD_BASE.copy()
    T_world_base[1, 3] -= further_m
    return PileArm(arm.ik, T_world_base, arm.camera, np.array(drop_m), arm.resting)


def begin_with(arm, scene, name):
    one = SearchTask(scene, tagged_items_of(scene, "any", 0, SEED), SEED, spacing_m=0.02)
    robot = SimulatedPileRobot(scene=scene, tags=one.tags, seed=SEED, arm=arm)
    return SearchRun(one, search_method(name, one.tags.target_size, SEED), robot)


def box_at_the_far_end():
    """A box at the table's far end, and in it, where nobody sees it, the target."""
    things = {1: item(1, size_m=(0.10, 0.06, 0.08)), 2: item(2, size_m=(0.04, 0.04, 0.04), rgb=RED)}
    states = {number: flat_state(thing, at(0.1, 0.35, 0.04)) for number, thing in things.items()}
    return PileScene("box", 1, "hidden", tuple(things.values()), states, {1: 0, 2: 0}, target=2)


@pytest.mark.parametrize(
    ("of_arm", "scene_of", "name"),
    [({"further_m": 0.25}, box_at_the_far_end, "largest"), ({"drop_m": (3.0, 0.0, 0.35)}, tiny, "fusebot")],
    ids=["a box that it sees", "the drop zone"],
)
def test_what_the_arm_really_does_not_reach_ends_a_search_with_all_that_was_tried(of_arm, scene_of, name):
    scene = scene_of()
    run = begin_with(arm_at(**of_arm), scene, name)
    result = run.run()
    assert (result.outcome, result.actions) == ("out_of_reach", 5)
    assert {step.attempt.outcome for step in result.steps} == {"unreachable"}
    assert "the arm cannot hold its tool" in result.message
    assert all(step.attempt.message and step.masks.count and step.elapsed_s > 0 for step in result.steps)
    assert run.robot.taken == []
    assert all(np.array_equal(run.robot.world.states[n], state) for n, state in scene.states.items())


def test_an_arm_that_stands_too_far_off_to_look_ends_a_search_with_what_was_mapped_before():
    result = begin_with(arm_at(further_m=1.5), tiny(), "ours").run()
    assert (result.outcome, result.actions) == ("out_of_reach", 0)
    assert result.message.startswith("the arm cannot look at the pile: the arm cannot hold its tool")
    assert result.elapsed_s > 0 < result.hidden_m3
