"""Our policy: its chances, its costs, and that its order is the best one."""

import dataclasses
import itertools

import numpy as np
import pytest
from box_scenes import Block
from extraction_scenes import question
from hypothesis import given
from hypothesis import strategies as st

from planners.extraction import ActionCosts, FewestActionsPolicy, LayerRules, MaskColumns
from planners.extraction.layers import chance_in_sight
from planners.extraction.uncovering import mass_by_depth
from rfcompass.errors import InputError, ShapeError
from rfcompass.types import VoxelGrid

TARGET_M = np.array([0.05, 0.04, 0.03])
ALIKE = (Block((-0.13, 0.0, 0.03), (0.10, 0.10, 0.06)), Block((0.13, 0.0, 0.03), (0.10, 0.10, 0.06)))
OURS = FewestActionsPolicy(target_m=TARGET_M, trust=1.0)
THE_TWO = np.array([1, 2])


def test_what_lies_at_the_surface_shows_at_once_and_what_lies_deep_hardly():
    chance = chance_in_sight(np.array([-0.02, 0.0, 0.02, 0.05, 0.3]), 3, LayerRules())
    assert np.allclose(chance[:, :2], 1.0)
    assert (np.diff(chance[0, 1:]) < 0).all()
    assert (np.diff(chance[:, 2:], axis=0) > 0).all()
    assert chance[0, -1] < 0.01


def test_the_chance_is_the_share_of_drawn_piles():
    rng, rules, depth_m = np.random.default_rng(0), LayerRules(thickness_m=0.02, spacing_m=0.03), 0.06
    thick_m = rng.exponential(0.02, 400_000)
    thick_m = thick_m[thick_m < depth_m]
    between = rng.poisson((depth_m - thick_m) / 0.03)
    drawn = [(between < r).mean() for r in (1, 2, 3)]
    assert np.allclose(chance_in_sight(np.array([depth_m]), 3, rules)[:, 0], drawn, atol=4e-3)


def two_halves(peak):
    """Object 1 over columns 0..4, object 2 over 5..9, both 8 voxels high; all mass in one voxel."""
    owner = np.repeat([1] * 5 + [2] * 5, 10).reshape(10, 10)
    values = np.zeros((10, 10, 10))
    values[peak] = 3.0
    grid = VoxelGrid(np.array([0.0, 0.0, 0.005]), 0.01, values)
    return grid, MaskColumns(owner, np.full((10, 10), 0.08))


def test_a_target_well_under_one_object_shows_when_that_goes_at_its_depth():
    mass = mass_by_depth(*two_halves((1, 5, 2)), THE_TWO, 0.015, 0.02, 0.25)
    # Middle 2.5 cm, top 4 cm over the table, surface at 8 cm.
    assert np.allclose(mass[0, 4], 1.0)
    assert np.isclose(mass.sum(), 1.0)


def test_a_target_under_a_border_shows_when_either_object_goes():
    mass = mass_by_depth(*two_halves((4, 5, 2)), THE_TWO, 0.015, 0.02, 0.25)
    assert np.allclose(mass.sum(axis=1), 1.0)
    needs_most = mass_by_depth(*two_halves((4, 5, 2)), THE_TWO, 0.015, 0.02, 0.9).sum(axis=1)
    assert needs_most[1] < needs_most[0] < 1.0


def test_what_would_be_above_the_surface_lies_under_nothing():
    assert not mass_by_depth(*two_halves((1, 5, 9)), THE_TWO, 0.015, 0.02, 0.25).any()
    assert mass_by_depth(*two_halves((1, 5, 7)), THE_TWO, 0.015, 0.02, 0.25)[0, 0] == 1.0


def test_an_empty_map_has_no_mass():
    grid, columns = two_halves((1, 1, 1))
    blank = VoxelGrid(grid.origin_m, grid.spacing_m, -grid.values)
    assert not mass_by_depth(blank, columns, THE_TWO, 0.01, 0.01, 0.2).any()
    nowhere = MaskColumns(np.zeros((10, 10), dtype=int), np.full((10, 10), np.nan))
    assert not mass_by_depth(grid, nowhere, THE_TWO, 0.01, 0.01, 0.2).any()


