"""The posterior map: what its formula says by a slow loop, and what views and tags may do to it."""

import dataclasses
import pickle

import numpy as np
import pytest
from box_scenes import Block, looking_down, square_scan, views_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from rfcompass.errors import DuplicateEpc, InputError, NothingHidden, ShapeError, TargetTooLarge
from rfcompass.mapping import PosteriorRules, map_views, posterior_map
from rfcompass.mapping.box_kernels import box_kernels, convolve_boxes
from rfcompass.mapping.posterior_map import thing_above
from rfcompass.mapping.view_kernels import FREE, OUTSIDE, SURFACE, UNOBSERVED
from rfcompass.types import ItemSize, TaggedItem, Workspace

TABLE = Workspace.between([-0.3, -0.25, 0.0], [0.3, 0.25, 0.2], 0.02)
# A wide lid over a hollow, and a solid block: much can hide under the lid.
LID = Block((0.0, 0.0, 0.11), (0.26, 0.2, 0.02))
PILE = [LID, Block((-0.11, 0.0, 0.05), (0.04, 0.2, 0.1)), Block((0.11, 0.0, 0.05), (0.04, 0.2, 0.1))]
TARGET = ItemSize("target", np.array([0.08, 0.05, 0.04]))
PLAIN = PosteriorRules(hidden_power=0.0, company_power=0.0)
EPC = "5246434f4d50415353f00001"


def seen(blocks=tuple(PILE), table=TABLE, scan=None):
    return map_views(table, views_of(blocks, square_scan() if scan is None else scan))


def tagged(point_m, size_m=(0.08, 0.06, 0.05), sigma_m=0.0, deformable=False, epc=EPC):
    return TaggedItem(ItemSize("thing", np.array(size_m), deformable, epc), np.array(point_m), np.eye(3) * sigma_m**2)


def value(grid, point_m):
    return grid.values[tuple(TABLE.indices(np.array([point_m]))[0])]


