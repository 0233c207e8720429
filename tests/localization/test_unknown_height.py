"""A part that lies on something: found, and its height told where distances tell it."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated_scenes import Errors, biased_stops

from rfcompass.errors import Infeasible, InputError
from rfcompass.localization.posterior import PosteriorLocalizer
from rfcompass.localization.unknown_height import lifts_between
from rfcompass.types import TagPositions

QUIET = Errors(0.005, 0.002)
KNOWN, FREE = PosteriorLocalizer(), PosteriorLocalizer(lift_range_m=(0.0, 0.3))


def on_a_shelf(seed, lift_m=0.1, errors=QUIET, **scene):
    return biased_stops(np.random.default_rng(seed), errors=errors, height_m=0.05 + lift_m, stated_m=0.05, **scene)


def test_heights_to_try_include_both_ends():
    lifts_m = lifts_between(-0.05, 0.3, 0.02)
    assert lifts_m[[0, -1]] == pytest.approx([-0.05, 0.3])
    assert np.diff(lifts_m).max() <= 0.02 + 1e-12
    assert lifts_between(0.1, 0.1, 0.02).tolist() == [0.1]


@pytest.mark.parametrize("wrong", [(0.2, 0.1, 0.02), (0.0, 0.1, 0.0), (0.0, np.nan, 0.02), (0.0, 3.0, 0.02)])
def test_ranges_that_are_none_are_refused(wrong):
    with pytest.raises(InputError):
        lifts_between(*wrong)


def test_a_part_on_a_shelf_is_found_and_its_height_too():
    off_m, lifts_m = [], []
    for seed in range(8):
        stops, truth = on_a_shelf(seed)
        estimate = FREE.estimate(stops)
        off_m.append(np.hypot(*(estimate.centre_m - truth.translation_m)))
        lifts_m.append(estimate.diagnostics["lift_m"])
        assert estimate.height_m == pytest.approx(0.05 + lifts_m[-1])
        assert abs(lifts_m[-1] - 0.1) < 3.0 * estimate.diagnostics["lift_sd_m"] + 0.01  # half a step of the heights
    assert np.median(off_m) < 0.015
    assert np.median(np.abs(np.array(lifts_m) - 0.1)) < 0.03


def test_where_the_height_is_known_nothing_is_said_about_it():
    stops, _ = on_a_shelf(0, lift_m=0.0)
    diagnostics = KNOWN.estimate(stops).diagnostics
    assert diagnostics["lift_m"] == diagnostics["lift_sd_m"] == 0.0


def test_one_height_is_the_search_at_that_height():
    stops, _ = on_a_shelf(1)
    higher = [replace(stop, part_tag_heights_m=stop.part_tag_heights_m + 0.1) for stop in stops]
    one = PosteriorLocalizer(lift_range_m=(0.1, 0.1)).estimate(stops)
    other = KNOWN.estimate(higher)
    assert one.centre_m == pytest.approx(other.centre_m, abs=1e-9)
    assert one.height_m == pytest.approx(other.height_m)


def test_what_cannot_be_observed_stays_uncertain():
    """All anchors at the height of the part: far distances hardly change with a lift, which may be any of the range."""
    stops, _ = biased_stops(np.random.default_rng(2), M=1, K=1, errors=Errors(0.02, 0.005), height_m=0.2)
    flat = [
        replace(stop, anchors=TagPositions("base", stop.anchors.epcs, stop.anchors.points_m * [1, 1, 0] + [0, 0, 0.2]))
        for stop in stops
    ]
    diagnostics = PosteriorLocalizer(lift_range_m=(-0.05, 0.05)).estimate(flat).diagnostics
    uniform_sd_m = 0.1 / np.sqrt(12.0)
    assert diagnostics["lift_sd_m"] > 0.6 * uniform_sd_m


def test_not_knowing_the_height_never_makes_the_region_smaller():
    for seed in range(5):
        stops, _ = on_a_shelf(seed, lift_m=0.0)
        known, free = KNOWN.estimate(stops), PosteriorLocalizer(lift_range_m=(-0.04, 0.04)).estimate(stops)
        assert np.trace(free.covariance[:2, :2]) > 0.9 * np.trace(known.covariance[:2, :2])


class Images:
    """A meter that looks for tags in the plane of their stated height: a part seems farther away the higher it is."""

    kind = "sar_nearfield"

    def __init__(self, ready, kind="sar_nearfield"):
        self.ready, self.kind, self.asked_m = ready, kind, []

    def measure(self, scan, *, targets=(), anchors=None):
        height_m = scan.heights_m[targets[0]]
        self.asked_m.append(round(height_m, 6))
        return replace(self.ready, m=self.ready.m * (1.0 + 0.2 * (height_m - 0.05)), kind=self.kind)


def imaged(seed, kind="sar_nearfield"):
    (stop,), _ = biased_stops(np.random.default_rng(seed), M=1, errors=QUIET)
    return replace(stop, proximity=None), Images(stop.proximity, kind)


def test_images_are_made_at_every_height_and_none_is_likelier_for_it():
    stop, meter = imaged(3)
    free = PosteriorLocalizer(lift_range_m=(0.0, 0.2), meter=meter).infer([stop]).posterior
    assert meter.asked_m[1:] == [0.05, 0.1, 0.15, 0.2, 0.25]
    each = [
        PosteriorLocalizer(meter=meter).infer([replace(stop, part_tag_heights_m=np.full(4, h_m))]).posterior.mean_m
        for h_m in meter.asked_m[1:]
    ]
    assert np.ptp(each, axis=0).max() > 0.005
    assert free.mean_m == pytest.approx(np.mean(each, axis=0), abs=1e-4)
    assert (free.mean_lift_m, free.lift_sd_m) == pytest.approx((0.1, np.std([0, 0.05, 0.1, 0.15, 0.2])), abs=1e-3)


def test_images_at_one_height_are_the_search_there():
    stop, meter = imaged(4)
    one = PosteriorLocalizer(lift_range_m=(0.1, 0.1), meter=meter).estimate([stop])
    known = PosteriorLocalizer(meter=meter).estimate([replace(stop, part_tag_heights_m=stop.part_tag_heights_m + 0.1)])
    assert one.centre_m == pytest.approx(known.centre_m, abs=1e-9)
    assert one.height_m == pytest.approx(known.height_m)


def test_what_does_not_look_in_a_plane_or_is_ready_made_is_measured_once():
    stop, meter = imaged(5, kind="phase_l1")
    PosteriorLocalizer(lift_range_m=(0.0, 0.2), meter=meter).infer([stop])
    assert meter.asked_m == [0.05]
    _, images = imaged(5)
    PosteriorLocalizer(lift_range_m=(0.0, 0.2), meter=images).infer([replace(stop, proximity=images.ready)])
    assert images.asked_m == []


def test_a_part_that_is_nowhere_at_any_height_is_refused():
    stop, meter = imaged(6)
    x, y = PosteriorLocalizer(meter=meter).estimate([stop]).centre_m
    elsewhere = np.array([[x + 0.12, x + 2.0], [y - 1.0, y + 1.0]])  # the part lies just outside
    with pytest.raises(Infeasible, match=r"0\.0 to 0\.1 m higher"):
        PosteriorLocalizer(lift_range_m=(0.0, 0.1), meter=meter, bounds_m=elsewhere).infer([stop])
