"""What every extraction policy obeys: ours, the paper's, its baselines."""

import dataclasses
import pickle

import numpy as np
import pytest
from extraction_scenes import grasps_of, question

from planners.extraction import (
    FewestActionsPolicy,
    FuseBotPolicy,
    LargestMaskPolicy,
    MapMassPolicy,
    NaivePolicy,
    RandomPolicy,
    XRayPolicy,
)
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
    asked = question(quality=(0.9, 0.9, 0.9))
    forgetful = dataclasses.replace(policy, remembers=False)
    first, failed, taken = policy.choose(*asked.parts()), [], set()
    for _ in range(5):
        action = policy.choose(*asked.parts(), failed)
        taken.add(action.mask_label)
        assert same(forgetful.choose(*asked.parts(), failed), first)
        failed.append(action.T_world_hand[:3, 3])
    # The naive policy stays within 5 cm of its voxel.
    assert len(taken) >= (1 if isinstance(policy, NaivePolicy) else 2)


@every_policy
def test_images_of_different_sizes_are_refused(policy):
    asked = question()
    small = InstanceMasks(asked.masks.labels[::2])
    with pytest.raises(ShapeError):
        policy.choose(asked.grid, asked.view, small, asked.grasps)
    with pytest.raises(ShapeError):
        policy.choose(asked.grid, asked.view, asked.masks, GraspMaps(*np.zeros((4, 3, 3))))


@pytest.mark.parametrize(
    "policy", [FuseBotPolicy(), RandomPolicy(), LargestMaskPolicy(), MapMassPolicy(gate=True), OURS]
)
def test_the_gate_bars_what_can_hardly_be_grasped_as_long_as_something_can(policy):
    asked = question(mass=(5.0, 1.0, 1.0), quality=(0.4, 0.4, 0.6))
    assert policy.choose(*asked.parts()).mask_label == 3
    ungated = {dataclasses.replace(policy, gate=False).choose(*asked.parts()).mask_label}
    if not isinstance(policy, RandomPolicy):
        assert ungated == {1}
    hopeless = dataclasses.replace(asked, grasps=grasps_of(asked.masks.labels, (0.4, 0.3, 0.3)))
    if not isinstance(policy, RandomPolicy):
        assert policy.choose(*hopeless.parts()).mask_label == 1


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