def slow_mass(states, filled, rules, place):
    """The formula at one voxel, voxel by voxel of the target."""
    h, total = TABLE.spacing_m, 0.0
    for kernel in box_kernels(TARGET.size_m, h, rules.yaws):
        lowest_m = (place[2] + 0.5) * h - kernel.half_height_m
        if lowest_m <= -0.6 * h:
            continue
        cost = 0.0
        for q in np.argwhere(kernel.values > 0):
            v = tuple(np.array(place) + q - np.array(kernel.values.shape) // 2)
            outside = min(v) < 0 or any(a >= b for a, b in zip(v, TABLE.shape, strict=True))
            free = outside or states[v] in (FREE, OUTSIDE)
            cost += kernel.values[tuple(q)] * (rules.free_cost if free else rules.seen_cost * filled[v])
        total += np.exp(-cost - max(lowest_m, 0.0) / rules.height_m)
    return total


def test_the_formula_is_what_a_slow_loop_says():
    visual = seen()
    filled = thing_above(visual.states, TABLE.spacing_m, PLAIN.thickness_m)
    fast = posterior_map(visual, TARGET, rules=PLAIN).values
    near = np.argwhere(fast > 1e-6)  # far from all that is hidden, the fast one is cut off
    places = np.random.default_rng(0).permutation(near)[:25]
    slow = np.array([slow_mass(visual.states, filled, PLAIN, place) for place in places])
    found = fast[tuple(places.T)]
    assert found / found.sum() == pytest.approx(slow / slow.sum(), rel=1e-3)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_it_is_a_probability(count):
    points_m = np.random.default_rng(count).uniform([-0.1, -0.1, 0.0], 0.1, (count, 3))
    items = [tagged(point_m, sigma_m=0.02, epc=f"{EPC[:-1]}{n}") for n, point_m in enumerate(points_m)]
    values = posterior_map(seen(), TARGET, items).values
    assert values.sum() == pytest.approx(1.0)
    assert values.min() >= 0


def test_nearly_all_of_it_is_under_the_lid():
    grid = posterior_map(seen(), TARGET)
    x, y, z = (np.abs(axis) for axis in TABLE.axes_m())
    under = (x[:, None, None] < 0.13) & (y[:, None] < 0.1) & (z < 0.11)
    assert grid.values[under].sum() > 0.9


def test_a_move_of_everything_by_whole_voxels_moves_it():
    move_m = np.array([0.04, -0.02, 0.0])
    moved = [dataclasses.replace(block, centre_m=tuple(np.array(block.centre_m) + move_m)) for block in PILE]
    shift = np.eye(4)
    shift[:3, 3] = move_m
    poses = square_scan()
    here = posterior_map(seen(scan=poses), TARGET, [tagged((0.02, 0.0, 0.04))]).values
    there = posterior_map(
        seen(moved, scan=[shift @ pose for pose in poses]), TARGET, [tagged(np.array([0.02, 0.0, 0.04]) + move_m)]
    ).values
    assert np.roll(here, (2, -1), axis=(0, 1)) == pytest.approx(there, abs=1e-4 * here.max())


def test_where_a_tagged_item_is_the_target_is_less_likely():
    visual, place = seen(), (0.06, 0.0, 0.03)
    without = posterior_map(visual, TARGET, rules=PLAIN)
    rules = dataclasses.replace(PLAIN, tagged_cost=8.0)
    with_tag = posterior_map(visual, TARGET, [tagged(place)], rules=rules)
    assert value(with_tag, place) < 0.5 * value(without, place)
    assert value(with_tag, (-0.06, 0.0, 0.03)) > value(without, (-0.06, 0.0, 0.03))


def test_the_less_sure_a_tag_is_the_less_it_changes():
    visual, place = seen(), (0.06, 0.0, 0.03)
    without = posterior_map(visual, TARGET).values
    changes = [
        np.abs(posterior_map(visual, TARGET, [tagged(place, sigma_m=sigma_m)]).values - without).sum()
        for sigma_m in (0.0, 0.05, 0.1)
    ]
    assert changes[0] > changes[1] > changes[2]
    assert changes[2] < 0.5 * changes[0]


def test_things_keep_company():
    rules = dataclasses.replace(PLAIN, tagged_cost=0.0, company_power=1.0)
    grid = posterior_map(seen(), TARGET, [tagged((0.06, 0.0, 0.03))], rules=rules)
    x_m = TABLE.axes_m()[0]
    assert (grid.values.sum(axis=(1, 2)) * x_m).sum() > 0.01


def test_a_tag_on_a_pile_makes_that_pile_likelier():
    away = [dataclasses.replace(b, centre_m=(b.centre_m[0] + 0.4, *b.centre_m[1:])) for b in PILE]
    table = Workspace.between([-0.3, -0.25, 0.0], [0.7, 0.25, 0.2], 0.02)
    scan = [looking_down(x, y, 0.7) for x in (-0.2, 0.2, 0.6) for y in (-0.2, 0.2)]
    visual = seen([*PILE, *away], table, scan)
    half = 25
    left = [posterior_map(visual, TARGET, items).values[:half].sum() for items in ([], [tagged((0.0, 0.0, 0.04))])]
    assert left[0] == pytest.approx(0.5, abs=0.05)
    assert left[1] > left[0]


def test_what_was_removed_hides_nothing_any_more():
    gone = posterior_map(seen(PILE[1:]), TARGET)
    assert value(gone, (0.0, 0.0, 0.03)) < 0.05 * value(posterior_map(seen(), TARGET), (0.0, 0.0, 0.03))


def test_the_thing_above_fades_with_depth():
    states = np.full((1, 1, 6), UNOBSERVED, dtype=np.uint8)
    states[0, 0, 4:] = SURFACE, FREE
    found = thing_above(states, 0.01, 0.02)[0, 0]
    assert found == pytest.approx([np.exp(-2), np.exp(-1.5), np.exp(-1), np.exp(-0.5), 1.0, 0.0])


def test_the_lowest_surface_above_counts():
    states = np.array([[[UNOBSERVED, SURFACE, FREE, SURFACE]]], dtype=np.uint8)
    assert thing_above(states, 0.01, 0.01)[0, 0] == pytest.approx([np.exp(-1), 1.0, 0.0, 1.0])


@pytest.mark.parametrize("size_m", [(0.05, 0.04, 0.03), (0.1, 0.035, 0.03), (0.03, 0.03, 0.03), (0.071, 0.052, 0.033)])
def test_each_orientation_is_a_whole_box_about_its_middle(size_m):
    for kernel in box_kernels(np.array(size_m), 0.01, 4):
        assert kernel.values.sum() == pytest.approx(1.0)
        assert kernel.values == pytest.approx(kernel.values[::-1, ::-1, ::-1], abs=0.01)
        assert min(abs(kernel.half_height_m - edge / 2) for edge in size_m) < 1e-9


@settings(max_examples=25)
@given(
    size_m=st.lists(st.floats(0.01, 0.12), min_size=3, max_size=3),
    shape=st.tuples(st.integers(1, 14), st.integers(1, 14), st.integers(1, 10)),
    yaws=st.integers(1, 4),
    seed=st.integers(0, 2**32 - 1),
)
def test_boxes_are_convolved_as_scipy_convolves_their_shares(size_m, shape, yaws, seed):
    values = np.random.default_rng(seed).uniform(-5.0, 12.0, shape)
    kernels = box_kernels(np.array(size_m), 0.01, yaws)
    for kernel, fast in zip(kernels, convolve_boxes(values, kernels), strict=True):
        assert fast == pytest.approx(ndimage.convolve(values, kernel.values, mode="constant"), abs=1e-4)


def test_a_table_where_nothing_is_hidden_is_no_answer():
    with pytest.raises(NothingHidden) as caught:
        posterior_map(seen(()), TARGET)
    assert caught.value.numbers["voxels"] > 0


def test_what_cannot_be_is_refused():
    visual = seen()
    with pytest.raises(TargetTooLarge):
        posterior_map(visual, ItemSize("plank", np.array([2.0, 0.05, 0.02])))
    with pytest.raises(DuplicateEpc):
        posterior_map(visual, TARGET, [tagged((0, 0, 0.05))] * 2)
    with pytest.raises(ShapeError, match="has no tag"):
        TaggedItem(TARGET, np.zeros(3), np.eye(3))
    for covariance in (np.diag([1.0, -1e-4, 1.0]), np.array([[1, 0.5, 0], [0, 1, 0], [0, 0, 1]])):
        with pytest.raises(ShapeError, match="covariance"):
            TaggedItem(ItemSize("thing", np.ones(3), epc=EPC), np.zeros(3), covariance)


@pytest.mark.parametrize(
    "wrong", [{"free_cost": -1.0}, {"thickness_m": 0.0}, {"yaws": 0}, {"company_m": float("nan")}, {"height_m": -0.1}]
)
def test_rules_out_of_range_are_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        PosteriorRules(**wrong)


def test_the_rules_survive_a_pickle_although_they_are_given_by_name():
    rules = PosteriorRules(yaws=6)
    assert pickle.loads(pickle.dumps(rules)) == rules
