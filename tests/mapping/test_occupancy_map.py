"""Target kernels and the convolution: mass, symmetry, brute force, and targets that cannot be."""

import itertools

import numpy as np
import pytest
from box_scenes import Block, square_scan, views_of
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import convolve

from rfcompass.errors import InputError, PartError, ShapeError, TargetTooLarge
from rfcompass.mapping import box_target, fuse_maps, gaussian_target, map_views, occupancy_map, rf_certainty_map
from rfcompass.mapping.occupancy import convolve_same
from rfcompass.types import LocatedItem, TagFix, VoxelGrid, Workspace

lengths = st.floats(0.01, 0.12)
sizes = st.tuples(lengths, lengths, lengths).map(np.array)
kernels = st.one_of(
    st.tuples(lengths, lengths).map(lambda d: gaussian_target(min(d), max(d), 0.01)),
    sizes.map(lambda size: box_target(size, 0.01, yaws=5)),
)


def grid(values, spacing_m=0.01):
    return VoxelGrid(np.zeros(3), spacing_m, values)


def some_values(seed, shape=(14, 11, 9), filled=0.3):
    rng = np.random.default_rng(seed)
    return rng.random(shape) * (rng.random(shape) < filled)


# --- convolution ---------------------------------------------------------------------------------


@given(st.integers(0, 10**6), st.sampled_from([(1, 1, 1), (3, 3, 3), (5, 1, 7), (21, 5, 3)]), st.floats(0, 1))
def test_the_fast_convolution_is_the_direct_one(seed, shape, filled):
    values, kernel = some_values(seed, filled=filled), np.random.default_rng(seed + 1).random(shape)
    direct = convolve(np.pad(values, [(n // 2, n // 2) for n in shape]), kernel, mode="valid", method="direct")
    assert convolve_same(values, kernel) == pytest.approx(direct, abs=2e-6 * max(direct.max(), 1.0))


@given(st.integers(0, 10**6), kernels)
def test_mass_is_conserved_away_from_the_borders(seed, target):
    pad = [(n // 2, n // 2) for n in target.values.shape]
    values = np.pad(some_values(seed, (6, 5, 4)), pad)
    assert target.values.sum() == pytest.approx(1.0)
    assert convolve_same(values, target.values).sum() == pytest.approx(values.sum(), rel=1e-5)


@given(st.integers(0, 10**6), kernels)
def test_a_value_is_a_share_of_the_target(seed, target):
    occupancy = convolve_same(np.round(some_values(seed, (20, 20, 20))), target.values)
    assert occupancy.min() >= 0.0
    assert occupancy.max() <= 1.0 + 1e-5


@given(st.integers(0, 10**6), st.integers(0, 5), st.integers(0, 5), st.integers(0, 5))
def test_a_map_that_moves_by_whole_voxels_moves_the_answer(seed, i, j, k):
    kernel = gaussian_target(0.03, 0.06, 0.01).values
    values = np.pad(some_values(seed, (6, 6, 6)), 9)
    moved = convolve_same(np.roll(values, (i, j, k), axis=(0, 1, 2)), kernel)
    assert np.allclose(moved, np.roll(convolve_same(values, kernel), (i, j, k), axis=(0, 1, 2)), rtol=0, atol=1e-5)


def test_nothing_uncertain_gives_nothing():
    assert not convolve_same(np.zeros((5, 5, 5)), np.ones((3, 3, 3))).any()


# --- kernels -------------------------------------------------------------------------------------


@given(lengths, lengths)
def test_the_gaussian_falls_and_ends_at_half_the_longest_edge(a, b):
    d_s, d_l, h = min(a, b), max(a, b), 0.005
    target = gaussian_target(d_s, d_l, h)
    n = target.values.shape[0] // 2
    q = h * np.arange(-n, n + 1)
    r = np.sqrt(q[:, None, None] ** 2 + q[:, None] ** 2 + q**2)
    inside = target.values > 0
    assert np.array_equal(inside, r <= d_l / 2 * (1 + 1e-9))
    middle = target.values[n, n, n]
    assert target.values[inside] / middle == pytest.approx(np.exp(-(r[inside] ** 2) / (2 * d_s**2)))


def test_the_readings_of_the_gaussian_differ_in_scale_or_sign():
    consistent, metres, centimetres, printed = (
        gaussian_target(0.04, 0.1, 0.01, reading=name)
        for name in ("consistent", "literal_m", "literal_cm", "printed_m")
    )
    assert metres.values / metres.values.sum() == pytest.approx(consistent.values)
    assert metres.values.max() == pytest.approx(1 / (0.04 * np.sqrt(2 * np.pi)))
    assert centimetres.values.max() == pytest.approx(1 / (4 * np.sqrt(2 * np.pi)))
    n = printed.values.shape[0] // 2
    assert printed.values[n, n, n] < printed.values.max()
    with pytest.raises(InputError, match="known"):
        gaussian_target(0.04, 0.1, 0.01, reading="miles")


def slow_box(size_m, h, yaws, n):
    """Mean over all six faces and yaws over the whole circle, from points spread in the box."""
    steps = (np.arange(24) + 0.5) / 24 - 0.5
    points = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3) * size_m
    total = np.zeros((2 * n + 1,) * 3)
    turns = [np.roll(np.eye(3), k, axis=0) for k in range(3)]
    flip = np.diag([1.0, -1.0, -1.0])
    orientations = [R for turn in turns for R in (turn, flip @ turn)]
    for R, yaw in itertools.product(orientations, 2 * np.pi * np.arange(2 * yaws) / (2 * yaws)):
        c, s = np.cos(yaw), np.sin(yaw)
        placed = points @ R.T @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        cells = np.floor(placed / h + 0.5).astype(int) + n
        np.add.at(total, tuple(cells.T), 1.0)
    return total / total.sum()


def test_three_faces_and_half_a_turn_are_all_six_faces_and_every_yaw():
    size_m, h = np.array([0.083, 0.051, 0.034]), 0.01
    fast = box_target(size_m, h, yaws=6).values
    n = max(fast.shape) // 2
    pad = [(n - count // 2, n - count // 2) for count in fast.shape]
    slow = slow_box(size_m, h, 6, n)
    assert np.abs(np.pad(fast, pad) - slow).sum() < 0.1  # both sample the borders of voxels
    second_moment = [
        (values.sum(axis=(0, 1)) * (np.arange(2 * n + 1) - n) ** 2).sum() for values in (slow, np.pad(fast, pad))
    ]
    assert second_moment[0] == pytest.approx(second_moment[1], rel=0.02)


@given(sizes)
def test_a_box_kernel_has_the_mirrors_of_a_box(size_m):
    values = box_target(size_m, 0.01, yaws=4).values
    for axis in range(3):
        assert np.allclose(values, np.flip(values, axis), rtol=0, atol=1e-12)
    assert np.allclose(values, values.transpose(1, 0, 2), rtol=0, atol=1e-12)  # four yaws over half a turn


def test_one_face_and_one_yaw_are_the_box_itself():
    values = box_target([0.03, 0.05, 0.07], 0.01, yaws=1, face_weights=(0, 0, 1)).values
    assert np.count_nonzero(values) == 3 * 5 * 7
    assert values.max() == pytest.approx(1 / 105)


# --- the whole way -------------------------------------------------------------------------------


def test_where_a_tagged_item_lies_and_at_the_rim_of_a_pile_the_target_is_less_likely():
    """What the paper says of its Fig. 3d."""
    table = Workspace.between([-0.3, -0.2, 0.0], [0.3, 0.2, 0.2], 0.01)
    pile = Block((0.0, 0.0, 0.06), (0.4, 0.2, 0.12))
    C = map_views(table, views_of([pile], square_scan(), shape=(240, 320))).uncertainty()
    tag = LocatedItem(TagFix("a", np.array([-0.1, 0.0, 0.06]), np.full(3, 0.05), True), "toy", 0.08, 0.12)
    target = gaussian_target(0.05, 0.08, 0.01)
    occupancy = occupancy_map(fuse_maps(C, rf_certainty_map([tag], table).grid), target)
    at_tag, far, rim = (
        occupancy.values[tuple(table.indices(np.array([p]))[0])]
        for p in ([-0.1, 0, 0.06], [0.1, 0, 0.06], [0.195, 0, 0.06])
    )
    assert at_tag < 0.3 * far
    assert rim < 0.8 * far
    untagged = occupancy_map(C, target)
    assert (occupancy.values <= untagged.values + 1e-5).all()


@given(st.integers(0, 10**6))
def test_the_sum_is_clipped_unless_told_otherwise(seed):
    C, R = grid(np.round(some_values(seed))), grid(-some_values(seed + 1))
    assert fuse_maps(C, R).values.min() >= 0
    assert np.array_equal(fuse_maps(C, R, clip=False).values, C.values + R.values)


def test_maps_over_other_voxels_are_refused():
    one = grid(np.zeros((4, 4, 4)))
    others = [
        grid(np.zeros((4, 4, 5))),
        grid(np.zeros((4, 4, 4)), 0.02),
        VoxelGrid(np.ones(3), 0.01, np.zeros((4, 4, 4))),
    ]
    for other in others:
        with pytest.raises(ShapeError, match="different voxels"):
            fuse_maps(one, other)
    with pytest.raises(ShapeError, match="kernel's voxels"):
        occupancy_map(one, gaussian_target(0.01, 0.02, 0.005))


def test_a_target_that_cannot_lie_in_the_workspace_is_refused():
    small = grid(np.zeros((10, 10, 10)))
    assert occupancy_map(small, gaussian_target(0.02, 0.15, 0.01)).values.shape == (10, 10, 10)
    with pytest.raises(TargetTooLarge) as refusal:
        occupancy_map(small, gaussian_target(0.02, 0.18, 0.01))
    assert refusal.value.numbers["diagonal_m"] == pytest.approx(0.1 * np.sqrt(3))


def test_targets_that_cannot_be_are_refused():
    with pytest.raises(PartError):
        gaussian_target(0.0, 0.1, 0.01)
    with pytest.raises(InputError, match="shorter"):
        gaussian_target(0.2, 0.1, 0.01)
    with pytest.raises(PartError):
        box_target([0.1, -0.1, 0.1], 0.01)
    for options in ({"yaws": 0}, {"face_weights": (0, 0, 0)}, {"face_weights": (1, -1, 1)}):
        with pytest.raises(InputError, match="nothing to average"):
            box_target([0.1, 0.1, 0.1], 0.01, **options)
