"""Expected errors follow from the printed information, fall with every tag, and move with the scene."""

import numpy as np
import pytest
from compared_scenes import leg_points
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.errors import InputError, NoRoomForTags, ShapeError
from rfcompass.geometry import Pose2
from rfcompass.localization import LayoutError, design_layout
from rfcompass.localization.layout_error import KNOWN_TO_M, KNOWN_TO_RAD
from rfcompass.localization.lying_tags import lying_tags
from rfcompass.types import TagLayout

seeds = st.integers(0, 2**31)


def scene(seed, C=8, S=2, Z=5, K=2):
    rng = np.random.default_rng(seed)
    anchors_m = np.dstack([rng.uniform(0.0, 0.8, (S, C, 2)), rng.uniform(0.05, 0.2, (S, C, 1))])
    poses = np.column_stack([rng.uniform(0.2, 0.7, (Z, 2)), rng.uniform(-np.pi, np.pi, Z)])
    return LayoutError(anchors_m=anchors_m, part_points_m=leg_points(K), poses=poses)


def printed_error(error, pose, chosen):
    """The docstring with slopes by differences."""

    def tags_m(z):
        return Pose2(*z).apply(error.part_points_m)

    def d(z, s, k, i):
        return np.linalg.norm(tags_m(z)[k] - error.anchors_m[s, i])

    steps = 1e-6 * np.eye(3)
    J = np.diag(np.array([KNOWN_TO_M, KNOWN_TO_M, KNOWN_TO_RAD]) ** -2)
    K, scale_m = len(error.part_points_m), error.scale_m
    for s in range(len(error.anchors_m)):
        for k in range(K):
            for a in range(len(chosen)):
                for b in range(a):
                    i, j = chosen[a], chosen[b]
                    gap = [d(pose + h, s, k, j) - d(pose + h, s, k, i) for h in (*steps, *-steps)]
                    slope = (np.array(gap[:3]) - gap[3:]) / 2e-6
                    p = 1 / (1 + np.exp(-(d(pose, s, k, j) - d(pose, s, k, i)) / scale_m))
                    J += p * (1 - p) / scale_m**2 * np.outer(slope, slope)
    E = np.array([(tags_m(pose + h) - tags_m(pose - h))[:, :2] / 2e-6 for h in steps]).transpose(1, 2, 0)
    return np.sqrt(np.mean([np.trace(E[k] @ np.linalg.inv(J) @ E[k].T) for k in range(K)]))


@settings(max_examples=10)
@given(seed=seeds)
def test_the_error_is_the_printed_one(seed):
    error, chosen = scene(seed), np.array([0, 3, 5])
    expected = [printed_error(error, pose, chosen) for pose in error.poses]
    np.testing.assert_allclose(error.errors_m(chosen), expected, rtol=1e-4)


@settings(max_examples=20)
@given(seed=seeds)
def test_a_further_tag_never_makes_it_worse(seed):
    error = scene(seed)
    fewer, more = error.errors_m(np.array([0, 1, 2])), error.errors_m(np.array([0, 1, 2, 3]))
    assert (more <= fewer * (1 + 1e-9)).all()


@settings(max_examples=20)
@given(seed=seeds)
def test_the_order_of_the_tags_and_the_frame_do_not_matter(seed):
    error, T = scene(seed), Pose2(0.4, -0.2, 0.9)
    anchors_m = np.array([T.apply(stop_m) for stop_m in error.anchors_m])
    poses = np.column_stack([T.apply(error.poses[:, :2]), error.poses[:, 2] + T.theta_rad])
    moved = LayoutError(anchors_m=anchors_m, part_points_m=error.part_points_m, poses=poses)
    np.testing.assert_allclose(moved.errors_m(np.array([4, 2, 0])), error.errors_m(np.array([0, 2, 4])), rtol=1e-9)


def test_two_tags_in_one_place_say_nothing_that_was_not_known():
    error = scene(1)
    error.anchors_m[:, 1] = error.anchors_m[:, 0]
    lever_m = np.sqrt((leg_points(2)[:, :2] ** 2).sum(axis=1).mean())
    known_m = np.sqrt(2 * KNOWN_TO_M**2 + (lever_m * KNOWN_TO_RAD) ** 2)
    np.testing.assert_allclose(error.errors_m(np.array([0, 1])), known_m, rtol=1e-9)


@settings(max_examples=5)
@given(seed=seeds)
def test_no_exchange_of_one_tag_improves_a_designed_layout(seed):
    error = scene(seed, C=12)
    found = design_layout(error, 4, spacing_m=0.0)
    assert found.error_m == pytest.approx(error.errors_m(np.array(found.chosen)).mean())
    for place in range(4):
        for other in set(range(12)) - set(found.chosen):
            tried = [*found.chosen[:place], other, *found.chosen[place + 1 :]]
            assert error.errors_m(np.array(tried)).mean() >= found.error_m - 1e-8


def test_given_tags_stay_and_all_keep_their_distance():
    error = scene(3, C=40)
    found = design_layout(error, 5, spacing_m=0.15, kept=[7])
    assert 7 in found.chosen
    for stop_m in error.anchors_m:
        chosen_m = stop_m[list(found.chosen)]
        apart_m = np.linalg.norm(chosen_m[:, None] - chosen_m[None], axis=2) + 9.0 * np.eye(5)
        assert apart_m.min() >= 0.15 - 1e-9


def test_no_room_and_nothing_to_compare_are_refused():
    error = scene(4)
    with pytest.raises(NoRoomForTags):
        design_layout(error, 5, spacing_m=2.0)
    with pytest.raises(InputError):
        design_layout(error, 1, spacing_m=0.0)
    with pytest.raises(InputError):
        error.errors_m(np.array([0]))
    with pytest.raises(ShapeError):
        LayoutError(anchors_m=np.zeros((3, 3)), part_points_m=leg_points(2), poses=np.zeros((1, 3)))


def test_tags_that_lie_are_named_and_those_that_lean_are_not():
    axes = np.array([[0, 0, -1.0], [1.0, 0, 0], [0.6, 0, 0.8]])
    layout = TagLayout("leg", ("a0", "a1", "a2"), ("part",) * 3, np.zeros((3, 3)), axes, ("part",) * 3)
    assert lying_tags(layout) == ("a1",)
