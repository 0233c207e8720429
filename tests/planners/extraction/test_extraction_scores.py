"""Equations 4 and 5, by hand and by a slow loop."""

import dataclasses

import numpy as np
import pytest
from box_scenes import Block, looking_down, see
from extraction_scenes import question
from hypothesis import given
from hypothesis import strategies as st

from planners.extraction import FuseBotPolicy, MaskColumns, mask_scores, project_masks
from planners.extraction.projection import check_same_place
from planners.extraction.scores import gated_literally, passes
from planners.extraction.uncovering import mass_by_depth
from rfcompass.errors import InputError, ShapeError
from rfcompass.types import InstanceMasks, VoxelGrid

TWO = (Block((-0.1, 0.0, 0.03), (0.10, 0.10, 0.06)), Block((0.1, 0.0, 0.05), (0.10, 0.10, 0.10)))


def slow_scores(grid, columns, labels, gamma, per_column=False):
    scores = []
    for label in labels:
        mine, total = np.argwhere(columns.owner == label), 0.0
        highest_m = max((columns.surface_m[i, j] for i, j in mine), default=0.0)
        for i, j in mine:
            top_m = columns.surface_m[i, j] if per_column else highest_m
            for k in range(grid.values.shape[2]):
                z = grid.origin_m[2] + grid.spacing_m * k
                if z <= top_m + 1e-9:
                    total += gamma ** ((top_m - z) / 0.025) * grid.values[i, j, k]
        scores.append(total)
    return np.array(scores)


@given(st.integers(0, 9), st.floats(0.1, 1.0), st.booleans())
def test_the_scores_are_those_of_a_slow_loop(seed, gamma, per_column):
    rng = np.random.default_rng(seed)
    grid = VoxelGrid(np.array([0.1, -0.2, 0.31]), 0.01, rng.uniform(-0.1, 1.0, (6, 5, 8)))
    owner = rng.integers(0, 4, (6, 5))
    surface_m = np.where(owner > 0, rng.uniform(0.28, 0.42, owner.shape), np.nan)
    columns, labels = MaskColumns(owner, surface_m), np.array([3, 1, 9, 2])
    expected = slow_scores(grid, columns, labels, gamma, per_column)
    assert np.allclose(mask_scores(grid, columns, labels, gamma, per_column=per_column), expected)


def test_of_two_boxes_the_scores_are_as_by_hand():
    """Mass 1 at the table in the middle of each: 6 - 0.5 cm under one top, 10 - 0.5 cm under the other."""
    asked = question(TWO, mass=(1.0, 2.0), quality=(0.9, 0.9))
    values = np.where(asked.grid.values > 0.5, np.round(asked.grid.values), 0.0)
    grid = VoxelGrid(asked.grid.origin_m, asked.grid.spacing_m, values)
    scores = mask_scores(grid, project_masks(grid, asked.view, asked.masks), np.array([1, 2]), 0.7)
    assert np.allclose(scores, [0.7 ** (5.5 / 2.5), 2 * 0.7 ** (9.5 / 2.5)])
    # 0.456 and 0.516: at 0.7 the deeper, heavier mass wins; at 0.3 what lies near the surface does.
    for gamma, chosen in ((0.7, 2), (0.3, 1)):
        policy = FuseBotPolicy(gamma=gamma)
        assert policy.choose(grid, asked.view, asked.masks, asked.grasps).mask_label == chosen


def test_what_lies_above_the_surface_or_beside_the_mask_does_not_count():
    asked = question(TWO, quality=(0.9, 0.9))
    values = np.zeros(asked.grid.values.shape)
    values[20, 20, 6:] = 1.0
    values[30, 20, :] = 1.0
    grid = VoxelGrid(asked.grid.origin_m, asked.grid.spacing_m, values)
    assert not mask_scores(grid, project_masks(grid, asked.view, asked.masks), np.array([1, 2])).any()


def test_the_readings_differ_under_the_low_end_of_an_object():
    columns = MaskColumns(np.array([[1], [1]]), np.array([[0.025], [0.05]]))
    grid = VoxelGrid(np.zeros(3), 0.025, np.array([[[1.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]]]))
    assert mask_scores(grid, columns, np.array([1]), 0.5)[0] == 0.25
    assert mask_scores(grid, columns, np.array([1]), 0.5, per_column=True)[0] == 0.5


