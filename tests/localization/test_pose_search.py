"""From maps of tags to poses: the search loses nothing that a dense grid finds."""

import numpy as np
import pytest

from rfcompass.geometry import Pose2
from rfcompass.localization.pose_search import (
    OUTSIDE,
    centred,
    map_value,
    pose_cells,
    pose_log_density,
    rigid_start,
    split_cells,
    stack_maps,
    widened,
)

LEG_M = np.array([[-0.15, 0.0], [0.05, 0.02], [0.15, -0.03]])
TRUTH = Pose2(0.31, -0.22, 0.8)
BOUNDS_M = np.array([[-0.5, 1.0], [-1.0, 0.5]])
LIMITS = np.array([9.0, 60.0, 2e-4, 0.04])
SD_M = 0.03


def bells(points_m=LEG_M, truth=TRUTH, sd_m=SD_M, rng=None):
    """Maps of tags, each a normal density about its place, which the rng puts off a little."""
    off_m = np.zeros((len(points_m), 2)) if rng is None else 0.02 * rng.normal(size=(len(points_m), 2))
    maps, firsts = [], []
    for place_m in truth.apply(points_m) + off_m:
        first_m = np.round(place_m - 0.2, 2)
        x, y = (f + 0.01 * np.arange(41) for f in first_m)
        off2 = (x[:, None] - place_m[0]) ** 2 + (y[None] - place_m[1]) ** 2
        maps.append(np.log(np.exp(-off2 / (2 * sd_m**2)) / (2 * np.pi * sd_m**2) + 1e-6))
        firsts.append(first_m)
    return stack_maps(maps, firsts, [0.01] * len(maps), points_m)


def test_a_map_is_exact_on_its_grid_and_linear_between():
    stack = bells()
    offset, X, Y = stack.shapes[1]
    values = stack.values[offset : offset + X * Y].reshape(X, Y)
    x, y = stack.first_m[1] + 0.01 * np.array([12, 30])
    assert map_value(stack, 1, x + 1e-9, y + 1e-9) == pytest.approx(values[12, 30], abs=1e-5)
    assert map_value(stack, 1, x + 0.005, y + 0.005) == pytest.approx(values[12:14, 30:32].mean(), abs=1e-9)
    assert map_value(stack, 1, 9.0, 9.0) == OUTSIDE


@pytest.mark.parametrize("reach", [0, 1, 3, 7])
def test_widening_is_a_moving_maximum(reach):
    rng = np.random.default_rng(reach)
    level = rng.uniform(-10.0, 0.0, (9, 6))
    out = widened(level, reach)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            rows = slice(max(0, i - 2 * reach - 1), i + 1)
            columns = slice(max(0, j - 2 * reach - 1), j + 1)
            near = level[rows, columns]
            edge = i < 2 * reach + 1 or j < 2 * reach + 1 or i >= 9 or j >= 6
            assert out[i, j] == max(near.max(initial=OUTSIDE), OUTSIDE if edge else -np.inf)


def test_the_density_of_a_pose_is_the_sum_of_what_its_tags_say():
    stack = bells()
    pose = Pose2(0.3, -0.2, 0.7)
    hub_m = pose.apply(stack.hub_m)
    expected = sum(map_value(stack, k, *pose.apply(LEG_M[k])) for k in range(3))
    assert pose_log_density(stack, *hub_m, pose.theta_rad) == pytest.approx(expected)
    assert centred(np.array([[*hub_m, 0.7]]), stack.hub_m)[0] == pytest.approx([0.3, -0.2, 0.7])


