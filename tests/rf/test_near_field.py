"""The image is the product of the legs' printed sums, in single precision on grids and in double at the top."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.rf.image_slopes import climb_to_top
from rfcompass.rf.near_field import image_legs, near_field_image
from rfcompass.rf.waves import wavenumber
from rfcompass.types.volumes import SearchVolume

VOLUME = SearchVolume([0.3, 0.2, -0.2], [1.4, 1.3, 0.2])
TAG_M = np.array([0.8, 0.6, 0.05])
OPTIONS = [{"coherent": c, "amplitude": a, "sub_apertures": s} for c in (0, 1) for a in (0, 1) for s in (1, 2)]


def corner_m(step_m=0.04, length_m=1.0):
    """An L along x and then along y, without the corner itself, which could belong to either [m], shape (M, 3)."""
    s = np.arange(step_m, length_m + step_m / 2, step_m)
    along = np.column_stack([s, np.zeros(s.size), np.zeros(s.size)])
    return np.concatenate([along[::-1], along[:, [1, 0, 2]]])


def printed_product(trace, points_m, options):
    """Share of each leg by [Boroushaki2023], Eq. 1, squared; one look for each channel and transmitter."""
    image = np.ones(len(points_m))
    tx_m = trace.tx_positions_m
    turns = tx_m is not None and len(np.unique(tx_m, axis=0)) == 2
    senders = tx_m[:, 0] if turns else np.zeros(len(trace.channel))
    half = len(trace.channel) // 2
    for leg in (np.arange(half), np.arange(half, len(trace.channel))):
        for rows in np.array_split(leg, options["sub_apertures"]):
            looks = [rows[senders[rows] == sender] for sender in np.unique(senders)]
            image *= np.array([leg_share(trace, looks, d, options) for d in trace.round_trip_m(points_m)])
    return image


def leg_share(trace, looks, d, options):
    total = best = 0.0
    for rows in looks:
        h = trace.channel[rows]
        h = h if options["amplitude"] else h / np.where(h != 0, np.abs(h), 1.0)
        sums = (h * np.exp(1j * np.outer(d[rows], wavenumber(trace.frequencies_hz)))).sum(axis=0)
        most = np.abs(h).sum(axis=0)
        total += abs(sums.sum()) ** 2 if options["coherent"] else (np.abs(sums) ** 2).sum()
        best += most.sum() ** 2 if options["coherent"] else (most**2).sum()
    return total / best


def traces(make_trace):
    """Monostatic with gaps; two transmitters that take turns; a pair that moves."""
    path_m = corner_m()
    heard = np.random.default_rng(0).random((len(path_m), 3)) < 0.8
    two_m = np.where(np.arange(len(path_m))[:, None] % 2, [2.0, 1.5, 0.4], [-1.0, 2.0, 0.3])
    return [
        make_trace(TAG_M, path_m, heard=heard),
        make_trace(TAG_M, path_m, tx_m=two_m),
        make_trace(TAG_M, path_m, tx_m=path_m + np.array([0.0, 0.1, 0.2])),
    ]


@pytest.mark.parametrize("options", OPTIONS, ids=str)
@pytest.mark.parametrize("which", [0, 1, 2])
def test_the_image_is_the_product_of_the_printed_sums(make_trace, options, which):
    trace = traces(make_trace)[which]
    points_m = np.random.default_rng(1).uniform(VOLUME.lower_m, VOLUME.upper_m, (100, 3))
    image = near_field_image(trace, VOLUME, **options)
    expected = printed_product(trace, points_m, options)
    exact = np.array([np.exp(image.log_slopes(point_m).value) for point_m in points_m])
    np.testing.assert_allclose(exact, expected, rtol=1e-6, atol=1e-12)
    # Linear interpolation errs by 3e-4 of an amplitude in each of up to four factors of power, each at most 1.
    assert np.abs(image.power(points_m) - expected).max() < 8 * 3e-4


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000), which=st.integers(0, 2), coherent=st.booleans())
def test_gradient_and_hessian_are_those_of_the_value(make_trace, seed, which, coherent):
    image = near_field_image(traces(make_trace)[which], VOLUME, coherent=coherent)
    rng, step_m = np.random.default_rng(seed), 1e-6
    point_m = TAG_M + rng.uniform(-0.03, 0.03, 3)  # on the crest: in a null the logarithm has no parabola
    ends = [(image.log_slopes(point_m + step_m * e), image.log_slopes(point_m - step_m * e)) for e in np.eye(3)]
    here = image.log_slopes(point_m)
    gradient = np.array([(up.value - down.value) / (2 * step_m) for up, down in ends])
    hessian = np.array([(up.gradient - down.gradient) / (2 * step_m) for up, down in ends])
    scale = 2 * np.pi / image.fringe_m
    np.testing.assert_allclose(here.gradient, gradient, atol=1e-5 * scale)
    np.testing.assert_allclose(here.hessian, hessian, atol=1e-5 * scale**2)


def test_each_port_and_each_leg_is_a_factor(make_trace):
    path_m = corner_m()
    ports = np.tile([1, 2], len(path_m))[: len(path_m)]
    trace = make_trace(TAG_M, path_m, ports=ports)
    assert len(image_legs(trace, split_legs=True, sub_apertures=1)) == 4
    assert len(image_legs(trace, split_legs=False, sub_apertures=1)) == 2
    parts = image_legs(trace, split_legs=True, sub_apertures=3)
    assert len(parts) == 12
    assert sorted(np.concatenate(parts)) == list(range(len(path_m)))


def two_feeds(make_trace, tag_m, *, rotation_rad, deaf_to=None):
    """An L whose every place is heard through two feeds; the second adds a constant, or hears noise only."""
    path_m = np.repeat(corner_m(), 2, axis=0)
    trace = make_trace(tag_m, path_m, ports=np.tile([1, 2], len(path_m) // 2))
    channel = trace.channel.copy()
    channel[1::2] *= np.exp(1j * rotation_rad)
    if deaf_to is not None:
        noise = np.random.default_rng(0).normal(size=(2, *channel[1::2].shape))
        channel[1::2] = deaf_to * np.abs(channel[::2]).mean() * (noise[0] + 1j * noise[1])
    return replace(trace, channel=channel)


@given(rotation_rad=st.floats(-np.pi, np.pi))
@settings(max_examples=10)
def test_two_feeds_at_one_place_are_looks_of_one_factor(make_trace, rotation_rad):
    both = two_feeds(make_trace, TAG_M, rotation_rad=rotation_rad)
    assert len(image_legs(both, split_legs=True, sub_apertures=1)) == 2
    one = near_field_image(make_trace(TAG_M, corner_m()), VOLUME)
    point_m = TAG_M + np.array([0.03, -0.02, 0.01])
    twice = near_field_image(both, VOLUME).log_slopes(point_m).value
    assert twice == pytest.approx(one.log_slopes(point_m).value, abs=1e-9)


def test_a_feed_that_hardly_hears_the_tag_hardly_counts(make_trace):
    """Noise at a tenth of the size is a hundredth of the power: the top stays within a hundredth of a fringe."""
    both = two_feeds(make_trace, TAG_M, rotation_rad=0.0, deaf_to=0.1)
    image = near_field_image(both, VOLUME)
    top_m = climb_to_top(image.log_slopes, VOLUME, TAG_M, image.fringe_m)
    assert np.linalg.norm((top_m - TAG_M)[:2]) < 0.01 * image.fringe_m


def test_a_curve_is_one_leg(make_trace):
    angle = np.linspace(0.0, np.pi, 60)[:, None]
    trace = make_trace(TAG_M, np.hstack([np.cos(angle), np.sin(angle), 0 * angle]))
    assert len(image_legs(trace, split_legs=True, sub_apertures=1)) == 1


def test_all_cells_agree_at_the_tag(make_trace):
    for trace in traces(make_trace):
        assert near_field_image(trace, VOLUME).log_slopes(TAG_M).value == pytest.approx(0.0, abs=1e-9)


def test_a_leg_that_heard_nothing_has_no_say(make_trace):
    path_m = corner_m()
    heard = np.repeat(np.arange(len(path_m)) < 25, 3).reshape(-1, 3)
    image = near_field_image(make_trace(TAG_M, path_m, heard=heard), VOLUME)
    assert len(image.legs) == 1
    assert image.log_slopes(TAG_M).value == pytest.approx(0.0, abs=1e-9)