def test_a_column_belongs_to_the_higher_of_two_objects_once():
    view, labels = see((Block((0, 0, 0.02), (0.2, 0.2, 0.04)), Block((0, 0, 0.05), (0.1, 0.1, 0.02))), looking_down())
    grid = VoxelGrid(np.array([-0.195, -0.195, 0.01]), 0.01, np.ones((40, 40, 8)))
    columns = project_masks(grid, view, InstanceMasks(labels))
    assert columns.owner[20, 20] == 2
    assert np.isclose(columns.surface_m[20, 20], 0.06)
    assert np.isclose(columns.surface_m[11, 11], 0.04)
    assert np.isnan(columns.surface_m[0, 0])
    assert columns.owner[0, 0] == 0
    assert abs((columns.owner == 2).sum() - 100) <= 25
    assert abs((columns.owner > 0).sum() - 400) <= 50


def test_a_map_finer_than_the_image_has_no_holes():
    view, labels = see((Block((0, 0, 0.02), (0.2, 0.2, 0.04)),), looking_down(height_m=0.85))
    grid = VoxelGrid(np.array([-0.1975, -0.1975, 0.0025]), 0.005, np.ones((80, 80, 8)))
    owner = project_masks(grid, view, InstanceMasks(labels)).owner
    assert (owner[25:55, 25:55] == 1).all()


def test_the_ceiling_is_one_above_tau_and_zero_at_or_below_it():
    scores, quality = np.array([3.0, 2.0, -1.0]), np.array([0.5, 0.51, 1.0])
    assert gated_literally(scores, quality).tolist() == [0.0, 2.0, -1.0]
    assert passes(quality).tolist() == [False, True, True]
    assert not gated_literally(scores, np.zeros(3)).any()
    assert passes(np.zeros(3)).all()


def test_where_no_grasp_is_good_the_prose_takes_the_best_score_and_the_formula_knows_none():
    asked = question(mass=(1.0, 9.0, 1.0), quality=(0.4, 0.3, 0.2))
    by_prose = FuseBotPolicy().choose(*asked.parts())
    assert by_prose.mask_label == 2
    assert FuseBotPolicy(literal_gate=True).choose(*asked.parts()).score == 0.0


def test_gamma_and_tau_have_ranges():
    asked = question()
    with pytest.raises(InputError):
        FuseBotPolicy(gamma=0.0).choose(*asked.parts())
    with pytest.raises(InputError):
        FuseBotPolicy(tau=1.5)
    with pytest.raises(ShapeError):
        MaskColumns(np.zeros((2, 2), dtype=int), np.zeros((2, 3)))


def test_a_failure_counts_only_for_the_object_in_which_it_was():
    asked = question(mass=(5.0, 1.0, 1.0), quality=(0.9, 0.9, 0.9))
    policy = FuseBotPolicy(remembers=True)
    first = policy.choose(*asked.parts())
    assert first.mask_label == 1
    far = first.T_world_hand[:3, 3] + (0.0, 0.3, 0.0)
    assert policy.choose(*asked.parts(), [far]).mask_label == 1
    everywhere = [np.array([x, y, 0.06]) for x in np.arange(-0.2, -0.05, 0.03) for y in np.arange(-0.03, 0.08, 0.03)]
    assert policy.choose(*asked.parts(), everywhere).mask_label != 1
    assert dataclasses.replace(policy, remembers=False).choose(*asked.parts(), everywhere).mask_label == 1


def test_an_action_carries_the_scores_that_were_compared():
    asked = question(TWO, quality=(0.9, 0.2))
    for gate, compared in ((False, {1, 2}), (True, {1})):
        action = FuseBotPolicy(gate=gate).choose(*asked.parts())
        assert set(action.scores) == compared
        assert action.scores[action.mask_label] == action.score == max(action.scores.values())


def test_scores_are_of_some_labels_over_the_columns_of_the_map():
    grid, columns = VoxelGrid(np.zeros(3), 0.01, np.ones((6, 5, 8))), MaskColumns(np.ones((6, 5), int), np.ones((6, 5)))
    with pytest.raises(InputError, match="no mask"):
        mask_scores(grid, columns, np.array([], dtype=np.int64))
    other = MaskColumns(np.ones((7, 5), int), np.ones((7, 5)))
    with pytest.raises(ShapeError, match="columns"):
        mask_scores(grid, other, np.array([1]))
    with pytest.raises(ShapeError, match="columns"):
        mass_by_depth(grid, other, np.array([1]), 0.01, 0.01, 0.2)


def test_a_view_without_a_depth_shows_nothing_of_a_map():
    with pytest.raises(InputError, match="no pixel has a depth"):
        check_same_place(question().grid, np.full((4, 5, 3), np.nan))