def test_the_rigid_start_is_the_pose_itself_when_nothing_is_off():
    start = rigid_start(bells())
    assert centred(start[None], bells().hub_m)[0] == pytest.approx([0.31, -0.22, 0.8], abs=0.02)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_cells_hold_the_probability_that_a_dense_grid_finds(seed):
    stack = bells(rng=np.random.default_rng(seed))
    cells, value, half = pose_cells(stack, BOUNDS_M, LIMITS, 16000)
    axes = [
        np.arange(c - r, c + r, step)
        for c, r, step in zip(rigid_start(stack), (0.1, 0.1, 0.8), (0.006, 0.006, 0.04), strict=True)
    ]
    dense = np.array([[[pose_log_density(stack, x, y, t) for t in axes[2]] for y in axes[1]] for x in axes[0]])
    weight = np.exp(dense - dense.max())
    own = np.exp(value - dense.max())
    volume = 8.0 * half[0] ** 2 * half[1]
    assert own.sum() * volume == pytest.approx(weight.sum() * 0.006**2 * 0.04, rel=0.05)
    for axis in range(3):
        others = tuple(a for a in range(3) if a != axis)
        marginal = weight.sum(axis=others) / weight.sum()
        mean = marginal @ axes[axis]
        sd = np.sqrt(marginal @ (axes[axis] - mean) ** 2)
        assert own @ cells[:, axis] / own.sum() == pytest.approx(mean, abs=0.1 * sd)


def test_poses_whose_tags_would_be_elsewhere_are_cut_off_and_those_out_of_bounds_too():
    stack = bells()
    cells, value, _ = pose_cells(stack, BOUNDS_M, LIMITS, 16000)
    assert np.abs(cells[:, :2] - rigid_start(stack)[:2]).max() < 0.2
    assert value.min() >= value.max() - 9.0
    left = np.array([[-0.5, 0.31], [-1.0, 0.5]])
    inside, _, _ = pose_cells(stack, left, LIMITS, 16000)
    assert (centred(inside, stack.hub_m)[:, 0] <= 0.31).all()


def test_one_tag_leaves_all_orientations_alike():
    stack = bells(points_m=np.zeros((1, 2)))
    cells, _, half = pose_cells(stack, BOUNDS_M, LIMITS, 16000)
    assert half[1] == pytest.approx(np.pi)
    assert np.unique(cells[:, 2]).size == 1


def test_two_symmetric_tags_with_one_far_off_still_have_two_modes():
    """A leg whose two tags both may be at either end: maps with two bells each."""
    one, other = bells(LEG_M[[0, 2]]), bells(LEG_M[[2, 0]])
    maps = []
    for k in range(2):
        parts = [s.values[s.shapes[k, 0] : s.shapes[k, 0] + s.shapes[k, 1] * s.shapes[k, 2]] for s in (one, other)]
        whole = np.full((90, 90), OUTSIDE)
        for part, stack in zip(parts, (one, other), strict=True):
            i, j = np.round((stack.first_m[k] - [0.0, -0.6]) / 0.01).astype(int)
            X, Y = stack.shapes[k, 1:]
            whole[i : i + X, j : j + Y] = np.maximum(whole[i : i + X, j : j + Y], part.reshape(X, Y))
        maps.append(whole)
    stack = stack_maps(maps, [np.array([0.0, -0.6])] * 2, [0.01] * 2, LEG_M[[0, 2]])
    cells, value, _ = pose_cells(stack, BOUNDS_M, LIMITS, 16000)
    weight = np.exp(value - value.max())
    forth = np.cos(cells[:, 2] - 0.8) > 0
    assert weight[forth].sum() / weight.sum() == pytest.approx(0.5, abs=0.1)


def test_nothing_in_common_with_the_bounds_gives_no_cells():
    cells, value, _ = pose_cells(bells(), np.array([[5.0, 6.0], [5.0, 6.0]]), LIMITS, 16000)
    assert len(cells) == len(value) == 0


@pytest.mark.parametrize("turn", [False, True])
def test_split_cells_tile_the_cell(turn):
    half = np.array([0.1, 0.2])
    parts = split_cells(np.array([[1.0, 2.0, 0.5]]), half, turn)
    assert len(parts) == (2 if turn else 4)
    assert parts.mean(axis=0) == pytest.approx([1.0, 2.0, 0.5])
    spread = [0.0, 0.0, 0.1] if turn else [0.05, 0.05, 0.0]
    assert np.abs(parts - [1.0, 2.0, 0.5]) == pytest.approx(np.tile(spread, (len(parts), 1)))
