"""The table: things rest where they must, stay while nobody touches them, and leave when taken."""

import sys
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from pile_scenes import at, item, lowest_m, one_of_each, tiny, world_of

from rfcompass.errors import MissingExtra, PileError, PileUnsettled
from rfcompass.simulation.piles import PilePhysics, PileWorld, flat_state, pour
from rfcompass.simulation.piles.items import PANELS


def bits(states):
    return {number: state.tobytes() for number, state in states.items()}


def test_a_world_made_of_states_has_these_states_to_the_last_bit():
    scene = tiny()
    assert bits(scene.world().states) == bits(scene.states)


def test_equal_worlds_go_on_equally_to_the_last_bit():
    one, two = tiny().world(), tiny().world()
    number = one.items[0].number
    for world in (one, two):
        world.remove(number)
        world.settle()
    assert bits(one.states) == bits(two.states)


def test_nothing_sinks_into_the_table_and_all_comes_to_rest_on_it():
    world = one_of_each()
    world.settle()
    for thing in world.items:
        assert lowest_m(world, thing) == pytest.approx(0.0, abs=1e-3), thing.name


def test_a_box_rests_at_half_its_height():
    box = item(1)
    world = world_of((box, at(0.1, 0.2, 0.05)))
    assert world.settle().at_rest
    assert world.pose(1)[:3, 3] == pytest.approx([0.1, 0.2, box.size_m[2] / 2], abs=1e-3)


def test_what_is_at_rest_creeps_less_than_a_millimetre_in_two_seconds():
    scene = tiny()
    world = scene.world()
    moved_m = world.creep_m(2.0)
    assert sorted(moved_m) == sorted(scene.states)
    assert np.median(list(moved_m.values())) < 1e-3
    assert bits(world.states) == bits(scene.states), "measuring it must not move anything"


def test_the_panels_of_a_cover_hang_together_however_it_bends():
    cover = item(1, "cover", (0.2, 0.14, 0.01), "cloth")
    state = flat_state(cover, at(0, 0, 0.3))
    state[7:] = [0.9, -0.4, 0.2, 0.7]
    panels = PileWorld([cover], {1: state}).panel_poses(1)
    assert len(panels) == PANELS
    half_m = cover.size_m[0] / PANELS / 2
    for left, right in pairwise(panels):
        assert np.allclose(left @ [half_m, 0, 0, 1], right @ [-half_m, 0, 0, 1], atol=1e-12)
    turns = [np.arctan2(*(a[:3, :3].T @ b[:3, :3])[[0, 0], [2, 0]]) for a, b in pairwise(panels)]
    assert turns == pytest.approx(state[7:])


def test_a_cover_drapes_over_a_box():
    box, cover = item(1), item(2, "cover", (0.22, 0.14, 0.01), "cloth")
    world = world_of((box, at(0, 0, 0.02)), (cover, at(0, 0, 0.08)))
    world.settle()
    assert world.touching(2) == {1}
    heights = [T[2, 3] for T in world.panel_poses(2)]
    assert heights[2] > 0.04
    assert max(heights[0], heights[-1]) < 0.035


def test_taking_something_away_leaves_the_others_and_adds_nothing():
    world = one_of_each()
    before = bits(world.states)
    taken = world.remove(3)
    assert taken.number == 3
    assert [thing.number for thing in world.items] == [1, 2, 4, 5]
    assert bits(world.states) == {number: state for number, state in before.items() if number != 3}
    with pytest.raises(PileError, match="there are"):
        world.remove(3)


def test_what_leaned_on_a_thing_falls_when_it_is_taken():
    world = world_of((item(1), at(0, 0, 0.02)), (item(2), at(0, 0, 0.06)))
    world.settle()
    assert world.touching(2) == {1}
    world.remove(1)
    world.settle()
    assert world.pose(2)[2, 3] == pytest.approx(0.02, abs=1e-3)


def test_adding_puts_a_thing_where_its_state_says():
    world = one_of_each()
    before = bits(world.states)
    extra = item(9)
    world.add(extra, flat_state(extra, at(0.0, 0.3, 0.1)))
    assert bits(world.states) | before == bits(world.states)
    assert world.pose(9)[:3, 3] == pytest.approx([0.0, 0.3, 0.1])


@pytest.mark.parametrize("number", [1, 5])
def test_a_push_moves_a_thing_as_far_as_asked(number):
    world = one_of_each()
    world.settle()
    before = world.pose(number)[:2, 3].copy()
    moved_m = world.push(number, np.array([0.0, 0.06]))
    assert moved_m == pytest.approx(0.06, abs=0.005)
    assert (world.pose(number)[:2, 3] - before)[1] == pytest.approx(moved_m)


def test_a_weak_push_moves_nothing():
    world = one_of_each()
    world.settle()
    assert abs(world.push(1, np.array([0.05, 0.0]), most_n=0.01)) < 1e-3


@pytest.mark.parametrize("way", [[0.0, 0.0], [np.nan, 0.1], [0.1, 0.1, 0.1]])
def test_what_is_no_way_is_refused(way):
    with pytest.raises(PileError):
        one_of_each().push(1, np.array(way))


def test_a_simulation_that_blows_up_says_so_and_leaves_no_file(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(PileUnsettled, match="blew up"):
        one_of_each().step(0.5, {1: np.array([1e20, 0, 0])})
    assert not list(tmp_path.iterdir())
    assert capfd.readouterr() == ("", "")


def test_what_does_not_come_to_rest_in_time_says_how_far_it_still_moves():
    world = world_of((item(1), at(0, 0, 1.0)))
    rest = world.settle(longest_s=0.25)
    assert not rest.at_rest
    assert rest.passed_s == 0.25
    assert rest.moved_m > 0.1


def test_a_pour_that_does_not_come_to_rest_is_refused(monkeypatch):
    monkeypatch.setattr("rfcompass.simulation.piles.world.QUIET_M", -1.0)  # nothing is as still as that
    with pytest.raises(PileUnsettled, match="still moves") as restless:
        pour([item(1)], np.random.default_rng(0))
    assert restless.value.numbers["simulated_s"] == 6.0


def test_worlds_that_cannot_be_are_refused():
    box = item(1)
    state = flat_state(box, np.eye(4))
    for items, states in (
        ([box, box], {1: state}),
        ([box], {}),
        ([box], {1: state[:6]}),
        ([box], {1: state * np.nan}),
        ([box], {1: state * 2}),
    ):
        with pytest.raises(PileError):
            PileWorld(items, states)


@pytest.mark.parametrize("change", [{"friction": -1.0}, {"timestep_s": 0.0}, {"impratio": np.inf}])
def test_physics_that_cannot_be_is_refused(change):
    with pytest.raises(PileError):
        PilePhysics(**change)


@pytest.mark.parametrize("module", [None, SimpleNamespace(__version__="3.3.7")])
def test_without_mujoco_or_with_an_old_one_it_says_what_to_install(module, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", module)
    with pytest.raises(MissingExtra, match=r"rfcompass\[piles\]") as missing:
        PileWorld()
    assert missing.value.numbers["extra"] == "piles"
