"""Cushions: they keep their height alone, give way under load, come back, and change no pile without them."""

import hashlib
import sys

import numpy as np
import pytest
from pile_scenes import at, inside, item, one_of_each, tiny, world_of

from rfcompass.errors import PileError
from rfcompass.simulation.piles import (
    D415,
    PileFamily,
    PilePhysics,
    PileScene,
    PileWorld,
    cast_image,
    count_alone,
    draw_distractor,
    family,
    flat_state,
    grasp_item,
    look_down,
    open_pile,
    tag_items,
    write_pile,
)
from rfcompass.simulation.piles.engine import CUSHION_A_N, CUSHION_C_N, CUSHION_GIVES, GRAVITY_M_S2, pile_xml
from rfcompass.simulation.piles.materials import DENSITY_KG_M3
from rfcompass.simulation.piles.pile_shapes import drawn_shapes, radio_scene

SIZE_M = (0.12, 0.07, 0.05)
CUSHION = item(1, "cushion", SIZE_M, "cloth")
# Hashes from before there were cushions.
XML = "0ef41b8e409866e7ba32d345c15fb12e00099e9cff7e727cab86895aabcf87c2"
DRAWN = "ed67819008a176e2436dffba5d4b5a6444db1fcc5a175a2755b407c7a59ba9cf"


def given_way(world, number=1):
    """Share of its thickness by which a cushion has given way."""
    return -world.states[number][7] / world.item(number).size_m[2]


def pressed(load_n, material="card"):
    """A cushion with a flat box of a weight on it, at rest."""
    edge_m = np.sqrt(load_n / (GRAVITY_M_S2 * DENSITY_KG_M3[material] * 0.02))
    load = item(2, "box", (edge_m, edge_m, 0.02), material)
    assert load.mass_kg * GRAVITY_M_S2 == pytest.approx(load_n)
    world = world_of((CUSHION, at(0, 0, 0.025)), (load, at(0, 0, 0.0605)))
    world.settle()
    return world


@pytest.mark.parametrize("turned", [False, True])
def test_a_cushion_alone_keeps_its_height_either_way_up(turned):
    T = at(0, 0, 0.026)
    if turned:
        T[1, 1] = T[2, 2] = -1.0
    world = world_of((CUSHION, T))
    assert world.settle().at_rest
    assert world.corners_m(1)[:, 2].max() == pytest.approx(0.05, rel=0.05)


def test_a_cushion_gives_way_as_its_law_says_and_comes_back():
    shares = []
    for load_n in (0.3, 1.0):
        world = pressed(load_n)
        share = given_way(world)
        assert CUSHION_A_N * share + CUSHION_C_N * share**3 == pytest.approx(load_n, rel=0.05)
        world.remove(2)
        world.settle()
        assert given_way(world) == pytest.approx(0.0, abs=0.01)
        shares.append(share)
    assert 0.1 < shares[0] < shares[1] - 0.05


def test_a_cushion_is_never_pressed_below_its_range():
    world = pressed(30.0, "metal")
    assert given_way(world) == pytest.approx(CUSHION_GIVES, abs=0.01)


def test_halves_are_seen_drawn_and_heard_through_where_they_are():
    state = np.append(flat_state(CUSHION, at(0, 0, 0.025))[:7], -0.02)
    world = PileWorld([CUSHION], {1: state})
    assert world.corners_m(1)[:, 2].max() == pytest.approx(0.03)
    T = look_down(0.0, 0.0, 0.5)
    image = cast_image(world, D415, T)
    mine = image.numbers == 1
    assert mine.sum() == count_alone(world, 1, D415, T) > 0
    assert np.nanmin(image.depth_m[mine]) == pytest.approx(0.47, abs=1e-6)
    boxes = [shape for shape in drawn_shapes(world) if shape.link != "table"]
    assert [box.T_world_shape[2, 3] for box in boxes] == pytest.approx([0.0125, 0.0175])
    solids = radio_scene(world).obstacles
    assert sum(solid.shape.volume_m3 for solid in solids) == pytest.approx(CUSHION.volume_m3)