@given(st.lists(st.tuples(*[st.floats(0.01, 1.0)] * 4), min_size=2, max_size=3))
def test_the_order_by_probability_for_each_action_has_the_fewest_expected_actions(chains):
    """Each place is a chain of two removals; all orders that keep each chain are tried."""
    found = np.array([[a, b] for a, b, _, _ in chains]) / (2.0 * len(chains))
    costs = 0.5 + np.array([[c, d] for _, _, c, d in chains])

    def expected(order):
        left, spent, done = 1.0, 0.0, dict.fromkeys(order, 0)
        for place in order:
            k = done[place]
            spent, left, done[place] = spent + left * costs[place, k], left - found[place, k], k + 1
        return spent

    orders = set(itertools.permutations([place for place in range(len(chains)) for _ in range(2)]))
    by_first = {}
    for order in orders:
        by_first[order[0]] = min(by_first.get(order[0], np.inf), expected(order))
    worth = (found.cumsum(axis=1) / costs.cumsum(axis=1)).max(axis=1)
    assert by_first[int(worth.argmax())] <= min(by_first.values()) + 1e-9


def test_of_two_alike_the_surer_grasp_and_of_equal_grasps_the_likelier_place():
    assert OURS.choose(*question(ALIKE, mass=(1.0, 1.0), quality=(0.4, 0.6)).parts()).mask_label == 2
    assert OURS.choose(*question(ALIKE, mass=(2.0, 1.0), quality=(0.6, 0.6)).parts()).mask_label == 1


def test_a_likely_place_is_worth_a_doubtful_grasp_until_failures_have_been_many():
    asked = question(ALIKE, mass=(2.2, 1.0), quality=(0.4, 0.7))
    assert OURS.choose(*asked.parts()).mask_label == 1
    elsewhere = [np.array([0.5, 0.5, 0.0])] * 4
    assert OURS.choose(*asked.parts(), elsewhere).mask_label == 2


def test_way_costs_little_but_decides_between_equals():
    dear = dataclasses.replace(OURS, costs=ActionCosts(travel_per_m=1.0))
    near = question((Block((0.0, 0.0, 0.03), (0.10, 0.10, 0.06)), ALIKE[1]), mass=(1.0, 1.0), quality=(0.6, 0.6))
    assert dear.choose(*near.parts()).mask_label == 1
    far = question((Block((-0.2, 0.0, 0.03), (0.10, 0.10, 0.06)), ALIKE[1]), mass=(1.0, 1.0), quality=(0.6, 0.6))
    assert dear.choose(*far.parts()).mask_label == 2


def test_less_trust_in_the_map_prefers_many_doubtful_places_to_one_likely_one():
    asked = question(ALIKE, mass=(1.0, 0.0), quality=(0.6, 0.6))
    values = asked.grid.values.copy()
    values[38:48, 15:25, 0] = 0.008
    grid = VoxelGrid(asked.grid.origin_m, asked.grid.spacing_m, values)
    for trust, chosen in ((1.0, 1), (0.3, 2)):
        policy = dataclasses.replace(OURS, trust=trust)
        assert policy.choose(grid, asked.view, asked.masks, asked.grasps).mask_label == chosen


def test_parameters_have_ranges():
    for wrong in ({"removals": 0}, {"removals": 1.5}, {"enough": 0.0}, {"trust": 0.0}, {"trust": np.inf}, {"tau": 2.0}):
        with pytest.raises(InputError):
            FewestActionsPolicy(target_m=TARGET_M, **wrong)
    with pytest.raises(ShapeError):
        FewestActionsPolicy(target_m=-TARGET_M)
    for wrong in ({"success": ((0.0, 0.0), (1.0, 1.0))}, {"success": ((1.0, 0.5), (0.0, 0.6))}, {"success": ()}):
        with pytest.raises(InputError):
            ActionCosts(**wrong)
    for wrong in (
        {"success": ((np.nan, 0.5),)}, {"success": ((0.5, np.nan),)}, {"lost": -1.0}, {"lost": np.inf},
        {"failures": 2.5}, {"area_m2": np.nan},
    ):  # fmt: skip
        with pytest.raises(InputError):
            ActionCosts(**wrong)
    with pytest.raises(InputError):
        LayerRules(spacing_m=0.0)
