"""What every extraction policy obeys: ours, the paper's, its baselines."""

import dataclasses
import itertools
import pickle

import numpy as np
import pytest
from extraction_scenes import THREE, grasps_of, question

from planners.extraction import (
    FewestActionsPolicy,
    FuseBotPolicy,
    LargestMaskPolicy,
    MapMassPolicy,
    NaivePolicy,
    RandomPolicy,
    XRayPolicy,
)
from planners.extraction.candidates import NEAR_M
from rfcompass.errors import InputError, NothingToGrasp, ShapeError
from rfcompass.interfaces import ExtractionPolicy
from rfcompass.types import GraspMaps, InstanceMasks, VoxelGrid

TARGET_M = np.array([0.05, 0.04, 0.03])
POLICIES = [
    FuseBotPolicy(),
    FuseBotPolicy(literal_gate=True),
    FuseBotPolicy(gate=False, per_column=True),
    NaivePolicy(),
    NaivePolicy(gate=True),
    RandomPolicy(seed=3),
    RandomPolicy(seed=3, gate=False),
    LargestMaskPolicy(),
    XRayPolicy(target_m=TARGET_M),
    XRayPolicy(target_m=TARGET_M, gate=True),
    MapMassPolicy(),
    FewestActionsPolicy(target_m=TARGET_M),
    FewestActionsPolicy(target_m=TARGET_M, gate=True, removals=1),
]


def named(policy):
    changed = [f"{f.name}={getattr(policy, f.name)}" for f in dataclasses.fields(policy) if f.name in ("gate", "seed")]
    return f"{type(policy).__name__}({', '.join(changed)})"


OURS = FewestActionsPolicy(target_m=TARGET_M, gate=True, trust=1.0)
every_policy = pytest.mark.parametrize("policy", POLICIES, ids=named)


def same(one, other):
    return (
        one.mask_label == other.mask_label
        and np.allclose(one.T_world_hand, other.T_world_hand, rtol=0, atol=1e-9)
        and one.aperture_m == other.aperture_m
    )


def level_m(action, place_m):
    """Distance of the hand to a place, seen from above."""
    return np.linalg.norm(action.T_world_hand[:2, 3] - place_m[:2])


@every_policy
def test_an_object_of_the_masks_is_taken_by_a_hand_that_comes_straight_down(policy):
    assert isinstance(policy, ExtractionPolicy)
    asked = question()
    action = policy.choose(*asked.parts())
    assert action.mask_label in (1, 2, 3)
    assert np.allclose(action.T_world_hand[:3, 2], [0, 0, -1])
    assert np.isclose(np.linalg.det(action.T_world_hand[:3, :3]), 1.0)
    assert 0 < action.aperture_m <= 0.085
    assert np.isfinite(action.score)


@every_policy
def test_equal_questions_have_equal_answers_also_after_others_and_out_of_a_pickle(policy):
    first = policy.choose(*question().parts())
    policy.choose(*question(mass=(0.0, 5.0, 1.0)).parts())
    assert same(policy.choose(*question().parts()), first)
    assert same(pickle.loads(pickle.dumps(policy)).choose(*question().parts()), first)


@every_policy
@pytest.mark.parametrize("names", [(0, 3, 1, 2), (0, 70, 5, 900)])
def test_other_labels_rename_the_answer_and_change_nothing_else(policy, names):
    for asked in (question(), question(mass=(0.0, 0.0, 0.0), quality=(0.0, 0.0, 0.0))):
        renamed = dataclasses.replace(asked, masks=InstanceMasks(np.array(names)[asked.masks.labels]))
        before, after = policy.choose(*asked.parts()), policy.choose(*renamed.parts())
        assert after.mask_label == names[before.mask_label]
        assert same(dataclasses.replace(after, mask_label=before.mask_label), before)


@every_policy
def test_the_answer_moves_with_the_world(policy):
    asked, shift_m = question(), np.array([0.4, -0.25, 0.125])
    T = asked.view.T_world_camera.copy()
    T[:3, 3] += shift_m
    moved = dataclasses.replace(
        asked,
        view=dataclasses.replace(asked.view, T_world_camera=T),
        grid=VoxelGrid(asked.grid.origin_m + shift_m, asked.grid.spacing_m, asked.grid.values),
    )
    failed_m = np.array([-0.13, 0.02, 0.06])
    for failed in ((), (failed_m,)):
        before = policy.choose(*asked.parts(), failed)
        after = policy.choose(*moved.parts(), [point_m + shift_m for point_m in failed])
        assert after.mask_label == before.mask_label
        assert np.allclose(after.T_world_hand[:3, 3], before.T_world_hand[:3, 3] + shift_m, atol=1e-9)


@every_policy
def test_without_objects_there_is_nothing_to_grasp(policy):
    asked = question()
    none = dataclasses.replace(asked, masks=InstanceMasks(np.zeros_like(asked.masks.labels)))
    unseen = dataclasses.replace(
        asked, view=dataclasses.replace(asked.view, depth_m=np.where(asked.masks.labels, np.nan, asked.view.depth_m))
    )
    for empty in (none, unseen):
        with pytest.raises(NothingToGrasp) as caught:
            policy.choose(*empty.parts())
        assert caught.value.numbers["masks"] == empty.masks.count


@every_policy
def test_where_nothing_can_be_grasped_something_is_tried_all_the_same(policy):
    asked = question(quality=(0.0, 0.0, 0.0))
    action = policy.choose(*asked.parts())
    assert action.mask_label in (1, 2, 3)
    tips_m = action.T_world_hand[2, 3] - 0.013
    assert tips_m > 0
    # A block is gripped across its shorter side.
    if action.mask_label == 1:
        assert abs(action.T_world_hand[:3, 1] @ [0, 1, 0]) > 0.99