def test_the_tag_of_a_cushion_sits_on_the_outer_side_of_its_lower_half():
    points, normals, _ = CUSHION.tag_places()
    T = PileWorld([CUSHION], {1: flat_state(CUSHION, at(0, 0, 0.025))}).pose(1)
    assert (T @ [*points[0], 1.0])[:3] == pytest.approx([0, 0, 0], abs=1e-12)
    assert np.abs(inside(CUSHION, points)).max() < 1e-12
    assert normals.tolist() == [[0, 0, -1]]


def test_a_hand_holds_a_cushion_at_its_sides():
    world = world_of((CUSHION, at(0, 0, 0.026)))
    world.settle()
    T = look_down(0.0, 0.0, 0.033)
    done = grasp_item(world, T, 0.085)
    assert (done.outcome, done.taken, done.pinched) == ("held", (1,), False)
    assert world.items == ()


def test_a_pressed_cushion_comes_back_from_a_file_to_the_last_bit(tmp_path):
    world = pressed(0.5)
    scene = PileScene("hand", 0, "open", world.items, world.states, {1: 0, 2: 0}, 2)
    write_pile(scene, tmp_path / "pile.json")
    stored = open_pile(tmp_path / "pile.json")
    assert stored.fingerprint == scene.fingerprint
    assert stored.world().states[1].tobytes() == world.states[1].tobytes()


@pytest.mark.parametrize("count", [7, 9])
def test_a_state_of_another_shape_is_refused(count):
    state = np.resize(flat_state(CUSHION, np.eye(4)), count)
    with pytest.raises(PileError, match="not 8 finite numbers"):
        PileWorld([CUSHION], {1: state})


def test_without_cushions_the_model_and_the_draws_are_those_of_before():
    assert hashlib.sha256(pile_xml(one_of_each().items, PilePhysics()).encode()).hexdigest() == XML
    rng = np.random.default_rng(5)
    drawn = [draw_distractor(number, 0.35, rng) for number in range(1, 41)]
    text = repr([(thing.kind, thing.size_m.tolist(), thing.material, thing.rgb) for thing in drawn])
    assert hashlib.sha256(text.encode()).hexdigest() == DRAWN


@pytest.mark.skipif(
    (sys.modules["mujoco"].__version__, np.__version__, sys.platform) != ("4.0.0", "2.4.6", "linux"),
    reason="the hash was made with MuJoCo 4.0.0 and numpy 2.4.6 on Linux",
)
def test_a_scene_without_cushions_is_that_of_before_to_the_last_bit():
    assert tiny().fingerprint == "a4fc42a1d58f435d7dbad751a185a71fc12bce850f05165766f7cfe5754738d6"


def test_cushions_are_as_frequent_as_asked():
    rng = np.random.default_rng(1)
    kinds = [draw_distractor(1, 0.2, rng, 0.45).kind for _ in range(2000)]
    assert kinds.count("cushion") / 2000 == pytest.approx(0.45, abs=0.03)
    assert kinds.count("cover") / 2000 == pytest.approx(0.2, abs=0.03)
    assert family("soft_1p10").cushion_share == 0.45
    with pytest.raises(PileError):
        PileFamily("x", "poured", (3,), cover_share=0.7, cushion_share=0.4)


def test_tags_can_be_kept_to_soft_things():
    scene = tiny()
    soft = {thing.number for thing in scene.items if thing.deformable}
    tags = tag_items(scene, "any", len(soft), np.random.default_rng(0), only_soft=True)
    assert {tag.number for tag in tags.tags} == soft
    with pytest.raises(PileError):
        tag_items(scene, "any", len(soft) + 1, np.random.default_rng(0), only_soft=True)
