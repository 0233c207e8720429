"""Where a tagged item is: its volume is kept, its tag is on it, and it is not where a view saw free space."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError, UnknownPart
from rfcompass.mapping import item_occupancy, items_occupancy, located_items, tagged_items
from rfcompass.mapping.item_occupancy import _sticks_out, lying_rotations, rotations_anyhow
from rfcompass.types import ItemSize, TagFix, TaggedItem, Workspace

ROOM = Workspace.between([-0.3, -0.3, 0.0], [0.3, 0.3, 0.4], 0.01)
NOTHING_FREE = np.zeros(ROOM.shape, dtype=bool)
EPC = "5246434f4d50415353f00001"
MIDDLE_M = np.array([0.0, 0.0, 0.2])


def thing(size_m=(0.08, 0.06, 0.05), sigma_m=0.0, deformable=False, point_m=MIDDLE_M):
    return TaggedItem(ItemSize("thing", np.array(size_m), deformable, EPC), point_m, np.eye(3) * sigma_m**2)


@pytest.mark.parametrize("sigma_m", [0.0, 0.02])
@pytest.mark.parametrize("deformable", [False, True])
def test_the_volume_is_that_of_the_item(sigma_m, deformable):
    values = item_occupancy(thing(sigma_m=sigma_m, deformable=deformable), ROOM, NOTHING_FREE)
    assert values.sum() * ROOM.spacing_m**3 == pytest.approx(0.08 * 0.06 * 0.05, rel=0.03)
    assert values.max() <= 1


def test_nothing_is_farther_from_an_exact_tag_than_the_item_is_long():
    size_m = np.array([0.1, 0.06, 0.04])
    values = item_occupancy(thing(size_m), ROOM, NOTHING_FREE)
    x, y, z = ROOM.axes_m()
    r_m = np.sqrt(x[:, None, None] ** 2 + y[:, None] ** 2 + (z - 0.2) ** 2)
    assert not values[r_m > np.linalg.norm(size_m) + 0.01].any()
    assert values[r_m < 0.015].mean() > 0.3  # half of what is about the tag is the item


def test_a_soft_item_lies_flat_about_its_tag():
    size_m = (0.2, 0.14, 0.01)
    spread = {}
    for deformable in (False, True):
        values = item_occupancy(thing(size_m, deformable=deformable), ROOM, NOTHING_FREE)
        z = ROOM.axes_m()[2] - 0.2
        spread[deformable] = (values.sum(axis=(0, 1)) * z**2).sum() / values.sum()
    assert spread[True] < 0.7 * spread[False]


def test_free_space_pushes_the_item_to_the_other_side():
    free = NOTHING_FREE.copy()
    free[30:] = True  # x > 0
    pushed, x = item_occupancy(thing(), ROOM, free), ROOM.axes_m()[0]
    assert (pushed.sum(axis=(1, 2)) * x).sum() / pushed.sum() < -0.01


def test_several_items_fill_at_least_what_one_does():
    one, other = (
        thing(),
        TaggedItem(ItemSize("b", np.array([0.1, 0.05, 0.05]), epc="f1"), MIDDLE_M + 0.03, np.zeros((3, 3))),
    )
    both = items_occupancy([one, other], ROOM, NOTHING_FREE)
    assert (both >= item_occupancy(one, ROOM, NOTHING_FREE) - 1e-12).all()
    assert both.max() <= 1


def test_the_same_question_has_the_same_answer():
    assert np.array_equal(item_occupancy(thing(), ROOM, NOTHING_FREE), item_occupancy(thing(), ROOM, NOTHING_FREE))


@given(st.lists(st.tuples(*[st.floats(0.001, 0.999)] * 3), min_size=1, max_size=5))
def test_turns_are_rotations(even):
    for R in rotations_anyhow(np.array(even)):
        assert pytest.approx(np.eye(3), abs=1e-9) == R @ R.T
        assert np.linalg.det(R) == pytest.approx(1.0)


@pytest.mark.parametrize("upright", [0, 1, 2])
def test_a_lying_item_has_the_edge_upright_that_was_asked_for(upright):
    (R,) = lying_rotations(np.array([0.7]), np.array([upright]))
    assert pytest.approx(np.eye(3), abs=1e-12) == R @ R.T
    assert R @ np.eye(3)[upright] == pytest.approx([0, 0, 1])
    assert np.linalg.det(R) == pytest.approx(1.0)


def test_turns_anyhow_have_no_direction_of_their_own():
    even = np.random.default_rng(0).random((4000, 3))
    assert np.abs(rotations_anyhow(even).mean(axis=0)).max() < 0.05


GLOVE, STRANGER = f"{EPC[:-1]}a", f"{EPC[:-1]}b"
SIZES = [
    ItemSize("mug", np.array([0.1, 0.08, 0.08]), epc=EPC),
    ItemSize("glove", np.array([0.2, 0.1, 0.01]), True, GLOVE),
]


def fix(epc, *, confident=True):
    return TagFix(epc, MIDDLE_M, np.full(3, 0.1), confident)


def test_the_database_says_what_a_tag_hangs_on():
    (paper,), (ours,) = located_items([fix(GLOVE.upper())], SIZES), tagged_items([fix(GLOVE.upper())], SIZES, 0.01)
    assert (paper.item, paper.longest_m, paper.deformable) == ("glove", 0.2, True)
    assert (ours.size.name, ours.covariance_m2[0, 0]) == ("glove", pytest.approx(1e-4))


def test_an_unsure_fix_is_left_to_the_papers_map_and_out_of_ours():
    assert len(located_items([fix(GLOVE, confident=False)], SIZES)) == 1
    assert tagged_items([fix(GLOVE, confident=False)], SIZES) == ()


def test_an_item_that_the_database_does_not_know_is_named():
    for look_up in (located_items, tagged_items):
        with pytest.raises(UnknownPart) as caught:
            look_up([fix(STRANGER)], SIZES)
        assert caught.value.numbers["epc"] == STRANGER
    with pytest.raises(InputError):
        tagged_items([fix(GLOVE)], SIZES, 0.0)


def slowly_sticks_out(rotations, centres, half, seen_free):
    """Share of the sample points of each box that lie in free voxels or beyond them, all at once in numpy."""
    steps = (np.arange(5) + 0.5) / 5 * 2 - 1
    points = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3) * half
    voxels = np.floor(np.einsum("nij,pj->npi", rotations, points) + centres[:, None]).astype(int)
    inside = ((voxels >= 0) & (voxels < seen_free.shape)).all(axis=-1)
    x, y, z = np.moveaxis(np.clip(voxels, 0, np.array(seen_free.shape) - 1), -1, 0)
    return (seen_free[x, y, z] | ~inside).mean(axis=1)


@given(seed=st.integers(0, 2**32 - 1))
def test_the_compiled_share_that_sticks_out_is_the_slow_one(seed):
    rng = np.random.default_rng(seed)
    rotations = rotations_anyhow(rng.random((7, 3)))
    centres, half = rng.uniform(-3, 15, (7, 3)), rng.uniform(0.3, 6, 3)
    free = rng.random((12, 9, 7)) < 0.4
    shares = _sticks_out(rotations, centres, half, free)
    assert shares == pytest.approx(slowly_sticks_out(rotations, centres, half, free), abs=1e-12)
