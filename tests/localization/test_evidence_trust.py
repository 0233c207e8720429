"""Evidence that contradicts itself is found out, evidence that does not is left alone."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated_scenes import biased_stops

from rfcompass.geometry import Pose2
from rfcompass.localization.comparing import compare_proximities
from rfcompass.localization.evidence_trust import MEDIAN_T4, misses, trust
from rfcompass.localization.noise_model import NoiseModel, fit_noise
from rfcompass.localization.part_evidence import comparison_evidence, distance_evidence
from rfcompass.localization.placed_stop import PlacedComparisons, place_stops
from rfcompass.localization.problem import bounds_about


def placed_stops(seed=0, **scene):
    return place_stops(biased_stops(np.random.default_rng(seed), **scene)[0])


def trusted(stops):
    evidence = distance_evidence(stops, {"sar_nearfield": fit_noise(stops)})
    return trust(evidence, bounds_about(np.vstack([stop.anchors_m for stop in stops])))


def jumped(stop, T):
    return replace(stop, anchors_m=T.apply(stop.anchors_m))


def test_what_hangs_together_is_left_alone():
    for seed in range(10):
        found = trusted(placed_stops(seed, M=3, base_moves=True))
        assert found.dropped == ()
        assert found.noise_factor == 1.0


@pytest.mark.parametrize("older", [0, 1])
def test_an_older_stop_whose_odometry_jumped_is_left_out(older):
    for seed in range(5):
        stops = list(placed_stops(seed, M=3, base_moves=True))
        stops[older] = jumped(stops[older], Pose2(3.0, 0.0, 0.0))
        assert trusted(stops).dropped == (older,)


def test_when_the_newest_jumped_the_older_ones_go_because_answers_are_meant_where_it_is():
    stops = list(placed_stops(1, M=3, base_moves=True))
    stops[2] = jumped(stops[2], Pose2(0.0, 3.0, 1.0))
    assert trusted(stops).dropped in ((0, 1), (1, 0))


def test_noise_is_raised_where_the_part_is_heard_worse_than_the_robot():
    rng = np.random.default_rng(2)
    (stop,) = placed_stops(2, M=1)
    noisy = replace(stop, m=np.abs(stop.m + 0.15 * rng.normal(size=stop.m.shape)))
    found = trusted([noisy])
    assert found.noise_factor > 1.5
    after = np.concatenate(misses(found.evidence, found.seen))
    assert np.median(after) == pytest.approx(MEDIAN_T4, rel=0.4)  # places move a little with the new weights


def from_comparisons(flips, seed=3):
    rng = np.random.default_rng(seed)
    compared = []
    for stop in placed_stops(seed, M=3):
        c = compare_proximities(stop.m)
        wrong = rng.uniform(size=len(c)) < flips
        nearer, farther = np.where(wrong, c.farther, c.nearer), np.where(wrong, c.nearer, c.farther)
        chosen = replace(c, nearer=nearer, farther=farther)
        compared.append(PlacedComparisons(stop.anchors_m, stop.part_points_m, chosen, stop.odometry))
    evidence = comparison_evidence(compared, NoiseModel(), 0.5)
    return trust(evidence, bounds_about(np.vstack([one.anchors_m for one in compared])))


def test_the_lapse_rate_follows_the_share_of_wrong_comparisons():
    assert from_comparisons(0.0).wrong_share < 0.1
    assert from_comparisons(0.0).evidence.tables[0][0, 8] == NoiseModel().lapse
    flipped = from_comparisons(0.3)
    assert flipped.wrong_share > 0.2
    assert flipped.evidence.tables[0][0, 8] == pytest.approx(min(1.0, 2.0 * flipped.wrong_share))
