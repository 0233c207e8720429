"""Items: what is drawn can be, tags sit on surfaces, nothing but a target is red, waves lose what Fresnel says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pile_scenes import inside, is_red, item

from rfcompass.errors import PileError, ShapeError
from rfcompass.simulation.piles import KINDS, PILE_MATERIALS, PileItem, draw_distractor, draw_item, draw_target
from rfcompass.types import Cylinder, ItemSize

SEEDS = st.integers(0, 10_000)


@given(SEEDS, st.sampled_from(KINDS))
def test_tags_sit_on_the_surface_and_lie_flat(seed, kind):
    thing = draw_item(1, kind, np.random.default_rng(seed))
    points, normals, dipoles = thing.tag_places()
    assert np.abs(inside(thing, points)).max() < 1e-12
    assert (inside(thing, points + 1e-3 * normals) > 0).all()
    assert np.abs(np.einsum("ij,ij->i", normals, dipoles)).max() == 0
    assert np.linalg.norm(dipoles, axis=1) == pytest.approx(1)


@pytest.mark.parametrize("kind", ["box", "cylinder", "capsule", "ellipsoid"])
def test_the_volume_is_that_of_the_points_inside(kind):
    thing = item(1, kind, (0.04, 0.04, 0.1))
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (200_000, 3)) * thing.size_m
    assert (inside(thing, points) < 0).mean() * np.prod(thing.size_m) == pytest.approx(thing.volume_m3, rel=0.01)


@given(SEEDS, st.sampled_from(["box", "cylinder", "capsule", "ellipsoid"]))
def test_the_solid_of_the_radio_channel_has_the_items_volume(seed, kind):
    thing = draw_item(1, kind, np.random.default_rng(seed))
    assert thing.radio_shape.volume_m3 == pytest.approx(thing.volume_m3)
    assert isinstance(thing.radio_shape, Cylinder) == (kind in ("cylinder", "capsule"))


@given(SEEDS)
def test_only_targets_are_red(seed):
    rng = np.random.default_rng(seed)
    assert is_red(draw_target(1, rng).rgb)
    assert not is_red(draw_distractor(2, 0.35, rng).rgb)


@given(SEEDS)
def test_covers_are_as_frequent_as_asked_and_give_way(seed):
    rng = np.random.default_rng(seed)
    assert draw_distractor(1, 1.0, rng).deformable
    assert not draw_distractor(2, 0.0, rng).deformable


def test_tags_answer_on_anything_but_liquid_and_metal():
    silent = {name for name in PILE_MATERIALS if not item(1, material=name).taggable}
    assert silent == {"liquid", "metal"}


@pytest.mark.parametrize("name", [name for name in PILE_MATERIALS if name != "metal"])
def test_a_passage_loses_what_two_faces_reflect(name):
    material = PILE_MATERIALS[name]
    reflected = abs((1 - np.sqrt(material.permittivity)) / (1 + np.sqrt(material.permittivity))) ** 2
    assert 10 ** (-material.surface_loss_db / 10) == pytest.approx((1 - reflected) ** 2)


def test_water_takes_more_than_card_and_card_more_than_foam():
    losses = [PILE_MATERIALS[name].loss_db_per_m for name in ("liquid", "card", "foam")]
    assert losses == sorted(losses, reverse=True)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"number": 0}, "number"),
        ({"kind": "sock"}, "kind"),
        ({"size_m": np.array([0.1, 0.1, 0.0])}, "size_m"),
        ({"kind": "cylinder", "size_m": np.array([0.05, 0.04, 0.1])}, "size_m"),
        ({"kind": "capsule", "size_m": np.array([0.05, 0.05, 0.05])}, "size_m"),
        ({"material": "wood"}, "material"),
        ({"rgb": (0, 0, 256)}, "rgb"),
        ({"rgb": (0, 0)}, "rgb"),
    ],
)
def test_what_cannot_be_an_item_is_refused(change, key):
    fine = {"number": 1, "kind": "box", "size_m": np.array([0.1, 0.1, 0.1]), "material": "card", "rgb": (1, 2, 3)}
    with pytest.raises(PileError) as refused:
        PileItem(**{**fine, **change})
    assert refused.value.numbers["key"] == key


@given(st.permutations([0.1, 0.05, 0.02]))
def test_a_size_states_its_edges_longest_first(edges):
    size = ItemSize("mug", np.array(edges))
    assert (size.longest_m, size.shortest_m) == (0.1, 0.02)
    assert size.size_m.tolist() == [0.1, 0.05, 0.02]


@pytest.mark.parametrize("edges", [[0.1, 0.1, 0.0], [0.1, 0.1], [np.nan, 1, 1]])
def test_what_is_no_size_is_refused(edges):
    with pytest.raises(ShapeError):
        ItemSize("mug", np.array(edges))
