"""Kernels of tagged items: signs, units, symmetry, deformation, and which tags count."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import DuplicateEpc, InputError, NotLocated, PartError, ShapeError, UnknownPart
from rfcompass.mapping import (
    READINGS,
    RfKernels,
    deformable_kernel,
    known_items,
    rf_certainty_map,
    rigid_kernel,
    tagged_target_map,
)
from rfcompass.recordings import PartDatabase
from rfcompass.types import LocatedItem, TagFix, Workspace

TABLE = Workspace.between([-0.15, -0.15, 0.0], [0.15, 0.15, 0.15], 0.01)
HEIGHTS_M = np.full(TABLE.shape[:2], 0.12)

edges = st.tuples(st.floats(0.02, 0.1), st.floats(1.0, 2.5)).map(lambda d: (d[0], d[0] * d[1]))
places = st.tuples(st.floats(-0.15, 0.15), st.floats(-0.15, 0.15), st.floats(0.0, 0.14)).map(np.array)


def tagged(point_m=(0.0, 0.0, 0.05), *, epc="a", d_s=0.04, d_l=0.1, soft=False, confident=True):
    fix = TagFix(epc, np.array(point_m), np.full(3, 0.05), confident)
    return LocatedItem(fix, f"item {epc}", d_s, d_l, soft)


def values_of(*items, **options):
    return rf_certainty_map(items, TABLE, **options).grid.values


def slow_kernel(q, d_s, d_l, alpha, reading):
    """Value of R at q from one deformable item, written as the paper has it; q in m."""
    unit, printed = READINGS[reading]
    if unit is None:
        sigma = np.array([(2 - alpha) * d_s / 2, (2 - alpha) * d_s / 2, alpha * d_s / 2])
        return -np.exp(-0.5 * (q**2 / sigma**2).sum()) if np.linalg.norm(q) <= d_l else 0.0
    q, d_s, d_l = q / unit, d_s / unit, d_l / unit
    Sigma = np.diag([(2 - alpha) * d_s / 2, (2 - alpha) * d_s / 2, alpha * d_s / 2])
    form = 0.5 * q @ np.linalg.inv(Sigma) @ q
    if (q @ q if printed else np.linalg.norm(q)) > d_l:
        return 0.0
    size = np.exp(form if printed else -form) / np.sqrt(2 * np.pi * np.linalg.det(Sigma))
    return size if printed else -size


@given(edges, places, st.floats(0.2, 1.0), st.sampled_from(list(READINGS)))
def test_a_kernel_is_what_a_slow_loop_says(lengths, point_m, alpha, reading):
    top_m = np.full(TABLE.shape[:2], max(point_m[2], 1e-3) / alpha)
    kernels = RfKernels(reading=reading, least_alpha=0.01)
    item = tagged(point_m, d_s=lengths[0], d_l=lengths[1], soft=True)
    alpha = float(np.clip(point_m[2] / top_m[0, 0], 0.01, 1.0))
    found = rf_certainty_map([item], TABLE, heights_m=top_m, kernels=kernels)
    x, y, z = TABLE.axes_m()
    rng = np.random.default_rng(0)
    for i, j, k in rng.integers(0, TABLE.shape, (40, 3)):
        q = np.array([x[i], y[j], z[k]]) - point_m
        expected = slow_kernel(q, *lengths, alpha, reading)
        assert found.grid.values[i, j, k] == pytest.approx(expected, rel=1e-6, abs=1e-12)


@given(edges, st.sampled_from(["consistent", "literal_m", "literal_cm"]))
def test_an_item_that_nothing_presses_is_a_rigid_one(lengths, reading):
    rigid, soft = rigid_kernel(*lengths, reading=reading), deformable_kernel(*lengths, 1.0, reading=reading)
    assert soft.reach_m == rigid.reach_m
    unit = READINGS[reading].unit_m
    if unit is None:
        assert np.array_equal(soft.weights, rigid.weights)
        assert soft.peak == rigid.peak
    else:  # the printed normalisers differ by 2 / d_s
        assert soft.weights == pytest.approx(rigid.weights, rel=1e-12)
        assert soft.peak / rigid.peak == pytest.approx(2 * unit / lengths[0])


def test_the_readings_have_the_widths_and_peaks_that_the_page_states():
    stated = {"consistent": (0.02, 1.0), "literal_m": (0.1414, 2.82), "literal_cm": (0.01414, 0.282)}
    for reading, (sigma_m, peak) in stated.items():
        kernel = rigid_kernel(0.04, 0.1, reading=reading)
        assert kernel.sigmas_m == pytest.approx(np.full(3, sigma_m), rel=1e-3)
        assert kernel.peak == pytest.approx(-peak, rel=2e-3)


def test_printed_signs_raise_the_map_where_a_tagged_item_lies():
    as_printed = values_of(tagged(d_s=0.04, d_l=0.08), kernels=RfKernels(reading="printed_cm"))
    assert as_printed.max() > 0
    assert as_printed.min() == 0.0
    assert values_of(tagged()).max() == 0.0


@given(edges, st.sampled_from(["consistent", "literal_m", "literal_cm"]))
def test_a_rigid_item_may_lie_any_way_round_its_tag(lengths, reading):
    cube = Workspace([-0.155] * 3, (31, 31, 31), 0.01)
    item = tagged((0.0, 0.0, 0.0), d_s=lengths[0], d_l=lengths[1])
    R = rf_certainty_map([item], cube, kernels=RfKernels(reading=reading)).grid.values
    for axes in ((0, 1), (0, 2), (1, 2)):
        assert np.allclose(R, np.rot90(R, axes=axes), rtol=0, atol=1e-9)


@given(edges, st.floats(0.2, 1.0))
def test_a_sampled_kernel_has_its_peak_in_the_middle(lengths, alpha):
    kernel = deformable_kernel(*lengths, alpha, amplitude=0.7)
    grid = kernel.sampled(0.1, 0.01)
    assert grid.values.shape == (21, 21, 21)
    assert grid.values[10, 10, 10] == grid.values.min() == -0.7
    q_m = grid.origin_m + 0.01 * np.array([12, 9, 11])
    assert grid.values[12, 9, 11] == pytest.approx(0.7 * slow_kernel(q_m, *lengths, alpha, "consistent"))


@given(edges, st.floats(0.2, 0.99))
def test_a_pressed_item_is_flatter_and_wider(lengths, alpha):
    soft, rigid = deformable_kernel(*lengths, alpha), rigid_kernel(*lengths)
    assert soft.sigmas_m[2] < rigid.sigmas_m[2]
    assert (soft.sigmas_m[:2] > rigid.sigmas_m[:2]).all()


@given(st.lists(places, min_size=1, max_size=4))
def test_the_map_is_the_sum_over_its_tags(points_m):
    items = [tagged(point_m, epc=str(n)) for n, point_m in enumerate(points_m)]
    assert np.allclose(values_of(*items), sum(values_of(item) for item in items), rtol=0, atol=1e-12)


@given(places, st.integers(-3, 3), st.integers(-3, 3), st.integers(0, 3))
def test_a_tag_that_moves_by_whole_voxels_moves_its_kernel(point_m, i, j, k):
    wide = Workspace([-0.4, -0.4, 0.0], (80, 80, 40), 0.01)
    one = rf_certainty_map([tagged(point_m)], wide).grid.values
    other = rf_certainty_map([tagged(point_m + 0.01 * np.array([i, j, k]))], wide).grid.values
    rolled = np.roll(one, (i, j, k), axis=(0, 1, 2))[:, :, k:]
    # A voxel on the very border of the ball may fall to either side.
    assert np.isclose(rolled, other[:, :, k:], atol=1e-9).mean() > 0.9999


# --- deformation ---------------------------------------------------------------------------------


def test_alpha_is_the_height_of_the_tag_by_that_of_the_pile_above_it():
    kernels = RfKernels()
    assert kernels.alpha(tagged((0, 0, 0.06), soft=True), TABLE, HEIGHTS_M) == pytest.approx(0.5)
    assert kernels.alpha(tagged((0, 0, 0.06)), TABLE, None) == 1.0
    assert kernels.alpha(tagged((0, 0, 0.2), soft=True), TABLE, HEIGHTS_M) == 1.0
    assert kernels.alpha(tagged((0, 0, -0.01), soft=True), TABLE, HEIGHTS_M) == 0.2
    assert kernels.alpha(tagged((0, 0, 0.06), soft=True), TABLE, 0 * HEIGHTS_M) == 1.0


def test_heights_are_over_the_table_wherever_it_stands():
    raised = Workspace(np.add(TABLE.lower_m, (0, 0, 0.7)), TABLE.shape, 0.01)
    assert RfKernels().alpha(tagged((0, 0, 0.76), soft=True), raised, HEIGHTS_M) == pytest.approx(0.5)


def test_a_soft_item_without_heights_is_refused():
    with pytest.raises(InputError, match="needs the heights"):
        values_of(tagged(soft=True))
    with pytest.raises(ShapeError, match="columns"):
        values_of(tagged(soft=True), heights_m=np.zeros((3, 3)))


# --- which tags count ----------------------------------------------------------------------------


def test_tags_that_do_not_count_are_named_with_the_reason():
    items = [tagged(), tagged(epc="b", confident=False), tagged((1.0, 0, 0.05), epc="c")]
    found = rf_certainty_map(items, TABLE)
    assert dict(found.alphas) == {"a": 1.0}
    assert set(found.left_out) == {"b", "c"}
    assert "confident" in found.left_out["b"]
    assert "workspace" in found.left_out["c"]
    assert np.array_equal(found.grid.values, values_of(tagged()))


def test_a_tag_just_under_the_table_still_counts():
    assert "a" in rf_certainty_map([tagged((0, 0, -0.02))], TABLE).alphas


def test_a_tag_stands_once():
    with pytest.raises(DuplicateEpc):
        values_of(tagged(), tagged())


def test_a_tagged_target_is_sought_at_its_tag():
    grid = tagged_target_map(tagged((0.0, 0.0, 0.055)), TABLE)
    assert grid.values.min() == 0.0
    peak_m = grid.origin_m + 0.01 * np.array(np.unravel_index(grid.values.argmax(), grid.values.shape))
    assert np.abs(peak_m - [0.0, 0.0, 0.055]).max() <= 0.0051
    assert np.array_equal(grid.values, -values_of(tagged((0.0, 0.0, 0.055))))
    for lost in (tagged(confident=False), tagged((2.0, 0, 0))):
        with pytest.raises(NotLocated) as refusal:
            tagged_target_map(lost, TABLE)
        assert refusal.value.numbers["epc"] == "a"


def test_the_part_database_says_what_a_tag_hangs_on():
    leg = PartDatabase().part("table_leg_3")
    near, far = leg.tags.epcs[:2]
    sure, unsure = TagFix(far, np.zeros(3), np.full(3, 0.02), True), TagFix(near, np.ones(3), np.full(3, 0.3), True)
    (item,) = known_items([unsure, sure], [leg])
    assert item.fix is sure
    assert (item.item, item.shortest_m, item.longest_m) == ("table_leg_3", leg.shortest_m, leg.longest_m)
    assert not item.deformable
    with pytest.raises(UnknownPart, match="none of 0"):
        known_items([sure], [])


def test_numbers_out_of_range_are_refused():
    for kernel in (rigid_kernel, lambda *d, **o: deformable_kernel(*d, 0.5, **o)):
        with pytest.raises(InputError, match="known: consistent"):
            kernel(0.04, 0.1, reading="kilometres")
        with pytest.raises(InputError, match="amplitude"):
            kernel(0.04, 0.1, amplitude=0.0)
        with pytest.raises(PartError):
            kernel(-0.04, 0.1)
    with pytest.raises(InputError, match="alpha"):
        deformable_kernel(0.04, 0.1, 0.0)
    with pytest.raises(PartError, match="shorter"):
        tagged(d_s=0.2, d_l=0.1)
    with pytest.raises(PartError):
        dataclasses.replace(tagged(), shortest_m=float("nan"))
    with pytest.raises(PartError, match="neither"):
        tagged(soft="yes")
