"""Where the part is and how sure that is; what nobody can know is said, never guessed."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated_scenes import Errors, biased_stops
from compared_scenes import leg_points, random_stops

from rfcompass.errors import DegenerateAnchors, Infeasible, InputError, TagNeverHeard
from rfcompass.geometry import Pose2, polygon_area_m2, polygon_contains
from rfcompass.localization.noise_model import fit_noise
from rfcompass.localization.placed_stop import place_stops
from rfcompass.localization.posterior import PosteriorLocalizer
from rfcompass.types import ProximityMatrix, TagPositions

LOCALIZER = PosteriorLocalizer()
COMPARE = PosteriorLocalizer(use="comparisons")


def scene(seed, **how):
    return biased_stops(np.random.default_rng(seed), **how)


def radius_m(region_m):
    return np.sqrt(polygon_area_m2(region_m) / np.pi)


def holds(region_m, pose):
    return bool(polygon_contains(region_m, pose.translation_m[None])[0])


def test_it_agrees_with_a_posterior_summed_up_slowly_on_a_dense_grid():
    """One part tag, one stop: Student-4 likelihood at each place, then the bias as a sum over a grid of biases."""
    (stop,), truth = scene(0, K=1, M=1)
    noise = fit_noise(place_stops([stop]))
    estimate = LOCALIZER.estimate([stop])
    step = 0.005
    x, y = (c + np.arange(-0.25, 0.25, step) for c in truth.translation_m)
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    log_likelihood = np.zeros(places.shape[:2])
    for anchor_m, m in zip(stop.anchors.points_m, stop.proximity.m[0], strict=True):
        d = np.sqrt(((places - anchor_m[:2]) ** 2).sum(axis=-1) + (0.05 - anchor_m[2]) ** 2)
        s2 = noise.alpha_m**2 + noise.beta**2 * d**2
        log_likelihood -= 2.5 * np.log1p((m / noise.scale - d) ** 2 / s2 / 4.0) + 0.5 * np.log(s2)
    likelihood = np.exp(log_likelihood - log_likelihood.max())
    density = np.zeros_like(likelihood)
    off = np.arange(-30, 31)
    for share, sd in ((0.98, noise.bias_m), (0.02, 3.0 * noise.bias_m)):
        taps = np.exp(-0.5 * (off * step / sd) ** 2)
        blurred = np.apply_along_axis(np.convolve, 0, likelihood, taps / taps.sum(), mode="same")
        density += share * np.apply_along_axis(np.convolve, 1, blurred, taps / taps.sum(), mode="same")
    density /= density.sum()
    mean = (density[..., None] * places).sum(axis=(0, 1))
    variance = (density[..., None] * (places - mean) ** 2).sum(axis=(0, 1))
    sd = np.sqrt(variance)
    assert np.abs(estimate.centre_m - mean).max() < 0.05 * sd.max()
    assert np.sqrt(np.diag(estimate.covariance)[:2]) == pytest.approx(sd, rel=0.05)


def test_the_units_of_the_meter_do_not_matter():
    one, other = LOCALIZER.estimate(scene(1)[0]), LOCALIZER.estimate(scene(1, scale=37.0)[0])
    assert one.centre_m == pytest.approx(other.centre_m, abs=1e-6)
    assert other.diagnostics["scale"] == pytest.approx(37.0 * one.diagnostics["scale"])


def test_a_scan_repeated_from_one_place_teaches_nothing_new():
    (stop,), _ = scene(2, M=1)
    once, often = LOCALIZER.estimate([stop]), LOCALIZER.estimate([replace(stop, stop_id=n) for n in range(5)])
    assert often.centre_m == pytest.approx(once.centre_m, abs=1e-9)
    assert often.covariance == pytest.approx(once.covariance, rel=1e-6)


def test_more_places_of_the_hand_teach_but_never_below_the_bias():
    areas = {M: [] for M in (1, 3, 5)}
    for seed in range(10):
        stops, _ = scene(seed, M=5)
        for M, found in areas.items():
            found.append(radius_m(LOCALIZER.estimate(stops[:M]).region_m))
    medians = [np.median(areas[M]) for M in (1, 3, 5)]
    assert medians[0] > medians[2]
    assert medians[2] > 0.6 * medians[0]


def test_an_estimate_carries_what_was_asked_for():
    stops, _ = scene(3)
    estimate = PosteriorLocalizer(probability=0.5, sample_count=70).estimate(stops)
    assert estimate.probability == 0.5
    assert estimate.samples.shape == (70, 3)
    assert radius_m(estimate.region_m) < radius_m(LOCALIZER.estimate(stops).region_m)
    assert np.mean(polygon_contains(estimate.region_m, estimate.samples[:, :2])) == pytest.approx(0.5, abs=0.15)
    assert estimate.diagnostics["evidence"] == estimate.diagnostics["why"] == "distances"
    assert estimate.diagnostics["modes"] >= 1
    assert estimate.diagnostics["rigid_fit_sd"] < 3.0


def test_numbers_that_order_the_robots_own_tags_badly_are_not_taken_for_distances():
    stops, _ = scene(4, M=2)
    rng = np.random.default_rng(4)

    def shuffled(stop):
        upper = np.triu(rng.uniform(0.1, 1.0, (9, 9)), 1)
        own = upper + upper.T
        np.fill_diagonal(own, np.nan)
        return replace(stop, proximity=replace(stop.proximity, anchor_m=own))

    diagnostics = LOCALIZER.estimate([shuffled(stop) for stop in stops]).diagnostics
    assert diagnostics["evidence"] == "comparisons"
    assert "rank correlation" in diagnostics["why"]


def test_without_pairs_of_anchors_comparisons_are_used():
    stops, truth = scene(5)
    mute = [replace(s, proximity=replace(s.proximity, anchor_m=np.full((9, 9), np.nan))) for s in stops]
    estimate = LOCALIZER.estimate(mute)
    assert estimate.diagnostics["evidence"] == "comparisons"
    assert np.hypot(*(estimate.centre_m - truth.translation_m)) < 0.1


def test_comparisons_that_nobody_measured_lead_to_the_part():
    stops, truth = random_stops(np.random.default_rng(6))
    fit = LOCALIZER.fit(stops)
    assert np.hypot(*(fit.z[:2] - truth.translation_m)) < 0.05
    assert holds(fit.region_m, truth)


def test_one_tag_tells_no_orientation():
    estimate = LOCALIZER.estimate(scene(7, K=1)[0])
    assert estimate.theta_rad is None
    assert np.isnan(estimate.covariance[2]).all()


def mute(stop, tags):
    m = stop.proximity.m.copy()
    m[tags] = np.nan
    return replace(stop, proximity=replace(stop.proximity, m=m))


def test_a_leg_with_one_of_two_tags_unheard_may_point_anywhere():
    for seed in range(5):
        stops, truth = scene(seed, K=2)
        estimate = LOCALIZER.estimate([mute(stop, [1]) for stop in stops])
        assert estimate.theta_rad is None
        assert holds(estimate.region_m, truth)
        assert radius_m(estimate.region_m) > 0.2  # the tag sits 0.2 m from the centre


def test_three_of_four_tags_are_enough():
    errors_m = []
    for seed in range(10):
        stops, truth = scene(seed)
        estimate = LOCALIZER.estimate([mute(stop, [1]) for stop in stops])
        errors_m.append(np.hypot(*(estimate.centre_m - truth.translation_m)))
    assert np.median(errors_m) < 0.025


@pytest.mark.parametrize("off_m", [0.5, 4.0])
@pytest.mark.parametrize("tag", [0, 1, 3])
def test_a_tag_that_seems_to_be_somewhere_else_does_not_hide_where_the_others_are(tag, off_m):
    """Its image had its peak at an echo: all its distances agree, on a wrong place."""
    for seed in range(4):
        stops, truth = scene(seed)
        wrong_m = Pose2(truth.x_m, truth.y_m + off_m, truth.theta_rad).apply(leg_points())[tag]
        fooled = []
        for stop in stops:
            m = stop.proximity.m.copy()
            m[tag] = np.linalg.norm(wrong_m - stop.anchors.points_m, axis=1)
            fooled.append(replace(stop, proximity=replace(stop.proximity, m=m)))
        estimate = LOCALIZER.estimate(fooled)
        assert np.hypot(*(estimate.centre_m - truth.translation_m)) < 0.07
        assert turn_between(estimate.theta_rad, truth.theta_rad) < np.radians(20)


def turn_between(a_rad, b_rad):
    return abs((a_rad - b_rad + np.pi) % (2 * np.pi) - np.pi)


def test_a_part_of_which_nothing_was_heard_is_refused():
    stops, _ = scene(8)
    with pytest.raises(TagNeverHeard):
        LOCALIZER.estimate([mute(stop, [0, 1, 2, 3]) for stop in stops])


def along_a_line(seed, N=9):
    """Exact distances but for 3 % from anchors in a row, and the truth, which lies beside it."""
    rng = np.random.default_rng(seed)
    truth = Pose2(rng.uniform(-0.3, 0.3), rng.uniform(0.15, 0.4), rng.uniform(-np.pi, np.pi))
    (stop,), _ = scene(seed, M=1)
    anchors_m = np.column_stack([np.linspace(-0.4, 0.4, N), np.zeros(N), np.full(N, 0.1)])
    tags_m = truth.apply(leg_points())

    def measured(a, b):
        return np.linalg.norm(a[:, None] - b[None], axis=2) * np.exp(0.03 * rng.normal(size=(len(a), len(b))))

    own = np.triu(measured(anchors_m, anchors_m), 1)
    own = own + own.T
    np.fill_diagonal(own, np.nan)
    epcs = stop.anchors.epcs[:N]
    matrix = ProximityMatrix(stop.proximity.target_epcs, epcs, measured(tags_m, anchors_m), own, "distance")
    return replace(stop, anchors=TagPositions("base", epcs, anchors_m), proximity=matrix), truth


def test_anchors_in_a_row_leave_the_mirror_image_open():
    for seed in range(6):
        stop, truth = along_a_line(seed)
        posterior = LOCALIZER.infer([stop]).posterior
        beyond = posterior.weight[posterior.poses[:, 1] < 0.0].sum()
        assert beyond == pytest.approx(0.5, abs=0.1)
        assert len(posterior.modes) >= 2
        assert holds(posterior.region(0.9), truth)


def test_one_anchor_is_refused_and_two_leave_a_wide_region():
    stop, _ = along_a_line(9)
    with pytest.raises(DegenerateAnchors):
        LOCALIZER.estimate([replace(stop, anchors=TagPositions("base", ("r0",), stop.anchors.points_m[:1]))])
    two = TagPositions("base", ("r0", "r8"), stop.anchors.points_m[[0, 8]])
    estimate = LOCALIZER.estimate([replace(stop, anchors=two)])
    assert estimate.theta_rad is None
    assert radius_m(estimate.region_m) > 1.0  # a whole half of the bounds


def test_comparisons_that_all_abstain_are_refused():
    stops, _ = scene(10)
    equal = [replace(s, proximity=replace(s.proximity, m=np.ones((4, 9)))) for s in stops]
    with pytest.raises(Infeasible):
        COMPARE.estimate(equal)


@pytest.mark.parametrize("jumped", [0, 1, 2])
def test_odometry_that_jumps_by_3_m_costs_stops_but_not_the_answer(jumped):
    """Were the newest stop to jump, both older ones would contradict it: it alone answers."""
    for seed in range(3):
        stops, truth = scene(seed, base_moves=True)
        stops[jumped] = replace(stops[jumped], base_pose=Pose2(3.0, 0.0, 0.0) @ stops[jumped].base_pose)
        estimate = LOCALIZER.estimate(stops)
        assert estimate.diagnostics["dropped_stops"] == (2 if jumped == 2 else 1)
        assert np.hypot(*(estimate.centre_m - truth.translation_m)) < 0.05


def test_a_part_outside_the_bounds_is_refused():
    stops, _ = scene(11)
    with pytest.raises(Infeasible) as failure:
        PosteriorLocalizer(bounds_m=np.array([[2.0, 3.0], [2.0, 3.0]])).estimate(stops)
    assert failure.value.numbers["border_share"] > 0.45


def test_a_part_far_beyond_the_usual_bounds_is_found_by_its_distances():
    (stop,), _ = scene(12, M=1)
    truth = Pose2(4.5, 1.0, 0.4)
    m = np.linalg.norm(truth.apply(leg_points())[:, None] - stop.anchors.points_m[None], axis=2)
    estimate = LOCALIZER.estimate([replace(stop, proximity=replace(stop.proximity, m=m))])
    assert np.hypot(*estimate.centre_m) == pytest.approx(np.hypot(4.5, 1.0), abs=0.3)


def test_comparisons_that_are_all_wrong_are_refused_or_leave_a_wide_region():
    refused = 0
    for seed in range(20):
        stops, truth = random_stops(np.random.default_rng(seed), flips=1.0)
        try:
            fit = LOCALIZER.fit(stops)
        except Infeasible:
            refused += 1
            continue
        assert radius_m(fit.region_m) > 0.4 or holds(fit.region_m, truth)
    assert refused >= 15


def test_comparisons_with_a_third_flipped_still_lead_to_the_part():
    inside = 0
    for seed in range(10):
        stops, truth = random_stops(np.random.default_rng(seed), flips=0.3)
        inside += holds(LOCALIZER.fit(stops).region_m, truth)
    assert inside >= 7  # of 10 expected at 90 %: fewer than 7 happen once in a hundred times


def test_the_less_odometry_is_worth_the_more_the_newest_stop_counts_alone():
    for seed in range(5):
        stops, _ = scene(seed, base_moves=True, errors=Errors(0.004, 0.001))
        loose = [replace(s, base_covariance=4000.0 * s.base_covariance) for s in stops]
        sure, unsure, alone = (np.trace(LOCALIZER.estimate(o).covariance[:2, :2]) for o in (stops, loose, stops[-1:]))
        assert sure < unsure
        assert unsure == pytest.approx(alone, rel=0.02)  # noise is still fitted on all stops


def test_a_lower_floor_of_the_bias_makes_smaller_regions_where_nothing_is_biased():
    stops, _ = scene(3, K=2, M=1, errors=Errors(0.0, 0.001))
    sharp, plain = (PosteriorLocalizer(least_bias_m=floor_m).estimate(stops) for floor_m in (0.003, 0.01))
    assert radius_m(sharp.region_m) < 0.8 * radius_m(plain.region_m)


@pytest.mark.parametrize(
    "wrong",
    [
        {"use": "guesses"},
        {"tempering": 0.0},
        {"tempering": 1.1},
        {"probability": 1.0},
        {"sample_count": -1},
        {"least_bias_m": 0.0},
    ],
)
def test_settings_that_make_no_sense_are_refused(wrong):
    with pytest.raises(InputError):
        PosteriorLocalizer(**wrong).estimate(scene(13)[0])
    with pytest.raises(InputError):
        LOCALIZER.fit([])
