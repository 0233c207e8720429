"""Tags in a pile: each placement keeps its rule, liquid and metal stay silent, and tags ride on their items."""

import numpy as np
import pytest
from pile_scenes import at, inside, item

from rfcompass.errors import PileError
from rfcompass.simulation.piles import PLACEMENTS, PileScene, flat_state, tag_items

# Target 1 in the middle of pile 0; 2 stands on it, 3 near it, 4 and 5 across, 6 and 7 in pile 1; 8 is metal, 9 liquid.
PLACED = {
    1: (-0.1, 0.0, 0.02),
    2: (-0.1, 0.0, 0.0598),
    3: (-0.1, 0.08, 0.02),
    4: (0.1, 0.0, 0.02),
    5: (0.1, 0.1, 0.02),
    6: (0.6, 0.0, 0.02),
    7: (0.7, 0.0, 0.02),
    8: (0.1, -0.1, 0.02),
    9: (0.6, 0.1, 0.02),
}
STUFF = {8: "metal", 9: "liquid"}


@pytest.fixture(scope="module")
def scene():
    items = [item(n, material=STUFF.get(n, "card")) for n in PLACED]
    states = {n: flat_state(items[n - 1], at(*place)) for n, place in PLACED.items()}
    return PileScene("by_hand", 1, "open", tuple(items), states, {n: int(n in (6, 7, 9)) for n in PLACED}, 1)


def tagged(scene, placement, count, seed=0):
    return {tag.number for tag in tag_items(scene, placement, count, np.random.default_rng(seed)).tags}


@pytest.mark.parametrize(
    ("placement", "some_of", "all_of"),
    [
        ("any", {2, 3, 4, 5, 6, 7}, {2, 3, 4, 5, 6, 7}),
        ("touching", {2}, {2, 3, 4, 5, 6, 7}),
        ("same_pile", {3, 4, 5}, {3, 4, 5, 6, 7}),
        ("opposite", {4, 5}, {4, 5, 6, 7}),
        ("other_pile", {6, 7}, {6, 7}),
        ("target", {1}, {1, 2, 3, 4, 5, 6, 7}),
    ],
)
def test_each_placement_keeps_its_rule(scene, placement, some_of, all_of):
    chosen = [tagged(scene, placement, 2, seed) for seed in range(40)]
    assert all(numbers & some_of for numbers in chosen)
    assert set().union(*chosen) == all_of
    assert {len(numbers) for numbers in chosen} == {3 if placement == "target" else 2}


def test_no_tags_are_no_tags(scene):
    tags = tag_items(scene, "none", 0, np.random.default_rng(0))
    assert tags.tags == () == tags.sizes
    assert tags.target_size.epc is None


def test_the_database_holds_the_tagged_items_and_says_nothing_of_places(scene):
    tags = tag_items(scene, "target", 3, np.random.default_rng(0))
    assert [size.epc for size in tags.sizes] == [tag.epc for tag in tags.tags]
    assert tags.target_size.epc in {tag.epc for tag in tags.tags}
    assert len({tag.epc for tag in tags.tags}) == 4
    assert set(tags.target_size.__slots__) == {"name", "size_m", "deformable", "epc"}


def test_neither_epcs_nor_names_tell_the_numbers_of_items(scene):
    seen = {}
    for seed in range(30):
        tags = tag_items(scene, "any", 6, np.random.default_rng(seed))
        for tag, size in zip(tags.tags, tags.sizes, strict=True):
            seen.setdefault((tag.epc, size.name), set()).add(tag.number)
    assert set(map(len, seen.values())) == {6}


def test_tags_are_on_their_items_wherever_those_went_and_leave_with_them(scene):
    tags = tag_items(scene, "any", 6, np.random.default_rng(0))
    world = scene.world()
    world.push(4, np.array([0.05, 0.0]))
    epcs, points, dipoles = tags.placed(world)
    assert np.linalg.norm(dipoles, axis=1) == pytest.approx(1)
    for tag, point in zip(tags.tags, points, strict=True):
        T = world.pose(tag.number)
        assert abs(inside(world.item(tag.number), ((point - T[:3, 3]) @ T[:3, :3])[None])[0]) < 1e-9
    world.remove(4)
    assert set(epcs) - set(tags.placed(world)[0]) == {tag.epc for tag in tags.tags if tag.number == 4}


@pytest.mark.parametrize(
    ("placement", "count"), [("touching", 7), ("other_pile", 3), ("none", 1), ("near", 1), ("any", -1)]
)
def test_tags_that_cannot_be_placed_are_refused(scene, placement, count):
    with pytest.raises(PileError):
        tag_items(scene, placement, count, np.random.default_rng(0))


def test_every_placement_is_tested_here():
    assert set(PLACEMENTS) == {"none", "any", "touching", "same_pile", "opposite", "other_pile", "target"}