@every_policy
def test_an_empty_map_still_has_an_answer(policy):
    asked = question()
    blank = VoxelGrid(asked.grid.origin_m, asked.grid.spacing_m, np.zeros_like(asked.grid.values))
    action = policy.choose(blank, asked.view, asked.masks, asked.grasps)
    assert action.mask_label in (1, 2, 3)


@pytest.mark.parametrize("policy", [p for p in POLICIES if not isinstance(p, RandomPolicy)], ids=named)
def test_who_remembers_goes_elsewhere_after_some_failures_and_who_does_not_stays(policy):
    asked = question(mass=(1.5, 1.0, 1.0), quality=(0.9, 0.9, 0.9))
    forgetful = dataclasses.replace(policy, remembers=False)
    first, failed_m, taken = policy.choose(*asked.parts()), [], []
    for _ in range(5):
        action = policy.choose(*asked.parts(), failed_m)
        assert same(forgetful.choose(*asked.parts(), failed_m), first)
        taken.append(action)
        failed_m.append(action.T_world_hand[:3, 3])
    assert level_m(taken[1], failed_m[0]) > NEAR_M - 1e-9
    if isinstance(policy, NaivePolicy) and not policy.gate:  # it stays about its voxel
        assert max(level_m(action, THREE[0].centre_m) for action in taken) <= policy.reach_m + 0.01
    else:
        assert len({action.mask_label for action in taken}) >= 2


@pytest.mark.parametrize("gate", [True, False])
def test_who_draws_and_remembers_draws_what_failed_less_often_and_elsewhere_on_it(gate):
    """With the gate what failed is no longer among what is drawn; a draw comes from the number of failures, too."""
    asked = question(quality=(0.9, 0.9, 0.9))
    labels, best = asked.masks.labels, FuseBotPolicy().choose(*asked.parts())
    failed_m = [best.T_world_hand[:3, 3]]
    drawn = {True: 0, False: 0}
    for seed, remembers in itertools.product(range(60), drawn):
        policy = RandomPolicy(seed=seed, gate=gate, remembers=remembers)
        action = policy.choose(*asked.parts(), failed_m)
        if action.mask_label == best.mask_label:
            drawn[remembers] += 1
            assert (level_m(action, failed_m[0]) > NEAR_M - 1e-9) == remembers
    third = 60 / len(np.unique(labels[labels > 0]))
    assert drawn[False] == pytest.approx(third, abs=10)
    assert drawn[True] == 0 if gate else 0 < drawn[True] < drawn[False] - 5


@every_policy
def test_images_of_different_sizes_are_refused(policy):
    asked = question()
    small = InstanceMasks(asked.masks.labels[::2])
    with pytest.raises(ShapeError):
        policy.choose(asked.grid, asked.view, small, asked.grasps)
    with pytest.raises(ShapeError):
        policy.choose(asked.grid, asked.view, asked.masks, GraspMaps(*np.zeros((4, 3, 3))))


GATED = [
    FuseBotPolicy(),
    LargestMaskPolicy(),
    MapMassPolicy(gate=True),
    NaivePolicy(gate=True),
    XRayPolicy(target_m=TARGET_M, gate=True),
    OURS,
]


@pytest.mark.parametrize("policy", GATED, ids=named)
def test_the_gate_bars_what_can_hardly_be_grasped_as_long_as_something_can(policy):
    asked = question(mass=(5.0, 1.0, 1.0), quality=(0.4, 0.4, 0.6))
    assert policy.choose(*asked.parts()).mask_label == 3
    assert dataclasses.replace(policy, gate=False).choose(*asked.parts()).mask_label == 1
    hopeless = dataclasses.replace(asked, grasps=grasps_of(asked.masks.labels, (0.4, 0.3, 0.3)))
    assert policy.choose(*hopeless.parts()).mask_label == 1


def test_with_the_gate_only_what_can_be_grasped_is_drawn_as_long_as_something_can():
    asked = question(quality=(0.4, 0.4, 0.6))
    hopeless = dataclasses.replace(asked, grasps=grasps_of(asked.masks.labels, (0.4, 0.3, 0.3)))

    def drawn(of, gate):
        return {RandomPolicy(seed=seed, gate=gate).choose(*of.parts()).mask_label for seed in range(20)}

    assert drawn(asked, True) == {3}
    assert drawn(asked, False) == drawn(hopeless, True) == {1, 2, 3}


@every_policy
@pytest.mark.parametrize("failed_m", [np.full(3, np.nan), np.zeros(2), np.zeros((1, 3)), 0.0, None])
def test_places_of_failed_grasps_that_are_none_are_refused(policy, failed_m):
    for remembers in (True, False):
        with pytest.raises(ShapeError, match="failed_m"):
            dataclasses.replace(policy, remembers=remembers).choose(*question().parts(), [failed_m])


@every_policy
def test_a_failed_grasp_that_counts_no_more_is_nowhere(policy):
    nowhere = np.full(3, np.inf)
    assert policy.choose(*question().parts(), [nowhere]).mask_label in (1, 2, 3)


@every_policy
@pytest.mark.parametrize("shift_m", [(50.0, 0.0, 0.0), (0.0, -50.0, 0.0), (0.0, 0.0, 50.0)])
def test_a_map_in_another_frame_than_the_view_is_refused(policy, shift_m):
    asked = question()
    away = VoxelGrid(asked.grid.origin_m + shift_m, asked.grid.spacing_m, asked.grid.values)
    with pytest.raises(InputError, match="another frame"):
        policy.choose(away, asked.view, asked.masks, asked.grasps)
