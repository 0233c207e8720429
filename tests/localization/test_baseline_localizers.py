"""`sar` and `nearest_tag`: what they can do, and what they refuse."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated_scenes import NEAR, Errors, biased_stops

from rfcompass.errors import DegenerateAnchors, InputError, TagNeverHeard
from rfcompass.geometry import polygon_contains
from rfcompass.localization.nearest_tag import NearestTagLocalizer
from rfcompass.localization.sar_localizer import SarLocalizer
from rfcompass.types import TagPositions

BASELINES = [pytest.param(SarLocalizer(), id="sar"), pytest.param(NearestTagLocalizer(), id="nearest_tag")]
every_baseline = pytest.mark.parametrize("localizer", BASELINES)


def scene(seed, **how):
    return biased_stops(np.random.default_rng(seed), **how)


def mute(stop, tags):
    m = stop.proximity.m.copy()
    m[tags] = np.nan
    return replace(stop, proximity=replace(stop.proximity, m=m))


def median_error_m(localizer, **how):
    errors = []
    for seed in range(20):
        stops, truth = scene(seed, **how)
        errors.append(np.hypot(*(localizer.estimate(stops).centre_m - truth.translation_m)))
    return np.median(errors)


def test_the_rigid_fit_errs_by_the_bias_over_the_root_of_the_tags():
    quiet = median_error_m(SarLocalizer(), errors=Errors(0.0, 0.001))
    assert quiet < 0.004
    near = median_error_m(SarLocalizer(), K=4, errors=NEAR)
    assert near < 0.02  # anchors are biased too: σ √(1/4 + about 1/4) times 1.18, the median of Rayleigh's law


@pytest.mark.parametrize("neighbours", [1, 3])
def test_the_nearest_tags_are_a_coarse_answer(neighbours):
    """The part lies within 25 cm of the hand, whose tags are some 10 cm apart."""
    error_m = median_error_m(NearestTagLocalizer(neighbours=neighbours))
    assert 2.0 * median_error_m(SarLocalizer()) < error_m < 0.25


def test_nearest_tags_never_lead_beyond_the_robots_tags():
    for seed in range(5):
        stops, _ = scene(seed, K=1, M=1)
        low, high = stops[0].anchors.points_m[:, :2].min(axis=0), stops[0].anchors.points_m[:, :2].max(axis=0)
        centre_m = NearestTagLocalizer().estimate(stops).centre_m
        assert ((low <= centre_m) & (centre_m <= high)).all()


@every_baseline
def test_the_region_claims_no_probability_and_holds_the_answer(localizer):
    estimate = localizer.estimate(scene(0)[0])
    assert estimate.probability is None
    assert polygon_contains(estimate.region_m, estimate.centre_m[None]).all()
    assert estimate.method in ("sar", "nearest_tag")


@every_baseline
def test_one_tag_has_no_orientation(localizer):
    assert localizer.estimate(scene(1, K=1)[0]).theta_rad is None


@every_baseline
def test_silence_is_refused(localizer):
    stops, _ = scene(2)
    with pytest.raises(TagNeverHeard):
        localizer.estimate([mute(stop, [0, 1, 2, 3]) for stop in stops])
    with pytest.raises(InputError):
        localizer.estimate([])


@every_baseline
def test_one_anchor_is_refused(localizer):
    (stop,), _ = scene(3, M=1)
    with pytest.raises(DegenerateAnchors):
        localizer.estimate([replace(stop, anchors=TagPositions("base", ("r0",), stop.anchors.points_m[:1]))])


def test_a_rigid_fit_with_one_of_two_tags_is_refused_and_says_which_is_missing():
    stops, _ = scene(4, K=2)
    with pytest.raises(TagNeverHeard) as failure:
        SarLocalizer().estimate([mute(stop, [1]) for stop in stops])
    assert failure.value.numbers["epc"] == ["p1"]


def test_tags_heard_at_different_stops_make_one_part():
    stops, truth = scene(5, K=2, M=2)
    apart = [mute(stops[0], [0]), mute(stops[1], [1])]
    estimate = SarLocalizer().estimate(apart)
    assert np.hypot(*(estimate.centre_m - truth.translation_m)) < 0.05
    assert estimate.theta_rad is not None


def test_no_neighbour_is_no_setting():
    with pytest.raises(InputError):
        NearestTagLocalizer(neighbours=0).estimate(scene(6)[0])
