"""A part knows its dimensions and its tag layouts, and refuses what cannot be."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest

from rfcompass.errors import DuplicateEpc, InputError, PartError, ShapeError
from rfcompass.types.parts import Assembly, Part, StablePose, TagSelection, no_tags
from rfcompass.types.shapes import Box
from rfcompass.types.tags import TagLayout

EPCS = tuple(f"{i:024x}" for i in range(3))


def some_tags(**changes):
    fields = {
        "body": "crate",
        "epcs": EPCS,
        "frames": ("part",) * 3,
        "points_m": np.arange(9.0).reshape(3, 3) / 100,
        "dipoles": np.eye(3),
        "roles": ("part_end", "part", "part_end"),
    }
    return TagLayout(**{**fields, **changes})


def a_crate(**changes):
    box = Box([0.3, 0.2, 0.1])
    fields = {
        "part_id": "crate",
        "shape": box,
        "mass_kg": 2.0,
        "inertia_kg_m2": 2.0 * box.inertia_per_mass_m2,
        "grasp_width_m": 0.2,
        "tags": some_tags(),
        "selections": (
            TagSelection(EPCS[1:2]),
            TagSelection((EPCS[2], EPCS[0]), counterparts={"hand_left": EPCS[0], "hand_right": EPCS[2]}),
            TagSelection(EPCS[:2], spacing="inset"),
        ),
    }
    return Part(**{**fields, **changes})


def test_dimensions_are_those_of_the_bounding_box():
    crate = a_crate()
    assert (crate.shortest_m, crate.longest_m, crate.resting_height_m) == (0.1, 0.3, 0.05)


def test_a_layout_takes_its_tags_in_the_order_of_the_selection():
    layout = a_crate().layout(2)
    assert layout.epcs == (EPCS[2], EPCS[0])
    assert np.array_equal(layout.points_m, some_tags().points_m[[2, 0]])
    assert np.array_equal(layout.dipoles, np.eye(3)[[2, 0]])
    assert layout.roles == ("part_end", "part_end")
    assert layout.body == "crate"
    assert layout.counterparts[2] == {"hand_left": 1, "hand_right": 0}


def test_one_k_may_have_several_spacings():
    assert a_crate().layout(2, "inset").epcs == EPCS[:2]


@pytest.mark.parametrize("asked", [(3, "ends"), (1, "inset"), (0, "ends")])
def test_a_layout_that_is_not_there_is_answered_with_those_that_are(asked):
    with pytest.raises(PartError, match="1 ends, 2 ends, 2 inset"):
        a_crate().layout(*asked)


def test_a_tag_that_was_heard_in_another_spelling_is_the_same_tag():
    tags = some_tags(epcs=tuple(epc.upper() for epc in ("ab" * 12, "cd" * 12, "ef" * 12)))
    crate = a_crate(tags=tags, selections=(TagSelection(("AB" * 12,)),))
    assert crate.layout(1).epcs == ("ab" * 12,)
    assert crate.tagged(["CD-" * 12]).epcs == ("cd" * 12,)
    with pytest.raises(PartError):
        crate.tagged(["00" * 12])


def test_a_part_need_not_carry_tags():
    bare = a_crate(tags=no_tags("crate"), selections=())
    assert bare.tags.epcs == ()
    with pytest.raises(PartError, match="it has: none"):
        bare.layout(1)


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"part_id": ""}, PartError),
        ({"part_id": "two words"}, PartError),
        ({"part_id": "../etc"}, PartError),
        ({"part_id": None}, PartError),
        ({"mass_kg": 0.0}, PartError),
        ({"mass_kg": np.nan}, PartError),
        ({"grasp_width_m": -0.01}, PartError),
        ({"inertia_kg_m2": np.zeros((3, 3))}, PartError),
        ({"inertia_kg_m2": np.diag([1.0, 1.0, 3.0])}, PartError),  # more than any body has
        ({"inertia_kg_m2": np.array([[1, 0.1, 0], [0, 1, 0], [0, 0, 1.0]])}, PartError),
        ({"inertia_kg_m2": np.eye(2)}, ShapeError),
        ({"material": ""}, PartError),
        ({"rigid": "no"}, PartError),
        ({"tags": some_tags(body="robot")}, PartError),
        ({"tags": some_tags(frames=("part", "part", "base_link"))}, PartError),
        ({"tags": some_tags(epcs=("1", "2", "3"))}, InputError),
        ({"tags": some_tags(epcs=("AB" * 12, "ab" * 12, "cd" * 12))}, DuplicateEpc),
        ({"tags": some_tags(counterparts={3: {"hand_left": 0}})}, PartError),
        ({"selections": (TagSelection(("ff" * 12,)),)}, PartError),
        ({"selections": (TagSelection(EPCS[:1]), TagSelection(EPCS[1:2]))}, PartError),
    ],
)
def test_a_part_that_cannot_be_is_refused(changes, error):
    with pytest.raises(error):
        a_crate(**changes)


@pytest.mark.parametrize(
    "fields",
    [
        {"epcs": ()},
        {"epcs": (EPCS[0], EPCS[0])},
        {"epcs": EPCS, "counterparts": {"hand_left": "ff" * 12}},
        {"epcs": EPCS, "counterparts": {"base_front": EPCS[0]}},
        {"epcs": EPCS, "spacing": ""},
    ],
)
def test_a_selection_that_cannot_be_is_refused(fields):
    with pytest.raises(InputError):
        TagSelection(**fields)


@pytest.mark.parametrize(("scale", "probability"), [(1, 0.0), (1, 1.5), (1, np.nan), (2, 0.5)])
def test_a_stable_pose_that_cannot_be_is_refused(scale, probability):
    with pytest.raises(PartError):
        StablePose(np.diag([scale, scale, scale, 1.0]), probability)


@pytest.mark.parametrize("part_ids", [(), ("leg", "leg"), ("a b",)])
def test_an_assembly_names_each_part_once(part_ids):
    with pytest.raises(PartError):
        Assembly("table", part_ids)


@pytest.mark.parametrize("travel", [lambda part: pickle.loads(pickle.dumps(part)), copy.deepcopy])
def test_a_part_survives_a_pickle_and_stays_read_only(travel):
    crate = a_crate(stable_poses=(StablePose(np.eye(4), 0.5),))
    twin = travel(crate)
    assert twin.selections == crate.selections
    assert np.array_equal(twin.tags.points_m, crate.tags.points_m)
    assert np.array_equal(twin.shape.size_m, crate.shape.size_m)
    assert twin.stable_poses[0].height_m == 0.0
    for array in (twin.tags.points_m, twin.shape.size_m, twin.inertia_kg_m2, twin.stable_poses[0].T_support_part):
        assert not array.flags.writeable
    with pytest.raises(dataclasses.FrozenInstanceError):
        twin.mass_kg = 1.0
    with pytest.raises(TypeError):
        twin.selections[1].counterparts["hand_left"] = EPCS[2]
