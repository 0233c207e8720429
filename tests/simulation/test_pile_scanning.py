"""A scan of a pile: what lies over a tag costs power; what is handed out knows no truth."""

import numpy as np
import pytest
from pile_scenes import at, item, tiny, world_of

from rfcompass.errors import PileError
from rfcompass.simulation import AntennaTrack
from rfcompass.simulation.piles import (
    ItemTag,
    PileRig,
    PileWorld,
    TaggedItems,
    hear_tags,
    scan_pile,
    scan_poses,
    tag_cover,
    tag_items,
)
from rfcompass.types import ItemSize

TRACK = AntennaTrack.square((0.0, 0.0), 0.4, 0.5, 0.1)
EPC = "5246434f4d50415353f00000"
SIZE = ItemSize("box", np.array([0.08, 0.05, 0.04]), epc=EPC)
# A tag on the upper side of a box that stands on the table.
TAGGED = TaggedItems((ItemTag(EPC, 1, np.array([0, 0, 0.02]), np.array([0.0, 1, 0])),), (SIZE,), SIZE)
BOX = (item(1), at(0.0, 0.0, 0.02))


def lid(material):
    """A board over the box that no line from the track to the tag misses."""
    return item(2, size_m=(0.3, 0.3, 0.02), material=material), at(0.0, 0.0, 0.06)


def scanned(world, tags=TAGGED, seed=0):
    return scan_pile(world, tags, scan_poses()[:1], TRACK, np.random.default_rng(seed))


def level(scan):
    return np.abs(scan.scan([EPC]).trace(EPC).channel).mean()


def test_nothing_lies_before_a_tag_in_the_open():
    cover = tag_cover(world_of(BOX), TAGGED, TRACK.positions_m)
    assert cover.hidden_share.tolist() == [0.0]
    assert cover.material == ("",)
    assert not cover.loss_db.any()


@pytest.mark.parametrize("material", ["cloth", "plastic", "liquid", "metal"])
def test_a_lid_hides_the_tag_and_has_a_name(material):
    cover = tag_cover(world_of(BOX, lid(material)), TAGGED, TRACK.positions_m)
    assert cover.hidden_share.tolist() == [1.0]
    assert cover.material == (material,)
    assert (cover.things == 1).all()


def test_a_tag_below_its_item_is_behind_it():
    below = TaggedItems((ItemTag(EPC, 1, np.array([0, 0, -0.02]), np.array([0.0, 1, 0])),), (SIZE,), SIZE)
    cover = tag_cover(world_of(BOX), below, TRACK.positions_m)
    assert cover.material == ("card",)


def test_liquid_weakens_what_comes_back_and_metal_silences_it():
    free, wet, shut = (scanned(world_of(BOX, *lids)) for lids in ((), (lid("liquid"),), (lid("metal"),)))
    assert level(wet) < 0.3 * level(free)
    reads = [scan.inventory.reads_per_tag[0] for scan in (free, wet, shut)]
    assert reads[0] >= reads[1] > reads[2]


def test_a_lid_of_plastic_delays_the_wave():
    quiet = [scanned(world_of(BOX, *lids)).scan([EPC]).trace(EPC) for lids in ((), (lid("plastic"),))]
    turned = np.angle(quiet[1].channel[0, 0] / quiet[0].channel[0, 0])
    assert abs(turned) > 0.1


def test_the_same_seed_gives_the_same_scan_and_another_one_does_not():
    one, same, other = (scanned(world_of(BOX), seed=seed).inventory.heard for seed in (0, 0, 1))
    assert np.array_equal(one, same)
    assert one.shape != other.shape or not np.array_equal(one, other)


def test_what_happens_to_the_pile_afterwards_changes_nothing():
    scene = tiny()
    world, tags = scene.world(), tag_items(scene, "any", 2, np.random.default_rng(0))
    scan = scan_pile(world, tags, scan_poses()[:2], TRACK, np.random.default_rng(0))
    before = scan.views[0].depth_m.copy(), scan.inventory.heard.copy()
    world.remove(tags.tags[0].number)
    world.settle(0.5)
    assert np.array_equal(before[0], scan.views[0].depth_m, equal_nan=True)
    assert np.array_equal(before[1], scan.inventory.heard)


def test_antenna_positions_are_those_the_arm_believes_in_the_frame_of_the_table():
    believed = scanned(world_of(BOX)).scan([EPC]).trace(EPC).antenna_positions_m
    assert np.isin(np.round(believed, 9), np.round(TRACK.positions_m, 9)).all()


def test_a_table_without_a_tag_is_refused():
    with pytest.raises(PileError, match="carries a tag"):
        scanned(PileWorld())


def test_a_tag_under_an_item_on_the_table_is_heard_at_the_table():
    low = TaggedItems((ItemTag(EPC, 1, np.array([0, 0, -0.02]), np.array([0.0, 1, 0])),), (SIZE,), SIZE)
    assert len(scanned(world_of((item(1), at(0.0, 0.0, 0.0199))), low).inventory)


def test_the_arm_errs_by_the_jitter_that_was_asked_for():
    still, shaky = (
        scan_pile(
            world_of(BOX), TAGGED, scan_poses()[:1], TRACK, np.random.default_rng(0), PileRig(jitter_m=jitter_m)
        ).inventory.heard
        for jitter_m in (0.0, 0.01)
    )
    n = min(len(still), len(shaky))
    assert not np.allclose(still[:n], shaky[:n])


def test_what_has_rolled_off_the_table_is_not_heard():
    scene = tiny()
    tags = tag_items(scene, "any", 2, np.random.default_rng(0))
    states = dict(scene.states)
    gone = tags.tags[0]
    states[gone.number] = np.concatenate([[2.5, 0.0], states[gone.number][2:]])
    world = PileWorld(scene.items, states, scene.physics)
    heard = hear_tags(world, tags, TRACK, np.random.default_rng(0))
    assert gone.epc not in heard.epcs
    assert tags.tags[1].epc in heard.epcs
